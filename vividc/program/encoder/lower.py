"""One region's mapping to configuration entries, exactly by docs/machine.md.

Nothing of the mapping is trusted: two sources for one field, a word that is not where a route says,
an operation that completes too late all raise `InternalError`.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from collections.abc import Mapping as ReadOnly
from dataclasses import dataclass, field, replace
from typing import Literal

from vividc.arch.fabric import Fabric
from vividc.dfg.ir import Control, Edge, Node
from vividc.dfg.regions import Region
from vividc.errors import InternalError, KernelError
from vividc.machine.opcodes import BASE, PRED, Opcode
from vividc.mapper.mapping import Mapping, Place, Step
from vividc.program.encoder.constants import ConstantStores
from vividc.program.tables import DebugRow
from vividc.program.words.entry import (
    NOTHING,
    Capture,
    Entry,
    Issue,
    Operand,
    Sel,
    Select,
    Use,
    Write,
    faults,
)
from vividc.program.words.layout import OFFSET_BITS, SHIFT_BITS, WordLayout

_USES = {
    None: Use.NONE,
    Control.EXIT: Use.EXIT,
    Control.BRANCH: Use.BRANCH,
    Control.TRIP: Use.TRIP,
}


def _words(issue: Issue) -> tuple[Operand, ...]:
    """The operands, predicate last."""
    return (*issue.operands, issue.predicate)


def _passes_on(previous: Step | None, step: Step) -> bool:
    """The word takes both links in one cycle."""
    if previous is None or step.time != previous.time:
        return False
    return previous.kind == "link" and step.kind == "link"


@dataclass(frozen=True)
class Rest:
    """What is left of a loop from cycle `begin` of its last iteration on, for so many cycles."""

    loop: LoweredRegion
    begin: int
    cycles: int


@dataclass(frozen=True)
class Ahead:
    """What a loop does in its first so many cycles, those of its iterations that there are: the
    first one is of stage `stage`.
    """

    loop: LoweredRegion
    cycles: int
    stage: int


@dataclass(frozen=True)
class LoweredRegion:
    """Entries by (slot, PE), idle ones absent, and the debug rows of the region; `cells`: what the
    entries are made from.
    """

    entries: ReadOnly[tuple[int, int], Entry]
    debug: tuple[DebugRow, ...]
    ii: int
    cells: ReadOnly[tuple[int, int], _Cell]


def lower_region(
    index: int,
    region: Region,
    mapping: Mapping,
    fabric: Fabric,
    stores: ConstantStores,
    layout: WordLayout,
    beside: Sequence[Rest | Ahead] = (),
) -> LoweredRegion:
    """Lower region `index` of a kernel, whose schedule has passed `check_region`.

    Parameters
    ----------
    beside
        What its words hold of the loops before and behind it.

    Raises
    ------
    InternalError
        The mapping breaks a rule of the machine.
    KernelError
        An address offset or shift does not fit the configuration word.
    """
    lowering = _Lowering(index, region, mapping, fabric, stores)
    for one in beside:
        if isinstance(one, Rest):
            lowering.begin_with(one)
        else:
            lowering.end_with(one)
    for edge_index, edge in region.dfg.routed_edges():
        lowering.route(edge_index, edge)
    for node in region.dfg.placed:
        lowering.place(node)
    entries = {key: cell.entry(layout) for key, cell in sorted(lowering.cells.items())}
    for (slot, pe), entry in entries.items():
        missing = faults(entry, fabric, pe)
        if missing:
            raise InternalError(f"{region.name}: PE {pe} lacks {missing[0]} used in slot {slot}")
    return LoweredRegion(entries, tuple(lowering.debug), mapping.ii, lowering.cells)


@dataclass
class _Cell:
    """One entry in the making; every field takes one value, and a second one is a conflict."""

    where: str
    issue: Issue | None = None
    capture: Capture | None = None
    links: dict[int, Select] = field(default_factory=dict)
    reads: list[int] = field(default_factory=list)
    writes: dict[int, Select] = field(default_factory=dict)
    completes: int | None = None
    times: dict[tuple[str, int], int] = field(default_factory=dict)
    """Of what is driven, written or completed: the cycle of the iteration that it belongs to."""

    def read(self, register: int) -> Select:
        """An RF read port that delivers `register`."""
        if register not in self.reads:
            self.reads.append(register)
        return Select(Sel.RF, self.reads.index(register))

    def drive(self, link: int, select: Select, time: int) -> None:
        """Outgoing link `link` takes `select`."""
        self.times["link", link] = time
        if self.links.setdefault(link, select) != select:
            raise InternalError(f"{self.where}: two sources for outgoing link {link}")

    def write(self, register: int, select: Select, time: int) -> None:
        """`register` takes `select`."""
        self.times["reg", register] = time
        if self.writes.setdefault(register, select) != select:
            raise InternalError(f"{self.where}: two sources for register {register}")

    def take(self, other: _Cell, pe: int, stage_at: Callable[[int], int | None]) -> None:
        """Take what a loop's cell holds of some iterations: `stage_at` tells the stage by the
        cycle of the iteration in which it happens, None where the iteration is not among them.
        """

        def moved(select: Select) -> Select:
            return self.read(other.reads[select.index]) if select.kind is Sel.RF else select

        at = {kind: stage_at(time) for kind, time in other.times.items()}
        stages = {kind: stage for kind, stage in at.items() if stage is not None}
        if other.issue is not None and ("issue", pe) in stages:
            operands = (replace(one, select=moved(one.select)) for one in _words(other.issue))
            a, b, c, predicate = operands
            self.issue = replace(
                other.issue, operands=(a, b, c), predicate=predicate, stage=stages["issue", pe]
            )
        if other.capture is not None and ("capture", pe) in stages:
            select, stage = moved(other.capture.select), stages["capture", pe]
            self.capture = replace(other.capture, select=select, stage=stage)
        for link in [link for link in other.links if ("link", link) in stages]:
            self.drive(link, moved(other.links[link]), 0)
        for register in [one for one in other.writes if ("reg", one) in stages]:
            self.write(register, moved(other.writes[register]), 0)
        if ("completes", pe) in stages:
            self.completes = other.completes

    def entry(self, layout: WordLayout) -> Entry:
        """The finished entry."""
        if len(self.reads) > layout.reads or len(self.writes) > layout.writes:
            raise InternalError(f"{self.where}: more register file ports in use than there are")
        links = tuple(self.links.get(k, NOTHING) for k in range(layout.links))
        reads = (*self.reads, *[0] * (layout.reads - len(self.reads)))
        writes = [Write(select, register) for register, select in sorted(self.writes.items())]
        writes += [Write()] * (layout.writes - len(writes))
        return Entry(self.issue, links, reads, tuple(writes), self.capture)


class _Lowering:
    """Fills the cells of one region."""

    def __init__(
        self,
        index: int,
        region: Region,
        mapping: Mapping,
        fabric: Fabric,
        stores: ConstantStores,
    ) -> None:
        self._index = index
        self._region = region
        self._mapping = mapping
        self._fabric = fabric
        self._stores = stores
        self._words: dict[tuple[str, int, int, int], tuple[int, int]] = {}
        self._inputs: dict[int, list[tuple[int, Edge]]] = defaultdict(list)
        for number, edge in enumerate(region.dfg.edges):
            if edge.is_data:
                self._inputs[edge.dst].append((number, edge))
        self.cells: dict[tuple[int, int], _Cell] = {}
        self.debug: list[DebugRow] = []

    def _fail(self, what: str) -> InternalError:
        return InternalError(f"region {self._region.name}: {what}")

    def _cell(self, pe: int, time: int) -> _Cell:
        slot = time % self._mapping.ii
        if (slot, pe) not in self.cells:
            where = f"region {self._region.name}, slot {slot}, PE {pe}"
            self.cells[slot, pe] = _Cell(where)
        return self.cells[slot, pe]

    def begin_with(self, rest: Rest) -> None:
        """The first cells hold what is left of a loop."""
        ii = rest.loop.ii

        def stage_at(time: int) -> int | None:
            return (time - now) // ii + 1 if time >= now else None

        for cycle in range(rest.cycles):
            now = rest.begin + cycle
            for pe in range(len(self._fabric.pes)):
                cell = rest.loop.cells.get((now % ii, pe))
                if cell is not None:
                    self._cell(pe, cycle).take(cell, pe, stage_at)

    def end_with(self, ahead: Ahead) -> None:
        """The last cells hold what a loop begins with; its first iteration has the last stage."""
        ii, begin = ahead.loop.ii, self._mapping.ii - ahead.cycles

        def stage_at(time: int) -> int | None:
            return ahead.stage - (now - time) // ii if time <= now else None

        for now in range(ahead.cycles):
            for pe in range(len(self._fabric.pes)):
                cell = ahead.loop.cells.get((now % ii, pe))
                if cell is not None:
                    self._cell(pe, begin + now).take(cell, pe, stage_at)

    def route(self, edge_index: int, edge: Edge) -> None:
        """Drive the links and write the registers of one edge's route."""
        source = self._mapping.places[edge.src]
        time = source.time + self._fabric.latency(self._region.dfg.by_id[edge.src])
        previous: Step | None = None
        hops = 1
        for step in self._steps(edge_index, edge):
            hops = hops + 1 if _passes_on(previous, step) else 1
            time += previous is not None and hops == 1
            if step.time != time:
                raise self._fail(f"route of edge {edge_index} is at cycle {step.time}, not {time}")
            if step.kind == "link" and hops > self._fabric.routing.hops:
                raise self._fail(f"the word of edge {edge_index} passes {hops} links in a cycle")
            self._occupy(edge.src, step)
            self._advance(source.pe if previous is None else previous.pe, previous, step)
            previous = step

    def _steps(self, edge_index: int, edge: Edge) -> tuple[Step, ...]:
        """The route; () where the consumer reads the producer's output register, said or not."""
        steps = self._mapping.routes.get(edge_index, ())
        if not any(step.kind == "out" for step in steps):
            return steps
        source = self._mapping.places[edge.src]
        ready = source.time + self._fabric.latency(self._region.dfg.by_id[edge.src])
        if steps != (Step("out", source.pe, 0, ready),):
            raise self._fail(f"the word of edge {edge_index} stays in an output register")
        return ()

    def _occupy(self, node: int, step: Step) -> None:
        """No two words may be in one place in one slot."""
        place = 0 if step.kind == "link" else step.pe
        key = (step.kind, place, step.index, step.time % self._mapping.ii)
        word = (node, step.time)
        if self._words.setdefault(key, word) != word:
            other = self._words[key]
            raise self._fail(
                f"{step.kind} {step.index} of PE {step.pe} holds two words in slot {key[3]}: "
                f"node {node} at {step.time}, node {other[0]} at {other[1]}"
            )

    def _advance(self, pe: int, previous: Step | None, step: Step) -> None:
        if step.kind == "reg" and step.pe != pe:
            raise self._fail(f"a word jumps from PE {pe} to a register of PE {step.pe}")
        holds = previous is not None and (previous.kind, previous.index) == ("reg", step.index)
        if step.kind == "reg" and holds:
            return
        cell = self._cell(pe, step.time - 1)
        if previous is not None and _passes_on(previous, step):
            select = Select(Sel.WIRE, self._read(cell, previous).index)
        else:
            select = Select(Sel.RES) if previous is None else self._read(cell, previous)
        if step.kind == "reg":
            cell.write(step.index, select, step.time - 1)
            return
        links = [link.id for link in self._fabric.links_from[pe]]
        if step.index not in links or self._fabric.links[step.index].dst != step.pe:
            raise self._fail(f"link {step.index} does not run from PE {pe} to PE {step.pe}")
        cell.drive(links.index(step.index), select, step.time - 1)

    def _read(self, cell: _Cell, step: Step) -> Select:
        if step.kind == "reg":
            return cell.read(step.index)
        links = [link.id for link in self._fabric.links_to[step.pe]]
        return Select(Sel.LINK, links.index(step.index))

    def place(self, node: Node) -> None:
        """Issue one operation, or capture one live-out."""
        place = self._mapping.places[node.id]
        cell = self._cell(place.pe, place.time)
        if node.op is Opcode.LIVE_OUT:
            self._capture(node, place, cell)
        else:
            self._issue(node, place, cell)
        slot = place.time % self._mapping.ii
        role: Literal["issue", "live_out"] = "live_out" if node.op is Opcode.LIVE_OUT else "issue"
        self.debug.append(
            DebugRow(self._index, slot, place.pe, role, node.id, node.op.value, node.name, node.loc)
        )

    def _capture(self, node: Node, place: Place, cell: _Cell) -> None:
        if cell.capture is not None:
            raise self._fail(f"two live-outs on PE {place.pe} in cycle {place.time}")
        operands = self._operands(node, place)
        if operands.keys() != {0} or operands[0].first is not None:
            raise self._fail(f"live-out {node.id} needs one plain operand")
        entry = self._stores.index(place.pe, node)
        stage = place.time // self._mapping.ii
        cell.times["capture", place.pe] = place.time
        cell.capture = Capture(operands[0].select, entry, stage, node.unless_exit)

    def _issue(self, node: Node, place: Place, cell: _Cell) -> None:
        if cell.issue is not None:
            raise self._fail(f"two operations issue on PE {place.pe} in cycle {place.time}")
        self._complete(node, place)
        _check_immediates(node)
        operands = self._operands(node, place)
        predicate = operands.pop(PRED, Operand())
        base = operands.pop(BASE, None)
        if operands.keys() != set(range(node.info.arity)):
            raise self._fail(f"node {node.id} has operands {sorted(operands)}")
        is_constant = base is not None and base.select.kind is Sel.CONST and base.first is None
        if is_constant is not node.is_memory:
            raise self._fail(f"node {node.id} has the base address of no memory operation")
        a, b, c = (operands.get(port, Operand()) for port in range(3))
        cell.times["issue", place.pe] = place.time
        cell.issue = Issue(
            node.op,
            (a, b, c),
            predicate,
            base=base.select.index if base is not None else 0,
            shift=node.shift,
            offset=node.offset,
            width=node.width,
            signed=node.signed,
            stage=place.time // self._mapping.ii,
            use=_USES[node.control],
            unless_exit=node.unless_exit,
        )

    def _complete(self, node: Node, place: Place) -> None:
        last = self._cell(place.pe, place.time + self._fabric.latency(node) - 1)
        if last.completes is not None:
            raise self._fail(
                f"nodes {last.completes} and {node.id} complete on PE {place.pe} in the same slot"
            )
        last.completes = node.id
        last.times["completes", place.pe] = place.time + self._fabric.latency(node) - 1

    def _operands(self, node: Node, place: Place) -> dict[int, Operand]:
        operands: dict[int, Operand] = {}
        for index, edge in self._inputs[node.id]:
            if edge.port in operands:
                raise self._fail(f"two words for operand {edge.port} of node {node.id}")
            operands[edge.port] = Operand(
                self._source(index, edge, place), self._first(edge, place)
            )
        return operands

    def _source(self, index: int, edge: Edge, place: Place) -> Select:
        node = self._region.dfg.by_id[edge.src]
        if node.op is Opcode.IV:
            return Select(Sel.IV)
        if node.is_source:
            return Select(Sel.CONST, self._stores.index(place.pe, node))
        arrival = place.time + self._mapping.ii * edge.distance
        steps = self._steps(index, edge)
        if not steps:
            producer = self._mapping.places[edge.src]
            if (producer.pe, producer.time + self._fabric.latency(node)) != (place.pe, arrival):
                raise self._fail(f"edge {index} has no route and its word is not in `out`")
            return Select(Sel.OUT)
        last = steps[-1]
        if (last.pe, last.time) != (place.pe, arrival):
            raise self._fail(f"the route of edge {index} does not end at its consumer")
        return self._read(self._cell(place.pe, place.time), last)

    def _first(self, edge: Edge, place: Place) -> int | None:
        if edge.distance == 0:
            return None
        source = self._region.dfg.by_id[edge.src]
        if edge.init is None or edge.distance > 1 or source.op is Opcode.IV:
            raise self._fail(
                f"the machine cannot run an edge of distance {edge.distance} from node {edge.src}"
            )
        return self._stores.index(place.pe, self._region.dfg.by_id[edge.init])


def _check_immediates(node: Node) -> None:
    half = 1 << OFFSET_BITS - 1
    if not -half <= node.offset < half:
        raise KernelError(
            f"the constant part of this array index is {node.offset} bytes; "
            f"an address offset holds {-half} .. {half - 1}",
            loc=node.loc,
            hint="compute the index from a variable, or move the array's start",
        )
    if not 0 <= node.shift < 1 << SHIFT_BITS:
        raise KernelError(f"an address shift of {node.shift} is out of range", loc=node.loc)
