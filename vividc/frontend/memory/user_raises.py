"""What a kernel raises, of conditions that only the run decides: a word that says which exception
it was, and a way out.

What was stored before stays stored, as in numba: the run ends as usual, and whoever launched it
raises the exception.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final
from urllib.parse import unquote

import numpy as np

from vividc.frontend.llvm.calls import RAISE_PREFIX, USER_PREFIX, has_hint
from vividc.machine.params import DType, Param
from vividc.ssa.edit import FreshIds, first_free
from vividc.ssa.ir import Branch, Float, Function, Instr, Int, Ref, Value
from vividc.ssa.results import NONE, PLACE, Raise, Results

_ERROR: Final = "return.error"
_NOTHING: Final[dict[str, Value | None]] = {
    "void": None,
    "float": Float(0.0),
    "double": Float(0.0),
}


def hold_raises(function: Function) -> Function:
    """Make stores of the raises that are left: those that prove unreachable are gone before."""
    raises: list[Raise] = []
    name = first_free({param.name for param in function.params}, _ERROR)
    blocks = []
    ids = FreshIds(function)
    for block in function.blocks:
        at = next((n for n, op in enumerate(block.instrs) if _is_raise(op)), None)
        if at is None:
            blocks.append(block)
            continue
        op = block.instrs[at]
        raises.append(_raise_of(op))
        store = Instr(op.id, "store", "i32", (Int(len(raises)), Int(0)), array=name, shift=2)
        leave = Branch(value=_NOTHING.get(function.result, Int(0)), loc=op.loc)
        numbers = _stores_of(op, raises[-1].numbers, store, ids)
        instrs = (*block.instrs[:at], replace(store, loc=op.loc), *numbers)
        blocks.append(replace(block, instrs=instrs, branch=leave))
    if not raises:
        return function
    results = function.results or Results((), (NONE,))
    words = 1 + 2 * max(len(one.numbers) for one in raises)
    param = Param(name, DType.I32, 1, flat=True, made=(words,))
    return replace(
        function,
        blocks=tuple(blocks),
        params=(*function.params, param),
        results=replace(results, made=(*results.made, name), error=name, raises=tuple(raises)),
    )


def _is_raise(op: Instr) -> bool:
    """A raise of the user's, or one of numba's own that has no hint: others are refused with it."""
    if op.op != "call":
        return False
    numbas = op.pred.startswith(RAISE_PREFIX) and not has_hint(op.pred)
    return numbas or op.pred.startswith(USER_PREFIX)


def _stores_of(op: Instr, kinds: Sequence[str], store: Instr, ids: FreshIds) -> Iterator[Instr]:
    """What stores the words of the numbers that a raise is called with, and computes them."""
    place = 1
    for value, kind in zip(op.operands, kinds, strict=True):
        computed, words = _words_of(value, kind, ids)
        yield from (replace(one, loc=op.loc) for one in computed)
        for at, word in enumerate(words, place):
            yield replace(store, id=ids(), operands=(word, Int(at)), loc=op.loc)
        place += 2


def _words_of(
    value: Value, kind: str, ids: FreshIds
) -> tuple[tuple[Instr, ...], tuple[Value, ...]]:
    """A float's word, or the two of an integer, low word first, and what computes them."""
    if isinstance(value, Float):
        return (), (Int(int(np.float32(value.value).view(np.int32))),)
    if isinstance(value, Int):
        low, high = np.array([value.value], np.int64).view(np.int32).tolist()
        return (), (Int(low), Int(high))
    if kind == "float":
        word = Instr(ids(), "bitcast", "i32", (value,), source="float")
        return (word,), (Ref(word.id),)
    low = Instr(ids(), "trunc", "i32", (value,), source="i64")
    down = Instr(ids(), "lshr", "i64", (value, Int(32)))
    high = replace(low, id=ids(), operands=(Ref(down.id),))
    return (low, down, high), (Ref(low.id), Ref(high.id))


def _raise_of(op: Instr) -> Raise:
    what = op.pred.removeprefix(RAISE_PREFIX)
    if op.pred.startswith(USER_PREFIX):
        what = unquote(op.pred.removeprefix(USER_PREFIX))
    *numbers, what = what.removeprefix(PLACE).split(PLACE, len(op.operands))
    kind, _, text = what.partition(":")
    file, line = ("", 0) if op.loc is None else (op.loc.file, op.loc.line)
    return Raise(kind.strip(), text.strip(), file, line, tuple(numbers))
