"""Refuses graphs whose result would depend on timing."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from vividc.errors import ArgumentError
from vividc.sim.accelerator.steps import Configure, Execute, Step, Transfer, kind_of, tiles_of

Place = tuple[str, int]
"""A memory: ("tile", number) or ("dram", number of the array)."""


@dataclass(frozen=True, slots=True)
class _Use:
    start: int
    end: int
    step: int
    writes: bool


def predecessors(
    steps: Sequence[Step], sharing: Sequence[frozenset[int]] = ()
) -> list[tuple[int, ...]]:
    """What each step waits for: its `after`, for a run the tile's previous run and the
    configuration, and for a run or transfer all those before it of other forms of its tiles
    (`sharing`, by unit).
    """
    last: dict[int, int] = {}
    found: list[tuple[int, ...]] = []
    used: dict[int, list[int]] = defaultdict(list)
    for number, step in enumerate(steps):
        waits = set(step.after)
        if any(sharing) and not isinstance(step, Configure):
            for unit in tiles_of(step):
                waits |= {earlier for other in sharing[unit] for earlier in used[other]}
                used[unit].append(number)
        if isinstance(step, Execute):
            waits.add(step.configured_by)
            if step.tile in last:
                waits.add(last[step.tile])
            last[step.tile] = number
        found.append(tuple(sorted(waits)))
    return found


def check_order(steps: Sequence[Step], waits: Sequence[tuple[int, ...]]) -> None:
    """Any two steps that use the same bytes, one of them writing, must be ordered.

    Raises
    ------
    ArgumentError
        Two steps are not.
    """
    reach = _reachable(waits)
    uses: dict[Place, list[_Use]] = defaultdict(list)
    for number, step in enumerate(steps):
        for place, start, end, writes in _uses(step):
            if end > start:
                uses[place].append(_Use(start, end, number, writes))
    for (kind, index), list_ in uses.items():
        for one, other in _meeting(sorted(list_, key=lambda use: (use.start, use.step))):
            early, late = sorted((one.step, other.step))
            if early != late and not reach[late] >> early & 1:
                where = f"the scratchpad of tile {index}" if kind == "tile" else "one array"
                raise ArgumentError(
                    f"step {late} ({kind_of(steps[late])}) and step {early} "
                    f"({kind_of(steps[early])}) use the same bytes of {where}, and nothing says "
                    "which comes first",
                    hint=f"give step {late} `after=[{early}]`, or other places",
                )


def _reachable(waits: Sequence[tuple[int, ...]]) -> list[int]:
    """For each step the steps before it, as bits."""
    reach: list[int] = []
    for before in waits:
        bits = 0
        for number in before:
            bits |= reach[number] | 1 << number
        reach.append(bits)
    return reach


def _meeting(uses: list[_Use]) -> Iterator[tuple[_Use, _Use]]:
    """Pairs that overlap and of which one writes."""
    open_: list[_Use] = []
    for use in uses:
        open_ = [other for other in open_ if other.end > use.start]
        for other in open_:
            if use.writes or other.writes:
                yield other, use
        open_.append(use)


def _uses(step: Step) -> Iterator[tuple[Place, int, int, bool]]:
    if isinstance(step, Configure):
        return
    if isinstance(step, Execute):
        own = {local.name for local in step.program.locals}
        for name, (start, end) in step.extents.items():
            yield ("tile", step.tile), start, end, name in own
        for start, end in step.stores.values():
            yield ("tile", step.tile), start, end, True
        return
    yield from _transfer_uses(step)


def _transfer_uses(step: Transfer) -> Iterator[tuple[Place, int, int, bool]]:
    out = step.kind == "move out"
    size = step.view.nbytes
    if step.kind == "gather" and step.indices is not None:
        size = len(step.indices) * (step.view[:1].nbytes or 0)
    start, end = step.extent(size)
    for tile in step.tiles:
        yield ("tile", tile), start, end, not out
    for piece in (*step.pieces, *step.index_pieces):
        yield ("dram", piece.buffer), piece.offset, piece.offset + piece.size, out
