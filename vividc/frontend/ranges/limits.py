"""Limits of counted loops as words: `range(n - 1)` of an integer of 32 bits has a limit of 64, as n
may be the least of all.

A counter that is never below K is below a limit where it is below the greater of the limit and K.
That one fits a word, if the limit is only too low for one.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace

from vividc.frontend.ranges.interval import S32, contains
from vividc.frontend.ranges.known import ranges_of
from vividc.frontend.ranges.ranges import Ranges
from vividc.ssa.edit import FreshIds
from vividc.ssa.ir import Function, Instr, Int, Phi, Ref, Value, definition_of

_WIDE = "i64"
_LIMIT_AT = {"slt": 1, "sge": 1, "sgt": 0, "sle": 0}
"""Which operand is the limit, where the other one is below it or not."""


def clamp_limits(function: Function) -> Function:
    """The function with limits of its loops' counters that fit words where that is the same."""
    if not any(phi.type == _WIDE for block in function.blocks for phi in block.phis):
        return function
    clamps = _Clamps(function)
    tests = {
        op.id: new for block in function.blocks for op in block.instrs for new in clamps.of(op)
    }
    if not tests:
        return function
    blocks = []
    for block in function.blocks:
        instrs = []
        for op in block.instrs:
            instrs += [tests.get(op.id, op), *clamps.behind[op.id]]
        blocks.append(replace(block, instrs=tuple(instrs)))
    return replace(function, blocks=tuple(blocks))


class _Clamps:
    """`behind`: what computes a limit as a word, behind what computes it in 64 bits."""

    def __init__(self, function: Function) -> None:
        self.behind: dict[int, list[Instr]] = defaultdict(list)
        self._function = function
        self._ids = FreshIds(function)
        self._ranges: Ranges = ranges_of(function)
        self._made: dict[tuple[int, int], Ref] = {}

    def of(self, test: Instr) -> Iterator[Instr]:
        """The comparison of a counter with a limit as a word; nothing if it stays as it is."""
        at = _LIMIT_AT.get(test.pred)
        if test.op != "icmp" or test.type != _WIDE or at is None:
            return
        limit, counter = test.operands[at], test.operands[1 - at]
        phi, made = (definition_of(self._function, value) for value in (counter, limit))
        home = self._function.block_of[test.id]
        if not isinstance(phi, Phi) or not isinstance(made, Instr):
            return
        body = self._ranges.flow.loops.get(self._function.block_of[phi.id], frozenset())
        # Where it is made: in a loop inside, that the one around goes on would say more of it.
        low, high = self._ranges.at(limit, self._function.block_of[made.id])
        least = self._ranges.at(counter, home)[0]
        is_too_low = low < S32[0] <= least and high <= S32[1]
        if home not in body or self._function.block_of[made.id] in body or not is_too_low:
            return
        word = self._word(made, 0 if least >= 0 else S32[0])
        yield replace(test, operands=(word, counter) if at == 0 else (counter, word))

    def _word(self, limit: Instr, least: int) -> Ref:
        """The greater of a limit and a constant: of n - 1 and 0 the greater of n and 1, less 1."""
        key = limit.id, least
        if key in self._made:
            return self._made[key]
        value, by = limit.operands if limit.op == "add" else (Ref(limit.id), Int(0))
        whole: Value = value
        if not isinstance(by, Int) or not self._is_word(value, by.value, least, limit):
            whole, by = Ref(limit.id), Int(0)
        made = Instr(
            self._ids(),
            "call",
            _WIDE,
            (whole, Int(least - by.value)),
            pred="llvm.smax.i64",
            loc=limit.loc,
        )
        self.behind[limit.id].append(made)
        if by.value:
            nsw = frozenset({"nsw"})
            sum_ = (Ref(made.id), by)
            made = Instr(self._ids(), "add", _WIDE, sum_, flags=nsw, loc=limit.loc)
            self.behind[limit.id].append(made)
        self._made[key] = Ref(made.id)
        return self._made[key]

    def _is_word(self, value: Value, by: int, least: int, limit: Instr) -> bool:
        """Whether a value is a word, and what it is compared with."""
        home = self._function.block_of[limit.id]
        return contains(S32, self._ranges.at(value, home)) and contains(S32, (least - by,) * 2)
