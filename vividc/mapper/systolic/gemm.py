"""Graph and mapping of a matrix product on a systolic array, output stationary.

C = act(A B + bias) in blocks of rows x cols; iteration n of the loop is block n of the rows of A, for
one block of columns of B.
"""

from __future__ import annotations

from dataclasses import dataclass

from vividc.dfg.graph_builder import GraphBuilder, Operand
from vividc.dfg.ir import DFG, Node
from vividc.dfg.opcodes import Opcode
from vividc.mapper.mapping import Mapping, Place, Step, Subject
from vividc.mapper.systolic.array import SystolicArray, SystolicError
from vividc.mapper.systolic.layout import STREAMS, BlockLayout, Stream
from vividc.mapper.systolic.schedule import SystolicSchedule, least_ii

BUFFER = "buffer"
"""The array that holds all operands in the scratchpad (`BlockLayout`)."""

_WORD = 4
Widths = tuple[int, int] | None
"""Columns of A and of C as they lie in the scratchpad."""

OFFSETS = 1 << 15
"""Byte offsets of a load/store unit are below this."""


@dataclass(frozen=True)
class GemmRegion:
    """A loop region and its mapping."""

    dfg: DFG
    mapping: Mapping
    layout: BlockLayout


def windows(layout: BlockLayout, stream: Stream) -> int:
    """Base addresses that the accesses to a matrix need."""
    last = {
        Stream.A: layout.a(layout.rows - 1, layout.depth - 1),
        Stream.B: layout.b(layout.cols - 1, layout.depth - 1),
        Stream.C: layout.c(layout.rows - 1, layout.cols - 1),
    }[stream]
    return last * STREAMS * _WORD // OFFSETS + 1


def bias_name(col: int) -> str:
    """Live-in with the bias of column `col` of the block."""
    return f"bias{col}"


def base_name(stream: Stream, window: int) -> str:
    """Live-in with the address of element 0 of a matrix, `window` times the offsets' range on."""
    return f"{stream.name.lower()}{window}"


def gemm_region(
    array: SystolicArray, depth: int, widths: Widths = None, *, relu: bool = False
) -> GemmRegion:
    """The loop over blocks of rows of A, mapped.

    Parameters
    ----------
    depth
        The inner dimension (columns of A, rows of B), 1 or more.
    widths
        Columns of A and of C as they lie in the scratchpad; None: `depth`, and those of one block.
    relu
        max(x, 0) of every result on its way out.

    Raises
    ------
    SystolicError
        The configuration memory is too short for `depth` FMAs a PE, the schedule has more stages
        than the controller, or one block does not fit the scratchpad.
    """
    schedule, layout = plan(array, depth, widths, relu=relu)
    made = _Construction(array, schedule, layout, relu=relu)
    made.run()
    dfg = made.builder.build()
    mapping = Mapping(schedule.ii, made.places, made.routes, Subject(dfg, array.fabric))
    return GemmRegion(dfg, mapping, layout)


def plan(
    array: SystolicArray, depth: int, widths: Widths = None, *, relu: bool = False
) -> tuple[SystolicSchedule, BlockLayout]:
    """Schedule and memory layout of `gemm_region` without its graph.

    Raises
    ------
    SystolicError
        As `gemm_region`.
    """
    if depth < 1:
        raise SystolicError(f"an inner dimension of {depth}", hint="it is 1 or more")
    schedule = SystolicSchedule(array, depth, least_ii(depth, array.rows, activated=relu))
    a_width, c_width = widths or (depth, array.cols)
    words = array.fabric.scratchpad.words
    layout = BlockLayout(array.rows, array.cols, depth, a_width, c_width, words)
    _demand_room(array, schedule, layout)
    return schedule, layout


def _demand_room(array: SystolicArray, schedule: SystolicSchedule, layout: BlockLayout) -> None:
    fabric = array.fabric
    contexts = fabric.controller.contexts - 1
    hint = "split the inner dimension and add the parts"
    if schedule.ii > contexts:
        reason = f"an inner dimension of {layout.depth} takes {schedule.ii} contexts of a PE"
        text = f"{reason}; fabric {fabric.name} has {contexts} beside the start of the loop"
        raise SystolicError(text, loc=fabric.name, hint=hint)
    last = schedule.drain(array.rows - 1, array.cols - 1) + 1
    if last // schedule.ii >= fabric.controller.max_stages:
        text = f"a block is {last} cycles in the array, and a new one starts every {schedule.ii}: "
        text += f"more than the {fabric.controller.max_stages} stages of fabric {fabric.name}"
        raise SystolicError(text, loc=fabric.name, hint="pad the inner dimension with zeros")
    if layout.blocks < 1:
        text = f"one block of {layout.rows}x{layout.depth} by {layout.depth}x{layout.cols} does not"
        text += f" fit the {fabric.scratchpad.size_bytes} bytes of fabric {fabric.name}"
        raise SystolicError(text, loc=fabric.name, hint=hint)


