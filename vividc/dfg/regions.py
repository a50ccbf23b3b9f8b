"""The kernel as regions under the tile controller: what the mapper maps one by one, and what runs
in which order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

from vividc.dfg.ir import DFG
from vividc.errors import SourceLoc
from vividc.machine.params import HIGH_SUFFIX, DType, LocalArray, Param
from vividc.ssa.results import Results

RETURN_VARIABLE = "%return"
RETURN_HIGH = RETURN_VARIABLE + HIGH_SUFFIX


@dataclass(frozen=True)
class Region:
    """A basic (straight) region, or an innermost loop.

    Attributes
    ----------
    counted
        Loop: the controller issues as many iterations as the trip register says (none if it is
        negative). A loop that is not counted, and a counted one that may break, has a node marked
        `Control.EXIT`.
    next
        Index of the region that runs next; None: the program ends.
    header
        The block of the CFG that it was cut from; a loop's header.
    branch
        Straight: index of the region that runs next if the node marked `Control.BRANCH` gives 1.
    drain
        Counted loop, once it is mapped: cycles before its end in which the region behind it begins.
    """

    name: str
    kind: Literal["loop", "straight"]
    dfg: DFG
    next: int | None = None
    branch: int | None = None
    counted: bool = False
    header: str = ""
    loc: SourceLoc | None = field(default=None, compare=False)
    drain: int = 0


def loops_before(regions: Sequence[Region]) -> dict[int, int]:
    """By straight region, the loop under whose last iterations it may begin: of counted loops
    without an exit behind which it runs, the first.
    """
    found: dict[int, int] = {}
    for index, region in enumerate(regions):
        after = region.next
        if after is None or regions[after].kind != "straight" or not region.counted:
            continue
        if all(node.control is None for node in region.dfg.nodes):
            found.setdefault(after, index)
    return found


@dataclass(frozen=True)
class Kernel:
    """Regions in table order; region 0 runs first.

    A `live_in` node names an input the host supplies (see `cfg.Input.key`) or a variable. Variables
    start with "%", are written by `live_out` nodes of that name and keep their word until written
    again. A returned scalar is the variable `RETURN_VARIABLE` when the program ends, and an integer
    of 64 bits that one word may not hold has its high word in `RETURN_HIGH`. Within a region, every
    read of a variable sees the word from before the region (a straight region's writes take effect
    after its reads; a loop never reads a variable that it writes). `spaced`, `results`: as of
    `ssa.Function`.
    """

    name: str
    params: tuple[Param, ...]
    regions: tuple[Region, ...]
    returns: DType | None = None
    file: str = ""
    locals: tuple[LocalArray, ...] = ()
    spaced: frozenset[str] = frozenset()
    results: Results | None = None


def is_variable(name: str) -> bool:
    """Whether a live-in name is a variable of the kernel and not an input from the host."""
    return name.startswith("%")
