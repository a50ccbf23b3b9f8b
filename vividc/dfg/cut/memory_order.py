"""Which accesses of one region may meet in memory, and over how many iterations."""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from vividc.dfg.builder import GraphBuilder, Operand
from vividc.machine.opcodes import Opcode
from vividc.machine.params import TRAP
from vividc.ssa.analysis.strides import different_elements
from vividc.ssa.polyhedral.distances.linear import Distances, Place
from vividc.ssa.polyhedral.distances.meetings import Meetings


@dataclass(frozen=True, slots=True)
class Access:
    """One load or store, and its node."""

    node: Operand
    place: Place

    @property
    def array(self) -> str:
        """The array that it is to."""
        return self.place.instr.array

    @property
    def is_store(self) -> bool:
        """Whether it writes."""
        return self.place.instr.op is Opcode.STORE

    @property
    def raises(self) -> bool:
        """Whether it stands for an exception."""
        return self.array.startswith(TRAP)


_FOREVER: Final = 1 << 14
"""Iterations that no schedule has under way at once."""
Exclusive = Callable[[str, str], bool]
"""Whether no iteration runs both blocks."""


def order_accesses(
    builder: GraphBuilder,
    accesses: list[Access],
    meetings: Meetings,
    exclusive: Exclusive = lambda first, second: False,
) -> None:
    """Adds ORDER edges between accesses (in program order) that may touch the same byte, at least
    one a store: from iteration to iteration of a loop, or in straight code.

    Arrays passed as different arguments do not overlap. Accesses whose distance is known keep it;
    others are kept in program order within an iteration and from each iteration to the next.
    Accesses of different threads in a loop of theirs are independent. In straight code those that
    stand for an exception are behind all before them, and before all others: the first one counts.
    """
    header = "" if meetings.loop is None else meetings.loop.header
    for first, second in _pairs(accesses, in_loop=bool(header)):
        if not header and (first.raises or second.raises):
            builder.order(first.node, second.node, 0)
            continue
        lane = first.place.instr.lane
        if lane is not None and lane.independent_of(second.place.instr.lane, header):
            continue
        now = first is not second and not exclusive(first.place.block, second.place.block)
        found = _distances(first, second, meetings, header, now=now)
        later, earlier = found.later, found.earlier
        if later is not None and later < _FOREVER:
            builder.order(first.node, second.node, later, assumed=found.assumed)
        if earlier is not None and earlier < _FOREVER and first is not second:
            builder.order(second.node, first.node, earlier, assumed=found.assumed)


def _pairs(accesses: Sequence[Access], *, in_loop: bool) -> Iterator[tuple[Access, Access]]:
    """Accesses in their order, each with those behind it that it may have to be ordered with: of
    its array, one of the two a store, in a loop itself, too; in straight code each with those that
    stand for an exception. Most pairs of a region are of other arrays, or two loads.
    """
    if not in_loop and any(access.raises for access in accesses):
        for first, second in itertools.combinations(accesses, 2):
            is_written = first.array == second.array and (first.is_store or second.is_store)
            if first.raises or second.raises or is_written:
                yield first, second
        return
    behind: dict[str, deque[Access]] = {}
    stores: dict[str, deque[Access]] = {}
    for access in accesses:
        behind.setdefault(access.array, deque()).append(access)
        if access.is_store:
            stores.setdefault(access.array, deque()).append(access)
    for first in accesses:
        left, written = behind[first.array], stores.get(first.array, ())
        if first.is_store and in_loop:
            yield first, first
        left.popleft()
        if first.is_store:
            stores[first.array].popleft()
        for second in left if first.is_store else written:
            yield first, second


def _distances(
    first: Access, second: Access, meetings: Meetings, header: str, *, now: bool
) -> Distances:
    one, other = first.place.instr, second.place.instr
    if different_elements(one.subscript, other.subscript):
        return Distances()
    distinct = header and one.distinct == other.distinct == header
    if distinct and _is_one_address(first.place, second.place):
        return Distances(0 if now else None)  # nothing that the second touched comes back
    return meetings.between(first.place, second.place, now=now)


def _is_one_address(first: Place, second: Place) -> bool:
    one, other = first.instr, second.instr
    same = (one.operands[:2], one.shift, one.offset, one.width)
    return same == (other.operands[:2], other.shift, other.offset, other.width)
