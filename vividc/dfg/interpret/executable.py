"""A DFG as a flat list of actions on slots, compiled once so that it runs fast."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from vividc.dfg.check import check
from vividc.dfg.ir import DFG, Control, Edge, Node
from vividc.dfg.order import evaluation_order
from vividc.errors import DFGError, SimulationError, printable
from vividc.machine.opcodes import BASE, PRED, Opcode
from vividc.machine.semantics import SEMANTICS
from vividc.machine.words import WORD_MASK, loaded, signed, stored

Step = Callable[[list[int], "memoryview[int]"], None]


@dataclass(frozen=True, slots=True)
class Executable:
    """A DFG flattened into steps over a list of words, one slot per value.

    Attributes
    ----------
    size
        Number of slots.
    steps
        Actions of one iteration, in evaluation order.
    constants, live_ins, ivs
        Slots filled at entry with a word or the word of a name, or in each iteration with its
        number.
    delays
        (slot, source, init): at the end of an iteration `slot` takes the word of `source`; before
        the first one, that of `init`.
    live_outs
        (variable, slot, unless_exit).
    control
        Slot of each node that the controller reads.
    operations
        FU operations of one iteration.
    misses
        Filled by an iteration: errors of `unless_exit` loads, void if the iteration exits.
    """

    size: int
    steps: tuple[Step, ...]
    constants: tuple[tuple[int, int], ...]
    live_ins: tuple[tuple[int, str], ...]
    ivs: tuple[int, ...]
    delays: tuple[tuple[int, int, int], ...]
    live_outs: tuple[tuple[str, int, bool], ...]
    control: Mapping[Control, int]
    operations: int
    misses: list[SimulationError]


Accessed = Callable[[Node, int], None]
"""Told of each load and store that is carried out, with its byte address."""


def compile_dfg(dfg: DFG, accessed: Accessed | None = None) -> Executable:
    """Flatten `dfg` for `run_executable`.

    Raises
    ------
    DFGError
        The graph breaks an invariant of `check`, or has generic nodes or values carried without
        init.
    """
    problems = check(dfg)
    if problems:
        raise DFGError(
            "; ".join(problems), loc=printable(dfg.name), hint="print the graph with `to_text`"
        )
    return _Flattening(dfg, accessed).executable()


class _Flattening:
    """Slots of one DFG: a word per node, then a delay line per carried (source, init)."""

    def __init__(self, dfg: DFG, accessed: Accessed | None) -> None:
        self.dfg = dfg
        self.accessed = accessed
        self.slot = {node.id: index for index, node in enumerate(dfg.nodes)}
        self.size = len(dfg.nodes)
        self.misses: list[SimulationError] = []
        self.lines: dict[tuple[int, int], list[int]] = {}
        exits = [node.id for node in dfg.nodes if node.control is Control.EXIT]
        self.exit_slot = self.slot[exits[0]] if exits else None

    def executable(self) -> Executable:
        """The flattened graph."""
        dfg, slot = self.dfg, self.slot
        order = evaluation_order(dfg)
        steps = tuple(
            self.step(dfg.by_id[node_id]) for node_id in order if dfg.by_id[node_id].uses_fu
        )
        outs = [node for node in dfg.nodes if node.op is Opcode.LIVE_OUT]
        live_outs = tuple((n.name, self.operands(n)[0], n.unless_exit) for n in outs)
        nodes = dfg.nodes
        return Executable(
            steps=steps,
            constants=tuple((slot[n.id], n.const) for n in nodes if n.const is not None),
            live_ins=tuple((slot[n.id], n.name) for n in nodes if n.op is Opcode.LIVE_IN),
            ivs=tuple(slot[n.id] for n in nodes if n.op is Opcode.IV),
            live_outs=live_outs,
            control={n.control: slot[n.id] for n in nodes if n.control is not None},
            operations=len(dfg.operations),
            delays=tuple(self.delays()),
            size=self.size,
            misses=self.misses,
        )

    def delays(self) -> list[tuple[int, int, int]]:
        """Shifts of all delay lines; the oldest word moves first, before it is overwritten."""
        shifts: list[tuple[int, int, int]] = []
        for (src, init), line in self.lines.items():
            sources = [self.slot[src], *line[:-1]]
            moves = [
                (to, source, self.slot[init]) for to, source in zip(line, sources, strict=True)
            ]
            shifts.extend(reversed(moves))
        return shifts

    def read(self, edge: Edge) -> int:
        """Slot that `edge` reads."""
        if not edge.distance:
            return self.slot[edge.src]
        if edge.init is None:
            raise DFGError(
                f"edge {edge.src} -> {edge.dst} has distance {edge.distance} and no init",
                loc=self.dfg.by_id[edge.dst].loc or printable(self.dfg.name),
            )
        line = self.lines.setdefault((edge.src, edge.init), [])
        while len(line) < edge.distance:
            line.append(self.size)
            self.size += 1
        return line[edge.distance - 1]

    def operands(self, node: Node) -> list[int]:
        """Slots of the data operands in port order."""
        edges = (self.dfg.operand(node.id, port) for port in range(node.info.arity))
        return [self.read(edge) for edge in edges if edge is not None]

    def port(self, node: Node, port: int) -> int | None:
        """Slot of an optional port."""
        edge = self.dfg.operand(node.id, port)
        return None if edge is None else self.read(edge)

    def step(self, node: Node) -> Step:
        """The action of one FU operation."""
        pred = self.port(node, PRED)
        if node.is_memory:
            return self.memory_step(node, pred)
        function = SEMANTICS.get(node.op)
        if function is None:
            name = printable(node.name) or node.op.value
            raise DFGError(
                f"node {node.id} ({name}) has no meaning that can be run",
                loc=node.loc or printable(self.dfg.name),
            )
        slots = self.operands(node)
        plain = _STEPS[len(slots)](function, self.slot[node.id], slots)
        return plain if pred is None else _predicated(plain, pred, self.slot[node.id], slots[-1])

    def memory_step(self, node: Node, pred: int | None) -> Step:
        """The action of a load or store."""
        base = self.port(node, BASE)
        if base is None:
            raise DFGError(f"memory node {node.id} has no base address", loc=node.loc)
        address = _Address(base, self.operands(node)[0], node, self.accessed)
        if node.op is Opcode.LOAD:
            if node.unless_exit and self.exit_slot is not None:
                return _load_that_may_miss(address, self.slot[node.id], pred, self.misses)
            return _load(address, self.slot[node.id], pred)
        exit_slot = self.exit_slot if node.unless_exit else None
        return _store(address, self.operands(node)[1], pred, exit_slot)


@dataclass(frozen=True, slots=True)
class _Address:
    base: int
    index: int
    node: Node
    accessed: Accessed | None

    def byte(self, values: Sequence[int], limit: int) -> int:
        """Byte address in a memory of `limit` words, checked."""
        node = self.node
        raw = values[self.base] + (values[self.index] << node.shift) + node.offset
        address = raw & WORD_MASK
        if address % node.width or address >> 2 >= limit:
            fault = (
                f"is not aligned to {node.width} bytes"
                if address % node.width
                else f"leaves the {limit * 4} bytes of the scratchpad"
            )
            access = f"{node.op.value} of {node.name or 'memory'} at byte {signed(address)}"
            raise SimulationError(f"{access} {fault}", loc=node.loc)
        if self.accessed is not None:
            self.accessed(node, address)
        return address


def _unary(function: Callable[..., int], out: int, slots: Sequence[int]) -> Step:
    (a,) = slots

    def step(values: list[int], words: memoryview[int]) -> None:
        values[out] = function(values[a])

    return step


def _binary(function: Callable[..., int], out: int, slots: Sequence[int]) -> Step:
    a, b = slots

    def step(values: list[int], words: memoryview[int]) -> None:
        values[out] = function(values[a], values[b])

    return step


def _ternary(function: Callable[..., int], out: int, slots: Sequence[int]) -> Step:
    a, b, c = slots

    def step(values: list[int], words: memoryview[int]) -> None:
        values[out] = function(values[a], values[b], values[c])

    return step


_STEPS: Final = {1: _unary, 2: _binary, 3: _ternary}


def _predicated(plain: Step, pred: int, out: int, last: int) -> Step:
    def step(values: list[int], words: memoryview[int]) -> None:
        if values[pred]:
            plain(values, words)
        else:
            values[out] = values[last]

    return step


def _load_that_may_miss(
    address: _Address, out: int, pred: int | None, misses: list[SimulationError]
) -> Step:
    plain = _load(address, out, pred)

    def step(values: list[int], words: memoryview[int]) -> None:
        try:
            plain(values, words)
        except SimulationError as error:
            values[out] = 0
            misses.append(error)

    return step


def _load(address: _Address, out: int, pred: int | None) -> Step:
    width, is_signed = address.node.width, address.node.signed

    def step(values: list[int], words: memoryview[int]) -> None:
        values[out] = 0
        if pred is None or values[pred]:
            byte = address.byte(values, len(words))
            values[out] = loaded(words[byte >> 2], byte, width, is_signed)

    return step


def _store(address: _Address, value: int, pred: int | None, exit_slot: int | None) -> Step:
    width = address.node.width

    def step(values: list[int], words: memoryview[int]) -> None:
        if (pred is None or values[pred]) and (exit_slot is None or not values[exit_slot]):
            byte = address.byte(values, len(words))
            words[byte >> 2] = stored(words[byte >> 2], values[value], byte, width)

    return step
