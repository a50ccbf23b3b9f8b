"""Which accesses of one region may meet in memory, and over how many iterations."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from vividc.dfg.builder import GraphBuilder, Operand
from vividc.machine.lanes import Lane
from vividc.ssa.analysis.alias import different_elements


@dataclass(frozen=True, slots=True)
class Access:
    """One load or store. `base` and `index` identify the address parts that are equal by
    construction.

    `stride_bytes` None: the address is not affine in the iteration index; it may be any address of
    the array. The access covers `width` bytes from its address on. `distinct`: two accesses that
    say so, of equal address parts, meet in one iteration only, or in an earlier one of the first
    and a later one of the second. `subscript`, `lane`: as of `cfg.Instr`.
    """

    node: Operand
    array: str
    is_store: bool
    base: object
    index: object
    offset: int
    stride_bytes: int | None
    block: str = ""
    width: int = 4
    distinct: bool = False
    subscript: tuple[int | None, ...] = ()
    lane: Lane | None = None


Exclusive = Callable[[str, str], bool]
"""Whether no iteration runs both blocks."""


def order_accesses(
    builder: GraphBuilder,
    accesses: list[Access],
    *,
    loop: str = "",
    exclusive: Exclusive = lambda first, second: False,
) -> None:
    """Adds ORDER edges between accesses (in program order) that may touch the same byte, at least
    one a store.

    Arrays passed as different arguments do not overlap. Affine accesses get their exact distance;
    others are kept in program order within an iteration and from each iteration to the next.
    Accesses of different threads in a loop of theirs are independent.

    Parameters
    ----------
    loop
        The header of the loop whose iteration the graph is; empty for straight code.
    """
    for position, first in enumerate(accesses):
        for second in accesses[position:]:
            if first.array != second.array or not (first.is_store or second.is_store):
                continue
            if first.lane is not None and first.lane.independent_of(second.lane, loop):
                continue
            apart = first is not second and exclusive(first.block, second.block)
            assumed = not _is_known(first, second)
            for before, after, distance in _dependences(first, second, bool(loop), apart):
                builder.order(before.node, after.node, distance, assumed=assumed)


def _is_known(first: Access, second: Access) -> bool:
    """Whether it is proved in which iterations the accesses meet."""
    return _step_alike(first, second) or _never_comes_back(first, second)


def _dependences(
    first: Access, second: Access, in_loop: bool, apart: bool
) -> Iterator[tuple[Access, Access, int]]:
    """(before, after, distance); accesses `apart` never meet in one iteration."""
    same = first is second
    if different_elements(first.subscript, second.subscript):
        return
    if _never_comes_back(first, second):
        if not same and not apart:
            yield first, second, 0
        return
    if _step_alike(first, second):
        if first.stride_bytes:
            yield from _stepping(first, second, meet_now=not (same or apart))
            return
        if not -second.width < second.offset - first.offset < first.width:
            return
    if not same:
        yield first, second, int(apart)
    if in_loop:
        yield second, first, 1


def _step_alike(first: Access, second: Access) -> bool:
    """Whether the accesses stay the same number of bytes apart."""
    return (
        first.stride_bytes is not None
        and first.stride_bytes == second.stride_bytes
        and first.base == second.base
        and first.index == second.index
    )


def _stepping(
    first: Access, second: Access, *, meet_now: bool
) -> Iterator[tuple[Access, Access, int]]:
    """Accesses that move by one stride: the nearest iteration on either side in which they meet.

    `second` in iteration i + k starts gap + k * stride bytes behind `first` in iteration i; they
    share a byte iff -second.width < gap + k * stride < first.width. Farther iterations that meet
    too are kept in order by the nearest one.
    """
    assert first.stride_bytes is not None
    stride, gap = abs(first.stride_bytes), second.offset - first.offset
    lowest = (-second.width - gap) // stride + 1
    highest = -((gap - first.width) // stride) - 1
    if first.stride_bytes < 0:
        lowest, highest = -highest, -lowest
    later = max(lowest, 0 if meet_now else 1)
    if later <= highest:
        yield first, second, later
    earlier = min(highest, -1)
    if lowest <= earlier and first is not second:
        yield second, first, -earlier


def _never_comes_back(first: Access, second: Access) -> bool:
    """Whether nothing that `second` has touched is touched by `first` afterwards."""
    return (
        first.distinct
        and second.distinct
        and first.width == second.width
        and (first.base, first.index, first.offset) == (second.base, second.index, second.offset)
    )