class _Construction:
    """Nodes with their places, edges with their routes, in one pass over the array."""

    def __init__(
        self, array: SystolicArray, schedule: SystolicSchedule, layout: BlockLayout, *, relu: bool
    ) -> None:
        self.builder = GraphBuilder("gemm")
        self.places: dict[int, Place] = {}
        self.routes: dict[int, tuple[Step, ...]] = {}
        self._array = array
        self._schedule = schedule
        self._layout = layout
        self._relu = relu
        self._edges = 0

    def run(self) -> None:
        """Construct everything."""
        rows, cols, depth = self._layout.rows, self._layout.cols, self._layout.depth
        a = [[self._load_a(i, k) for k in range(depth)] for i in range(rows)]
        b = [[self._load_b(j, k) for k in range(depth)] for j in range(cols)]
        for i in range(rows):
            for j in range(cols):
                self._leave(i, j, self._accumulate(i, j, a[i], b[j]))

    def _load_a(self, i: int, k: int) -> Operand:
        place = Place(self._array.west(i), self._schedule.load_a(i, k))
        stride = self._layout.stride * STREAMS * _WORD
        return self._load(Stream.A, self._layout.a(i, k), self.builder.iv(), stride, place)

    def _load_b(self, j: int, k: int) -> Operand:
        place = Place(self._array.north(j), self._schedule.load_b(j, k))
        return self._load(Stream.B, self._layout.b(j, k), self.builder.const(0), 1, place)

    def _load(
        self, stream: Stream, element: int, index: Operand, stride: int, place: Place
    ) -> Operand:
        base, offset = self._address(stream, element)
        shift = stride.bit_length() - 1
        node = Node(0, Opcode.LOAD, name=BUFFER, shift=shift, offset=offset)
        return self._add(node, [index], place, base=base)

    def _accumulate(self, i: int, j: int, a: list[Operand], b: list[Operand]) -> Operand:
        total = self.builder.live_in(bias_name(j))
        pe = self._array.multiplier(i, j)
        for k, (left, right) in enumerate(zip(a, b, strict=True)):
            place = Place(pe, self._schedule.multiply(i, j, k))
            routes = [self._eastward(i, j, k), self._southward(i, j, k)]
            if k:
                routes.append(self._kept(i, j, k))
            total = self._add(Node(0, Opcode.FMA), [left, right, total], place, routes)
        return total

    def _leave(self, i: int, j: int, total: Operand) -> None:
        time = self._schedule.drain(i, j)
        pe = self._array.drain(j)
        route = self._northward(i, j)
        if self._relu:
            zero = self.builder.const(0)
            node = Node(0, Opcode.FMAX)
            total = self._add(node, [total, zero], Place(pe, time), [route])
            time, route = time + 1, ()
        base, offset = self._address(Stream.C, self._layout.c(i, j))
        shift = (self._layout.result_stride * STREAMS * _WORD).bit_length() - 1
        node = Node(0, Opcode.STORE, name=BUFFER, shift=shift, offset=offset)
        place = Place(pe, time)
        self._add(node, [self.builder.iv(), total], place, [(), route], base=base)

    def _address(self, stream: Stream, element: int) -> tuple[Operand, int]:
        """Base and offset of an element: the offset has fewer bits than the scratchpad."""
        window, offset = divmod(element * STREAMS * _WORD, OFFSETS)
        return self.builder.live_in(base_name(stream, window)), offset

    def _add(
        self,
        node: Node,
        operands: list[Operand],
        place: Place,
        routes: list[tuple[Step, ...]] | None = None,
        base: Operand | None = None,
    ) -> Operand:
        """A placed node; `routes` of its first operands, where these are operations."""
        made = self.builder.add_node(node, operands, base=base)
        self.places[made.node] = place
        for port, route in enumerate(routes or ()):
            source = self.builder.node(operands[port])
            if source is not None and not source.is_source:
                self.routes[self._edges + port] = route
        self._edges += len(operands) + (base is not None)
        return made

    # --- routes -----------------------------------------------------------------------------------

    def _eastward(self, i: int, j: int, k: int) -> tuple[Step, ...]:
        pes = [self._array.west(i), *(self._array.multiplier(i, col) for col in range(j + 1))]
        return self._along(pes, self._schedule.multiply(i, 0, k))

    def _southward(self, i: int, j: int, k: int) -> tuple[Step, ...]:
        pes = [self._array.north(j), self._array.drain(j)]
        pes += [self._array.multiplier(row, j) for row in range(i + 1)]
        return self._along(pes, self._schedule.multiply(0, j, k) - 1)

    def _northward(self, i: int, j: int) -> tuple[Step, ...]:
        pes = [self._array.multiplier(row, j) for row in range(i, -1, -1)]
        return self._along([*pes, self._array.drain(j)], self._schedule.result(i, j))

    def _along(self, pes: list[int], time: int) -> tuple[Step, ...]:
        """From PE to PE, readable on the second in cycle `time`."""
        hops = zip(pes, pes[1:], strict=False)
        return tuple(
            Step("link", dst, self._array.link(src, dst), time + number)
            for number, (src, dst) in enumerate(hops)
        )

    def _kept(self, i: int, j: int, k: int) -> tuple[Step, ...]:
        """The sum on its PE: from the output register, or where the next FMA comes a cycle later
        through a register, each time another one: these words of several blocks meet.
        """
        ready = self._schedule.result(i, j) - self._schedule.multiply(i, j, self._layout.depth - 1)
        start = self._schedule.multiply(i, j, k - 1) + ready
        read = self._schedule.multiply(i, j, k)
        if read == start:
            return ()
        pe = self._array.multiplier(i, j)
        register = self._schedule.turn(k) - 1
        return tuple(Step("reg", pe, register, time) for time in range(start, read + 1))
