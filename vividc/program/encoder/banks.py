"""Which bank each array should start in, and how far apart its rows should lie, so that accesses of
one cycle meet in few banks.

In a modulo schedule, an access of stage s sees the iteration index s less than one of stage 0 in
the same cycle. Accesses that step through their arrays alike therefore stay a fixed number of banks
apart, and the start of the arrays decides it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

from vividc.arch.fabric import Fabric
from vividc.dfg.regions import Kernel
from vividc.mapper.mapping import Mapping as RegionMapping
from vividc.mapper.resources.banks import Traffic, best_layout

_LOOP: Final = 16.0
"""Iterations of a loop for each run of straight code, where nothing is known of either."""

TRIES: Final = 8
"""Layouts from which the search for the last one begins, while it leaves stalls."""


def traffic_of(
    kernel: Kernel,
    fabric: Fabric,
    mappings: Mapping[int, RegionMapping],
    iterations: Sequence[float] = (),
) -> tuple[Traffic, ...]:
    """The accesses of each mapped region, in the cycles in which they start.

    `iterations`: how many of each region a run is expected to have; none: not known.
    """
    runs = iterations or [_LOOP if region.kind == "loop" else 1.0 for region in kernel.regions]
    return tuple(
        Traffic.of(
            region.dfg,
            fabric.scratchpad,
            mappings[index].ii,
            {node: place.time for node, place in mappings[index].places.items()},
            runs[index],
        )
        for index, region in enumerate(kernel.regions)
    )


def choose_layout(
    kernel: Kernel, traffic: Sequence[Traffic], tries: int = TRIES
) -> tuple[dict[str, int], dict[str, int]]:
    """How far apart the rows of each spaced matrix should lie, in elements modulo those that all
    banks hold, and the start bank of each array parameter and each array of the kernel's own, by
    name; `tries`: from how many layouts the search begins.
    """
    spaced = {param.name: param.per_word for param in kernel.params if param.name in kernel.spaced}
    arrays = [param.name for param in kernel.params if param.ndim]
    own = [local.name for local in kernel.locals]
    return best_layout(traffic, spaced, [*arrays, *own], tries)
