"""What a kernel of matrix products may do besides: checks of sizes that raise, as in `np.dot`, if
no sizes for which its products are defined fail them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product as combinations

from vividc.machine.opcodes import MEMORY, Opcode
from vividc.machine.params import TRAP
from vividc.machine.product import Axis, Range, Size, Step
from vividc.machine.semantics import evaluate
from vividc.ssa.edit import block_of
from vividc.ssa.flow import Loop
from vividc.ssa.ir import Const, Function, Input, Instr, Value, definition_of
from vividc.ssa.parallel.products.effects import NoProduct

_CHECKED = range(1, 4)
"""Sizes with which checks of sizes are tried."""
_MOST_CLASSES = 6
"""So many sizes that differ are tried in all combinations."""
_COMPARISONS = frozenset({Opcode.ICMP_EQ, Opcode.ICMP_NE, Opcode.AND, Opcode.OR})


def demand_only_checks(function: Function, steps: Sequence[Step], outer: Sequence[Loop]) -> None:
    """Nothing is around the loops but checks that sizes pass for which the steps are defined.

    Raises
    ------
    NoProduct
        There is something else.
    """
    inside = {name for loop in outer for name in loop.blocks}
    classes = _classes(steps)
    for block in function.blocks:
        if block.name in inside:
            continue
        accesses = (i for i in block.instrs if i.op in MEMORY and not i.array.startswith(TRAP))
        if next(accesses, None) is not None:
            raise NoProduct("it reads or writes memory outside its loops")
        if block.branch.cond is None:
            continue
        raising = [name for name in block.branch.successors if _raises(function, name)]
        if len(raising) != 1:
            raise NoProduct("there is a condition around its loops")
        taken = int(block.branch.target == raising[0])
        for words in _words(classes):
            if _word(function, block.branch.cond, words) == taken:
                raise NoProduct("a check before its loops asks for certain sizes")


def _raises(function: Function, name: str) -> bool:
    """Whether a block raises, whatever else it does."""
    instrs = block_of(function, name).instrs
    return any(i.op is Opcode.STORE and i.array.startswith(TRAP) for i in instrs)


def _classes(steps: Sequence[Step]) -> list[set[str]]:
    """Sizes that are equal where the steps run over whole arrays, by input key."""
    classes: list[set[str]] = []
    for one, other in _equal(steps):
        joined = {one, other}.union(*(c for c in classes if one in c or other in c))
        classes = [*(c for c in classes if joined.isdisjoint(c)), joined]
    return classes


def _equal(steps: Sequence[Step]) -> Iterator[tuple[str, str]]:
    for step in steps:
        for view in (step.result, *step.views):
            for number, axis in enumerate(view.axes):
                limit = _whole(axis, step.ranges)
                if limit is not None:
                    yield f"{view.array}.shape{number}", limit


def _whole(axis: Axis, ranges: Sequence[Range]) -> str | None:
    """The size that a subscript goes up to, from 0 in steps of 1, if it is one number."""
    if axis.coordinate < 0 or (axis.factor, axis.offset) != (1, Size()):
        return None
    first, limit = ranges[axis.coordinate].first, ranges[axis.coordinate].limit
    is_one = first == Size() and not limit.constant and [f for _, f in limit.terms] == [1]
    return limit.terms[0][0] if is_one else None


def _words(classes: Sequence[set[str]]) -> Iterator[Mapping[str, int]]:
    for sizes in combinations(_CHECKED, repeat=min(len(classes), _MOST_CLASSES)):
        numbers = (*sizes, *[1] * (len(classes) - len(sizes)))
        yield {key: n for c, n in zip(classes, numbers, strict=True) for key in c}


def _word(function: Function, value: Value, words: Mapping[str, int]) -> int:
    value = function.settled(value)
    if isinstance(value, Const) and value.word < _CHECKED.stop:
        return value.word
    if isinstance(value, Input) and value.key in words:
        return words[value.key]
    item = definition_of(function, value)
    if isinstance(item, Instr) and item.op in _COMPARISONS:
        return evaluate(item.opcode, [_word(function, v, words) for v in item.operands])
    raise NoProduct("a check before its loops is not one of the matrices' sizes")
