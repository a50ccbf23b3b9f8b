"""The kernel as regions under the tile controller: what the mapper maps one by one, and what runs
in which order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, Protocol

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
    fill
        Straight region, once it is mapped: cycles before its end in which the loop behind it
        begins (`loop_behind`).
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
    fill: int = 0

    @property
    def counts_alone(self) -> bool:
        """Whether it is a counted loop without an exit."""
        is_counted = self.kind == "loop" and self.counted
        return is_counted and all(node.control is None for node in self.dfg.nodes)


def loops_before(regions: Sequence[Region]) -> dict[int, int]:
    """By straight region, the loop under whose last iterations it may begin: of counted loops
    without an exit behind which it runs, the first.
    """
    found: dict[int, int] = {}
    for index, region in enumerate(regions):
        after = region.next
        if after is not None and regions[after].kind == "straight" and region.counts_alone:
            found.setdefault(after, index)
    return found


class Row(Protocol):
    """A region as far as it matters which one follows."""

    @property
    def kind(self) -> Literal["loop", "straight"]:
        """What it is."""

    @property
    def next(self) -> int | None:
        """The region that runs next."""

    @property
    def branch(self) -> int | None:
        """The one that runs next if a branch is taken."""

    @property
    def counts_alone(self) -> bool:
        """Whether it is a counted loop without an exit."""


def loop_behind(rows: Sequence[Row], index: int) -> int | None:
    """The loop that may begin while a straight region ends: a counted loop without an exit, the
    only loop that may follow.
    """
    row = rows[index]
    targets = {one for one in (row.next, row.branch) if one is not None}
    loops = [one for one in targets if rows[one].kind == "loop"]
    is_one = row.kind == "straight" and len(loops) == 1 and rows[loops[0]].counts_alone
    return loops[0] if is_one else None


def least_trips(fill: int, ii: int, span: int, drain: int) -> int:
    """Iterations with which a loop does not end before a region does in whose last `fill` cycles it
    begins; the other numbers are the loop's.
    """
    return 1 + max(0, -(-(fill - span + drain) // ii))


def runs_into(rows: Sequence[Row], region: int, loop: int, runs: Sequence[float]) -> float:
    """How often a loop runs behind a straight region, by how often each region runs: as often as
    it does, but for what runs behind regions that nothing else can follow.
    """
    if rows[region].branch is None:
        return runs[region]
    others = sum(
        runs[index]
        for index, row in enumerate(rows)
        if row.next == loop and row.branch is None and index != loop
    )
    return max(0.0, min(runs[region], runs[loop] - others))


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
