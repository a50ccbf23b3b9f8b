"""Functions in tests of passes: read from short texts, printed with values numbered in order, and
run on random arguments (see `tests.rules`).
"""

from __future__ import annotations

import copy
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from tests.rules import Language
from vividc.errors import SSAError
from vividc.machine.parallel import Term
from vividc.machine.params import Param
from vividc.ssa.check import check_function
from vividc.ssa.edit import map_values
from vividc.ssa.flow import Loop, find_loops
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Block, Function, Ref, Value
from vividc.ssa.text import parse, to_text

_BLOCKS = 4000
_SIZES = {0: (), 1: (64,), 2: (6, 8), 3: (3, 4, 4)}
_FLOATS = (0.0, -0.0, 1.0, -2.5, 3.25, 1e-3, 1e9, float("inf"), float("nan"))


def function(text: str) -> Function:
    """A function whose first lines may be left out: its name, its parameters, what it returns."""
    if text.startswith("function"):
        return parse(text)
    returns = " returns int32" if re.search(r"^ *return .", text, re.MULTILINE) else ""
    given = set(re.findall(r'^(?:param|local) "([^"]+)"', text, re.MULTILINE))
    params = [line for name, line in _parameters(text) if name not in given]
    return parse(f'function "f" file "f.py"{returns}\n' + "".join(params) + text)


def _parameters(text: str) -> Iterator[tuple[str, str]]:
    for name in dict.fromkeys(re.findall(r'\$"([^"]+)"', text)):
        if name.startswith("&"):
            is_float = re.search(rf'f32 = load \$"{name}"', text)
            yield name[1:], f'param "{name[1:]}" {"float32" if is_float else "int32"}[1]\n'
        elif "." not in name:
            yield name, f'param "{name}" int32\n'


def text_of(made: Function, before: Function) -> str:
    """The text of `made`, with values numbered in order; without the heading that both have."""
    text, heading = to_text(_numbered(made)), _heading(before)
    return text.removeprefix(heading)


def _heading(given: Function) -> str:
    lines = to_text(given).splitlines(keepends=True)
    return "".join(lines[: 1 + len(given.params) + len(given.locals)])


def _numbered(given: Function) -> Function:
    items = (item for block in given.blocks for item in block.items)
    idents = {item.id: number for number, item in enumerate(items)}

    def change(value: Value) -> Value:
        return Ref(idents[value.id]) if isinstance(value, Ref) else value

    def renumbered(block: Block) -> Block:
        block = map_values(block, change)
        phis = tuple(replace(phi, id=idents[phi.id]) for phi in block.phis)
        instrs = tuple(replace(instr, id=idents[instr.id]) for instr in block.instrs)
        return replace(block, phis=phis, instrs=instrs)

    return replace(given, blocks=tuple(map(renumbered, given.blocks)))


def demand_same(before: Function, after: Function, tries: int = 12) -> None:
    """Fails unless both leave the same memory and result on random arguments.

    Some arrays are empty: what is not read then must not be read afterwards. Arguments on which the
    first one leaves its arrays or does not end count for nothing; if that is most of them, the test
    is no test.
    """
    rng = np.random.default_rng(1)
    counted = 0
    for _ in range(tries):
        is_empty = rng.random() < 1 / 6
        args = [_argument(param, rng, is_empty=is_empty) for param in before.params]
        expected = _outcome(before, args)
        if expected is not None:
            counted += 1
            assert _outcome(after, args) == expected, args
    assert 2 * counted >= tries, f"only {counted} of {tries} runs count"


def _outcome(given: Function, args: list[object]) -> tuple[object, ...] | None:
    args = copy.deepcopy(args)
    try:
        result = interpret(given, *args, max_blocks=_BLOCKS)
    except SSAError:
        return None
    arrays = (arg.tobytes() for arg in args if isinstance(arg, np.ndarray))
    return (np.asarray(result).tobytes(), *arrays)


def _argument(param: Param, rng: np.random.Generator, *, is_empty: bool) -> object:
    dtype = np.dtype(param.dtype.value)
    shape = (0,) * param.ndim if is_empty else _SIZES[param.ndim]
    if dtype.kind == "f":
        plain = rng.integers(-9, 9, shape) / 4
        some = np.where(rng.random(shape) < 1 / 4, rng.choice(_FLOATS, shape), plain)
        return some.astype(dtype)[()]
    small = rng.integers(0 if dtype.kind == "u" or not shape else -4, 9, shape)
    return np.asarray(small).astype(dtype)[()]


def loop_at(given: Function, header: str) -> Loop:
    """The loop with this header."""
    return next(loop for loop in find_loops(given) if loop.header == header)


def term_text(terms: Sequence[Term], number: int) -> str:
    """A term of `vividc.machine.parallel` as nested calls."""
    one = terms[number]
    args = ", ".join(term_text(terms, arg) for arg in one.args)
    word = str(one.word) if one.op in ("const", "any") else one.key
    return f"{one.op}({args or word})"


FUNCTIONS = Language(function, text_of, check_function, demand_same)
