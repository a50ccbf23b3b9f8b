"""The rows of a program's tables: regions, launch words, debug information, reports, provenance."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from vividc.dfg import DFG
from vividc.dfg.regions import least_trips
from vividc.errors import BundleError, SourceLoc
from vividc.mapper.bounds.refutations import ASSUMED, IF_THEY_MEET, rests_on_assumed
from vividc.mapper.mapping import Mapping
from vividc.mapper.result import MapResult
from vividc.program.design import read_graph, read_result

RegionKind = Literal["loop", "straight"]


@dataclass(frozen=True, slots=True)
class RegionRow:
    """A row of the tile controller's region table (docs/machine.md).

    Attributes
    ----------
    context
        First context.
    ii
        Contexts of the region: the II of a loop, the length of a straight region.
    span
        Cycles from an iteration's first issue to its last completion, control latency included.
    stages
        Live bits the region uses.
    next, branch
        Index of the row that runs next, and of the one to branch to; None: the program ends, there
        is no branch.
    drain
        Of a counted loop: cycles before its end in which the row behind it begins, whose words hold
        what is left of the loop (see `overlaps`).
    fill
        Of a straight region: cycles before its end in which the loop behind it begins, if that has
        as many iterations as `least_trips` says; its words hold what the loop does then.
    """

    kind: RegionKind
    context: int
    ii: int
    span: int
    stages: int
    counted: bool
    has_exit: bool
    next: int | None
    branch: int | None
    drain: int = 0
    fill: int = 0

    @property
    def counts_alone(self) -> bool:
        """Whether it is a counted loop without an exit."""
        return self.kind == "loop" and self.counted and not self.has_exit

    def begun(self, cycles: int) -> int:
        """Iterations of the loop that begin in its first so many cycles."""
        return -(-cycles // self.ii)

    def least_trips(self, fill: int) -> int:
        """Iterations with which the loop does not end before a region does in whose last `fill`
        cycles it begins.
        """
        return least_trips(fill, self.ii, self.span, self.drain)


@dataclass(frozen=True, slots=True)
class LaunchRow:
    """The host writes the word of `key` (see `ssa.ir.Input`) to `entry` of PE `pe` at launch."""

    pe: int
    entry: int
    key: str


@dataclass(frozen=True, slots=True)
class Home:
    """A constant-store entry."""

    pe: int
    entry: int


@dataclass(frozen=True, slots=True)
class DebugRow:
    """What a configuration entry was made from.

    Attributes
    ----------
    role
        "issue": the FU's operation; "live_out": the write to the constant store.
    node
        Id of the DFG node.
    op
        Opcode name.
    name
        Array of a load or store, variable of a live-out.
    """

    region: int
    slot: int
    pe: int
    role: Literal["issue", "live_out"]
    node: int
    op: str
    name: str = ""
    loc: SourceLoc | None = None


@dataclass(frozen=True, slots=True)
class BoundReport:
    """A proved lower bound on the II, in words."""

    name: str
    ii: int
    reason: str


@dataclass(frozen=True, slots=True)
class RefutationReport:
    """Why one II is impossible."""

    ii: int
    by: str


@dataclass(frozen=True, slots=True)
class RegionReport:
    """What the compiler achieved on one region, and what it proved about it.

    Attributes
    ----------
    ii
        Initiation interval of a loop; length in cycles of a straight region.
    mii
        Largest of `bounds`.
    lower_bound
        No smaller II exists: `bounds` and `refuted` prove it.
    status
        "optimal" if every II below `ii` was refuted, else "feasible".
    utilization
        Share of the FU issue slots that the region takes, 0 .. 1 (`mapper.utilization`).
    wall_s
        Seconds the mapper spent; None in a loaded program, as files are reproducible.
    stalls
        Expected cycles of an iteration in which the tile stands still as accesses meet in a bank.
    design, fabric_yaml
        The graph and the mapping as text (`program.design`), and the fabric that this is for, which
        a file has once; "" in a program of before them.
    """

    name: str
    kind: RegionKind
    ii: int
    mii: int
    lower_bound: int
    status: Literal["optimal", "feasible"]
    utilization: float
    operations: int
    span: int
    stages: int
    mapper: str = ""
    bounds: tuple[BoundReport, ...] = ()
    refuted: tuple[RefutationReport, ...] = ()
    loc: SourceLoc | None = None
    wall_s: float | None = field(default=None, compare=False)
    stalls: float = 0.0
    design: str = field(default="", repr=False)
    fabric_yaml: str = field(default="", repr=False, compare=False)

    @property
    def dfg(self) -> DFG:
        """The region's dataflow graph, as it was mapped.

        Raises
        ------
        BundleError
            The program was compiled by a version that kept none, or its file was changed.
        """
        return read_graph(self._design())

    @property
    def result(self) -> MapResult | None:
        """The mapping and what was proved of it; None: the region places nothing.

        Raises
        ------
        BundleError
            As of `dfg`.
        """
        return read_result(self._design(), self.fabric_yaml, straight=self.kind == "straight")

    @property
    def mapping(self) -> Mapping | None:
        """Time, place and route of every node and edge; None: the region places nothing.

        Raises
        ------
        BundleError
            As of `dfg`.
        """
        result = self.result
        return None if result is None else result.mapping

    def _design(self) -> str:
        if not self.design:
            raise BundleError(
                f"region {self.name} has neither graph nor mapping",
                hint="compile the kernel again with this version",
            )
        return self.design

    @property
    def rests_on_assumed(self) -> bool:
        """The lower bound is that of a recurrence through accesses not proved apart."""
        return rests_on_assumed(self.bounds, self.lower_bound)

    def explain(self) -> str:
        """What was proved and what binds, in a few lines for a person."""
        what = "II" if self.kind == "loop" else "length"
        head = f"{self.name}: {self.status}, {what} {self.ii}, lower bound {self.lower_bound}"
        head += IF_THEY_MEET if self.rests_on_assumed else ""
        lines = [head if self.loc is None else f"{head} ({self.loc})"]
        lines += [f"  {bound.name} {bound.ii}: {bound.reason}" for bound in self.bounds]
        lines += [f"  {what} {item.ii} refuted by {item.by}" for item in self.refuted]
        return "\n".join(lines)


@dataclass(frozen=True, slots=True)
class Option:
    """A compiler option the program was made with."""

    name: str
    value: str | int | float | bool | None


@dataclass(frozen=True, slots=True)
class Provenance:
    """What made a program. No time of day: the same input gives the same file.

    Attributes
    ----------
    versions
        (package, version) of vividc and of the packages that shape its output.
    kernel_file, kernel_sha256
        The source file and the SHA-256 of its text, both "" if there is none.
    """

    versions: tuple[tuple[str, str], ...]
    kernel_file: str
    kernel_sha256: str
    options: tuple[Option, ...] = ()


@dataclass(frozen=True, slots=True)
class TransformReport:
    """A transformation of a loop that was chosen, or tried and why not.

    Attributes
    ----------
    before, after
        Estimated cycles of one run of the kernel, every loop of unknown length at an assumed one;
        `after` is None if the transformation is not possible.
    reason
        Why it was not chosen, or was taken back; empty if the program has it.
    """

    kind: str
    factor: int
    chosen: bool
    before: float
    after: float | None
    reason: str


@dataclass(frozen=True, slots=True)
class LoopReport:
    """What became of one loop of the source.

    Attributes
    ----------
    loc
        Where it is written.
    outcome
        How it runs, in words.
    cycles_before
        Cycles an iteration by the bounds of the loop as written; None if it holds other loops.
    cycles_after
        Cycles an iteration of the source in the program's hot region of it; None as above.
    binds
        What keeps the II from being smaller.
    notes
        If-conversion, branching, fallbacks.
    transforms
        What was tried.
    """

    loc: SourceLoc | None
    outcome: str
    cycles_before: float | None = None
    cycles_after: float | None = None
    binds: str = ""
    notes: tuple[str, ...] = ()
    transforms: tuple[TransformReport, ...] = ()

    @property
    def rests_on_assumed(self) -> bool:
        """What binds is a recurrence through accesses not proved apart."""
        return ASSUMED in self.binds
