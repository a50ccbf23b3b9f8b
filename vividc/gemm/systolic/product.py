"""Graph and mapping of a matrix product on a systolic array, output stationary.

C = act(A B + bias) in blocks of rows x cols; each iteration of the loop is one block of C. A table
in the scratchpad says where the blocks of A, B and C of an iteration lie, so that one loop runs
over blocks of rows and of columns alike.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

from vividc.dfg.builder import GraphBuilder, Operand
from vividc.dfg.ir import DFG, Node
from vividc.gemm.systolic.array import SystolicArray, SystolicError
from vividc.gemm.systolic.layout import GROUP_BYTES, TABLE_ROW, BlockLayout, Stream
from vividc.gemm.systolic.precision import LARGEST, PACKS, PRODUCTS, Form, Precision, lanes
from vividc.gemm.systolic.schedule import SystolicSchedule, chosen_ii
from vividc.machine.opcodes import LatencyClass, Opcode
from vividc.mapper.mapping import Mapping as Placement
from vividc.mapper.mapping import Place, Step, Subject

BUFFER = "buffer"
"""The array that holds all operands in the scratchpad (`BlockLayout`)."""

OFFSETS = 1 << 15
"""Byte offsets of a load/store unit are below this."""

_START = 2
"""Contexts for the start of the loop: its trip count goes to the controller."""


@dataclass(frozen=True)
class GemmRegion:
    """A loop region and its mapping."""

    dfg: DFG
    mapping: Placement
    layout: BlockLayout


def windows(layout: BlockLayout, stream: Stream) -> int:
    """Base addresses that the accesses to a stream need."""
    last = {
        Stream.A: layout.a(layout.rows - 1, layout.depth - 1),
        Stream.B: layout.b(layout.cols - 1, layout.depth),
        Stream.C: layout.c(layout.rows - 1, layout.cols - 1),
        Stream.TABLE: 0,
    }[stream]
    return last * GROUP_BYTES // OFFSETS + 1


def base_name(stream: Stream, window: int, name: str | None = None) -> str:
    """Live-in with the address of element 0 of a stream, `window` times the offsets' range on; the
    stream goes by `name`, None: its own.
    """
    return f"{name or stream.name.lower()}{window}"


def gemm_region(
    array: SystolicArray,
    form: Form,
    *,
    words: int | None = None,
    names: Mapping[Stream, str] | None = None,
) -> GemmRegion:
    """The loop over blocks of C, mapped.

    Parameters
    ----------
    words
        Of the part of the scratchpad that holds the operands; None: all of it.
    names
        Prefix of each stream's live-ins; None: as of `base_name`.

    Raises
    ------
    SystolicError
        The configuration memory is too short for the inner dimension, the schedule has more stages
        than the controller, or one block does not fit the scratchpad.
    """
    schedule, layout = plan(array, form, words)
    made = _Construction(array, schedule, layout, names or {}, form.results)
    made.run()
    dfg = made.builder.build()
    mapping = Placement(schedule.ii, made.places, made.routes, Subject(dfg, array.fabric))
    return GemmRegion(dfg, mapping, layout)


def plan(
    array: SystolicArray, form: Form, words: int | None = None
) -> tuple[SystolicSchedule, BlockLayout]:
    """Schedule and memory layout of `gemm_region` without its graph.

    Raises
    ------
    SystolicError
        As `gemm_region`.
    """
    depth, results = form.depth, form.results
    if depth < 1:
        raise SystolicError(f"an inner dimension of {depth}", hint="give 1 or more")
    ii = chosen_ii(array, form, array.fabric.controller.contexts - _START)
    fault = array.missing_product(PRODUCTS[form.precision])
    if fault is not None:
        raise SystolicError(
            f"fabric {array.fabric.name} cannot multiply {form.precision}: {fault}",
            loc=array.fabric.name,
            hint="choose the precision f32",
        )
    fault = array.missing_pack((*PACKS[results], LARGEST[results]), lanes(results))
    if results != "f32" and fault is not None:
        raise SystolicError(
            f"fabric {array.fabric.name} cannot store {results}: {fault}",
            loc=array.fabric.name,
            hint="choose the precision f32 for the next layer",
        )
    schedule = SystolicSchedule(array, form, ii)
    room = array.fabric.scratchpad.words if words is None else words
    layout = BlockLayout(array.rows, array.cols, depth, room)
    _demand_room(array, schedule, layout)
    return schedule, layout


def _demand_room(array: SystolicArray, schedule: SystolicSchedule, layout: BlockLayout) -> None:
    fabric, depth = array.fabric, layout.depth
    contexts = fabric.controller.contexts - _START
    hint = "split the inner dimension and add the parts"
    if schedule.ii > contexts:
        text = f"an inner dimension of {depth} takes {schedule.ii} contexts of a PE; fabric "
        text += f"{fabric.name} has {contexts} beside the start of the loop"
        raise SystolicError(text, loc=fabric.name, hint=hint)
    if (schedule.span - 1) // schedule.ii >= fabric.controller.max_stages:
        text = f"a block is {schedule.span} cycles in the array, and a new one starts every "
        text += f"{schedule.ii}: more than {fabric.controller.max_stages} stages"
        raise SystolicError(text, loc=fabric.name, hint="pad the inner dimension with zeros")
    if min(layout.blocks(max(depth, array.cols)), layout.room // layout.band) < 1:
        text = f"one block of {layout.rows}x{depth} by {depth}x{layout.cols} does not fit the "
        text += f"{4 * layout.words} bytes of the scratchpad of fabric {fabric.name}"
        raise SystolicError(text, loc=fabric.name, hint=hint)


class _Construction:
    """Nodes with their places, edges with their routes, in one pass over the array."""

    def __init__(
        self,
        array: SystolicArray,
        schedule: SystolicSchedule,
        layout: BlockLayout,
        names: Mapping[Stream, str],
        results: Precision,
    ) -> None:
        self.builder = GraphBuilder("gemm")
        self.places: dict[int, Place] = {}
        self.routes: dict[int, tuple[Step, ...]] = {}
        self._array = array
        self._schedule = schedule
        self._layout = layout
        self._names = names
        self._results = results
        self._edges = 0

    def run(self) -> None:
        """Construct everything."""
        rows, cols = range(self._layout.rows), range(self._layout.cols)
        a = [self._row(i) for i in rows]
        b = [self._column(j) for j in cols]
        count = self._schedule.lanes
        for first in cols[::count]:
            loads = self._array.north if self._schedule.homes.north_c else self._array.drain
            place = self._place(Stream.C, Place(loads(first), self._schedule.place_c(first)))
            for i in rows:
                columns = cols[first : first + count]
                totals = [self._accumulate(i, j, a[i], *b[j]) for j in columns]
                self._leave(i, first, totals, place)

    def _row(self, i: int) -> list[Operand]:
        """A(i, k) for all k."""
        pe = self._array.west(i)
        place = self._place(Stream.A, Place(pe, self._schedule.place_a(i)))
        times = [self._schedule.load_a(i, k) for k in range(self._layout.depth)]
        return [
            self._load(Stream.A, self._layout.a(i, k), place, Place(pe, time))
            for k, time in enumerate(times)
        ]

    def _column(self, j: int) -> tuple[list[Operand], list[Operand]]:
        """B(k, j) for all k, and what the sum of each row starts from."""
        pe = self._array.north(j)
        loads = self._array.drain(j) if self._schedule.homes.drain_b else pe
        place = self._place(Stream.B, Place(loads, self._schedule.place_b(j)))
        times = [self._schedule.load_b(j, k) for k in range(self._layout.depth)]
        if not self._schedule.form.added:
            times.append(self._schedule.load_start(0, j))
        made = [
            self._load(Stream.B, self._layout.b(j, k), place, Place(pe, time))
            for k, time in enumerate(times)
        ]
        if not self._schedule.form.added:
            return made[:-1], made[-1:] * self._layout.rows
        place = self._place(Stream.TABLE, Place(pe, self._schedule.place_start(j)))
        registers = range(self._array.fabric.pes[pe].registers)[::-1]
        starts = [
            self._load(
                Stream.B,
                self._layout.b(j, i),
                place,
                Place(pe, self._schedule.load_start(i, j)),
                registers,
            )
            for i in range(self._layout.rows)
        ]
        return made, starts

    def _place(self, stream: Stream, where: Place) -> Operand:
        """Where the iteration's block of a matrix lies, from the table."""
        shift = (TABLE_ROW * GROUP_BYTES).bit_length() - 1
        node = Node(0, Opcode.LOAD, name=BUFFER, shift=shift, offset=stream * GROUP_BYTES)
        base = self._base(Stream.TABLE, 0)
        return self._add(node, [self.builder.iv()], where, base=base)

    def _load(
        self,
        stream: Stream,
        element: int,
        index: Operand,
        where: Place,
        registers: range | None = None,
    ) -> Operand:
        base, offset = self._address(stream, element)
        node = Node(0, Opcode.LOAD, name=BUFFER, offset=offset)
        return self._add(node, [index], where, [self._held(index, where, registers)], base)

    def _accumulate(
        self, i: int, j: int, a: list[Operand], b: list[Operand], starts: list[Operand]
    ) -> Operand:
        total = starts[i]
        pe = self._array.multiplier(i, j)
        for k, (left, right) in enumerate(zip(a, b, strict=True)):
            east = self._eastward(i, j, self._schedule.load_a(i, k))
            south = self._southward(i, j, self._schedule.load_b(j, k))
            kept = self._kept(i, j, k) if k else self._start(i, j)
            where = Place(pe, self._schedule.multiply(i, j, k))
            node = Node(0, self._schedule.op)
            total = self._add(node, [left, right, total], where, [east, south, kept])
        if self._schedule.compares:
            where = Place(pe, self._schedule.compare(i, j))
            return self._activated(total, where, self._sum(i, j, where.time), "f32")
        return total

    def _leave(self, i: int, j: int, totals: list[Operand], place: Operand) -> None:
        """The results of row i, columns j, ..., of a word."""
        where = Place(self._array.drain(j), self._schedule.leave(i, j))
        word, route = totals[0], self._northward(i, j)
        if len(totals) > 1:
            word, route = self._packed(i, j, totals)
        elif self._schedule.late:
            word, route = self._activated(word, where, route, "f32"), ()
        where = Place(where.pe, self._schedule.store(i, j))
        base, offset = self._address(Stream.C, self._layout.c(i, j // len(totals)))
        node = Node(0, Opcode.STORE, name=BUFFER, offset=offset)
        self._add(node, [place, word], where, [self._held(place, where), route], base)

    def _activated(
        self, word: Operand, where: Place, route: tuple[Step, ...], form: Precision
    ) -> Operand:
        """max(x, 0) of a word."""
        node = Node(0, LARGEST[form])
        return self._add(node, [word, self.builder.const(0)], where, [route])

    def _packed(
        self, i: int, first: int, totals: list[Operand]
    ) -> tuple[Operand, tuple[Step, ...]]:
        """The word of two or four results, and its way to the first column's drain."""
        schedule, ops = self._schedule, PACKS[self._results]
        drains = [self._array.drain(first + lane) for lane in range(len(totals))]
        convert = self._array.latency(LatencyClass.CONVERT)
        come = [self._northward(i, first + lane) for lane in range(len(totals))]
        for lane in range(0, len(totals), 2 if not schedule.homes.early else 4):
            east = drains[lane : lane + 2]
            come[lane] += self._along(east, schedule.drain(i, first + lane) + 1)
        where = Place(drains[1], schedule.pack(i, first))
        word = self._add(Node(0, ops[0]), totals[:2], where, come[:2])
        if len(ops) > 1:
            last = 2 if schedule.homes.early else 3
            where = Place(drains[last], schedule.pack_high(i, first))
            come[3] += self._along(drains[3 : last - 1 : -1], schedule.drain(i, first + 3) + 1)
            low = self._along(drains[1 : last + 1], schedule.pack(i, first) + convert)
            # Words that wait for the last one: those of rows that meet in other registers.
            bank = 2 * (2 * i // (schedule.ii - 1))
            held = [
                (*way, *self._waiting(where, way, register))
                for register, way in enumerate((come[2], come[3], low), 2 * bank)
            ]
            word = self._add(Node(0, ops[1]), [*totals[2:], word], where, held)
        end, time = drains.index(where.pe), where.time + convert
        if not schedule.late:
            return word, self._along(drains[end::-1], time)
        # In passing, or on the drain that stores.
        stop = 2 if len(ops) > 1 else 0
        where = Place(drains[stop], schedule.activate(i, first))
        way = self._along(drains[stop : end + 1][::-1], time)
        word = self._activated(word, where, way, self._results)
        return word, self._along(drains[stop::-1], where.time + 1)

    @staticmethod
    def _waiting(where: Place, way: tuple[Step, ...], register: int) -> Iterator[Step]:
        times = range(way[-1].time + 1, where.time + 1)
        return (Step("reg", where.pe, register, time) for time in times)

    def _address(self, stream: Stream, element: int) -> tuple[Operand, int]:
        """Base and offset of an element: the offset has fewer bits than the scratchpad."""
        window, offset = divmod(element * GROUP_BYTES, OFFSETS)
        return self._base(stream, window), offset

    def _base(self, stream: Stream, window: int) -> Operand:
        return self.builder.live_in(base_name(stream, window, self._names.get(stream)))

    def _add(
        self,
        node: Node,
        operands: list[Operand],
        where: Place,
        routes: list[tuple[Step, ...]] | None = None,
        base: Operand | None = None,
    ) -> Operand:
        """A placed node; `routes` of its first operands, which are operations."""
        made = self.builder.add_node(node, operands, base=base)
        self.places[made.node] = where
        for port, route in enumerate(routes or ()):
            self.routes[self._edges + port] = route
        self._edges += len(operands) + (base is not None)
        return made

    # --- routes -----------------------------------------------------------------------------------

    def _eastward(self, i: int, j: int, time: int) -> tuple[Step, ...]:
        """What row i's PE in the west loads in cycle `time`."""
        pes = [self._array.west(i), *(self._array.multiplier(i, col) for col in range(j + 1))]
        return self._along(pes, time + self._array.latency(LatencyClass.LOAD))

    def _southward(self, i: int, j: int, time: int) -> tuple[Step, ...]:
        """What column j's PE in the north loads in cycle `time`."""
        pes = [self._array.north(j), self._array.drain(j)]
        pes += [self._array.multiplier(row, j) for row in range(i + 1)]
        return self._along(pes, time + self._array.latency(LatencyClass.LOAD))

    def _northward(self, i: int, j: int) -> tuple[Step, ...]:
        pes = [self._array.multiplier(row, j) for row in range(i, -1, -1)]
        return self._along([*pes, self._array.drain(j)], self._schedule.result(i, j))

    def _along(self, pes: list[int], time: int) -> tuple[Step, ...]:
        """From PE to PE, readable on the second in cycle `time`."""
        hops = pairwise(pes)
        return tuple(
            Step("link", dst, self._array.link(src, dst), time + number)
            for number, (src, dst) in enumerate(hops)
        )

    def _held(
        self, word: Operand, reader: Place, registers: range | None = None
    ) -> tuple[Step, ...]:
        """A loaded word on its PE, in some of its registers (None: from the first on). It leaves
        each register for the next before that iteration's word comes; as each stay is a cycle
        shorter than the II, no two moves share a slot.
        """
        home = self.places[word.node]
        ready = home.time + self._array.latency(LatencyClass.LOAD)
        way = () if home.pe == reader.pe else self._along([home.pe, reader.pe], ready)
        if way and reader.time == ready:
            return way
        ready += len(way)
        registers = registers or range(self._array.fabric.pes[reader.pe].registers)
        waits = (
            Step("reg", reader.pe, registers[(time - ready) // (self._schedule.ii - 1)], time)
            for time in range(ready, reader.time + 1)
        )
        return (*way, *waits)

    def _start(self, i: int, j: int) -> tuple[Step, ...]:
        """What a sum starts from waits in the last register for the first FMA."""
        way = self._southward(i, j, self._schedule.load_start(i, j))
        pe = self._array.multiplier(i, j)
        register = self._array.fabric.pes[pe].registers - 1
        waits = range(way[-1].time + 1, self._schedule.multiply(i, j, 0) + 1)
        return (*way, *(Step("reg", pe, register, time) for time in waits))

    def _kept(self, i: int, j: int, k: int) -> tuple[Step, ...]:
        """The sum on its PE: from the output register, or where the next FMA comes later through a
        register, each time another one: these words of several blocks meet.
        """
        return self._sum(i, j, self._schedule.multiply(i, j, k), k)

    def _sum(self, i: int, j: int, read: int, k: int | None = None) -> tuple[Step, ...]:
        """The sum up to FMA k, None: the whole one, until it is read."""
        schedule = self._schedule
        k = schedule.depth if k is None else k
        start = schedule.multiply(i, j, k - 1) + schedule.product_latency
        if read == start:
            return ()
        register = schedule.waits[k] - 1 if k < schedule.depth else schedule.waits[k - 1]
        pe = self._array.multiplier(i, j)
        return tuple(Step("reg", pe, register, time) for time in range(start, read + 1))
