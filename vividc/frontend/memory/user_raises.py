"""What a kernel raises, of conditions that only the run decides: a word that says which exception
it was, and a way out.

What was stored before stays stored, as in numba: the run ends as usual, and whoever launched it
raises the exception.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final
from urllib.parse import unquote

from vividc.frontend.llvm.calls import RAISE_PREFIX, USER_PREFIX, has_hint
from vividc.machine.params import DType, Param
from vividc.ssa.edit import first_free
from vividc.ssa.ir import Branch, Float, Function, Instr, Int, Value
from vividc.ssa.results import NONE, Raise, Results

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
    for block in function.blocks:
        at = next((n for n, op in enumerate(block.instrs) if _is_raise(op)), None)
        if at is None:
            blocks.append(block)
            continue
        op = block.instrs[at]
        raises.append(_raise_of(op))
        store = Instr(op.id, "store", "i32", (Int(len(raises)), Int(0)), array=name, loc=op.loc)
        leave = Branch(value=_NOTHING.get(function.result, Int(0)), loc=op.loc)
        instrs = (*block.instrs[:at], replace(store, shift=2))
        blocks.append(replace(block, instrs=instrs, branch=leave))
    if not raises:
        return function
    results = function.results or Results((), (NONE,))
    param = Param(name, DType.I32, 1, flat=True, made=(1,))
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


def _raise_of(op: Instr) -> Raise:
    what = op.pred.removeprefix(RAISE_PREFIX)
    if op.pred.startswith(USER_PREFIX):
        what = unquote(op.pred.removeprefix(USER_PREFIX))
    kind, _, text = what.partition(":")
    file, line = ("", 0) if op.loc is None else (op.loc.file, op.loc.line)
    return Raise(kind.strip(), text.strip(), file, line)
