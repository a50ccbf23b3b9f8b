"""What is left of a loop's last iterations when the straight region behind it begins."""

from __future__ import annotations

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG
from vividc.mapper.mapping import Mapping
from vividc.mapper.problem import ConstantKey, Drain
from vividc.mapper.resources.taken import taken_of, uses_of


def drain_of(dfg: DFG, fabric: Fabric, mapping: Mapping, begin: int, cycles: int) -> Drain:
    """The drain of a counted loop without an exit.

    Parameters
    ----------
    begin
        Cycle of the last iteration in which the region behind the loop begins, at least the II.
    cycles
        Of that region until nothing of the loop is left: the loop's span is `begin + cycles`.
    """

    def after(time: int) -> range:
        return range(time - begin, -1, -mapping.ii)

    taken = taken_of(dfg, fabric, mapping, after)
    words = frozenset(word for word in taken.words if word[-1] <= cycles)
    read: dict[tuple[int, ConstantKey], int] = {}
    written: dict[tuple[int, ConstantKey], int] = {}
    for use in uses_of(dfg, fabric, mapping):
        cycle, at = use.time - begin, (use.pe, use.key)
        if cycle < 0:
            continue
        if use.writes:
            written[at] = max(written.get(at, 0), cycle + 1)
        else:
            read[at] = max(read.get(at, 0), cycle)
    return Drain(
        **{**vars(taken), "words": words},
        cycles=cycles,
        entries_read=frozenset((*at, cycle) for at, cycle in read.items()),
        entries_written=frozenset((*at, cycle) for at, cycle in written.items()),
    )
