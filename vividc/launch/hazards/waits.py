"""What each step of a launch graph waits for."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

from vividc.launch.steps import Configure, Execute, Step, tiles_of


def predecessors(
    steps: Sequence[Step], sharing: Sequence[frozenset[int]] = ()
) -> list[tuple[int, ...]]:
    """What each step waits for: its `after`, for a run the tile's previous run and the
    configuration, and for a run or transfer all those before it of other forms of its tiles
    (`sharing`, by unit).
    """
    last: dict[int, int] = {}
    before: list[tuple[int, ...]] = []
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
        before.append(tuple(sorted(waits)))
    return before
