"""The program of a systolic matrix product, and programs of counted loops in general."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from vividc import arch
from vividc.arch.fabric import Fabric
from vividc.dfg.builder import GraphBuilder
from vividc.dfg.ir import DFG, Control
from vividc.dfg.regions import Kernel, Region
from vividc.errors import InternalError
from vividc.gemm.systolic import (
    BUFFER,
    GROUP_BYTES,
    OFFSETS,
    TABLE_ROW,
    BlockLayout,
    Form,
    GemmRegion,
    Precision,
    Stream,
    SystolicArray,
    base_name,
    gemm_region,
    plan,
    windows,
)
from vividc.machine.params import DType, Param
from vividc.mapper import Bound, Mapping, MapProblem, MapResult, Refutation, violations
from vividc.mapper.engines.list_schedule import list_schedule
from vividc.program import WORD_BYTES, Program, encode

_BLOCKS = "blocks"
"""Parameter: how many blocks of C a launch computes."""

LINE = 16
"""Words along the second dimension of the buffer: no dimension of an array may be as long as it."""


@dataclass(frozen=True)
class Shape:
    """A product on an array, without its program: its layout, and its cycles in closed form."""

    layout: BlockLayout
    ii: int
    span: int
    overhead: int

    @staticmethod
    def of(array: SystolicArray, form: Form, words: int | None = None) -> Shape:
        """The product of `gemm_region` with the same arguments.

        Raises
        ------
        SystolicError
            The array's memories are too small for the inner dimension.
        """
        schedule, layout = plan(array, form, words)
        controller = array.fabric.controller
        start = 1 + controller.control_latency
        return Shape(layout, schedule.ii, schedule.span, start + controller.switch_cycles)

    def cycles(self, blocks: int) -> int:
        """Cycles of one launch over `blocks` blocks, 1 or more: exact, as no two accesses of a
        cycle meet in a bank.
        """
        return self.overhead + (blocks - 1) * self.ii + self.span


@dataclass(frozen=True, slots=True)
class Operands:
    """Where one launch finds its operands in the scratchpad.

    Attributes
    ----------
    source, target
        Streams of A and C.
    a_width, c_width
        Columns of A and C as they lie there; of C, whole blocks.
    blocks
        How many blocks of rows.
    bands
        Which blocks of columns of C are computed; B holds these.
    """

    source: Stream
    target: Stream
    a_width: int
    c_width: int
    blocks: int
    bands: range


@dataclass(frozen=True)
class GemmProgram:
    """A program for products with one inner dimension, and the form of its operands."""

    program: Program
    layout: BlockLayout

    def launch(self, buffer: NDArray[np.float32], given: Operands) -> tuple[object, ...]:
        """Arguments of a launch, in order; the table of places is written into `buffer`,
        float32 [room, STREAMS].
        """
        self._write_table(buffer, given)
        named: dict[str, object] = {BUFFER: buffer.reshape(-1, LINE)}
        named[_BLOCKS] = given.blocks * len(given.bands)
        streams = {stream: stream for stream in Stream}
        streams |= {Stream.A: given.source, Stream.C: given.target}
        for stream, number in streams.items():
            for window in range(windows(self.layout, stream)):
                named[base_name(stream, window)] = number * WORD_BYTES + window * OFFSETS
        return tuple(named[param.name] for param in self.program.params)

    def _write_table(self, buffer: NDArray[np.float32], given: Operands) -> None:
        """One row for each block of C: where the blocks of A, B and C lie, in bytes."""
        layout = self.layout
        band, block = np.divmod(np.arange(given.blocks * len(given.bands)), given.blocks)
        rows = np.zeros((block.size, TABLE_ROW), np.uint32)
        rows[:, Stream.A] = block * layout.a(0, given.a_width)
        rows[:, Stream.B] = band * layout.band
        rows[:, Stream.C] = block * layout.c(0, given.c_width)
        rows[:, Stream.C] += ((band + given.bands.start) * layout.c(0, layout.cols)).astype(
            np.uint32
        )
        words = buffer.view(np.uint32)
        words[: rows.size, Stream.TABLE] = (rows * np.uint32(GROUP_BYTES)).ravel()


@lru_cache(maxsize=16)
def gemm_program(
    fabric: str | Fabric, depth: int, *, relu: bool = False, precision: Precision = "f32"
) -> GemmProgram:
    """The program for products with inner dimension `depth` on `fabric`.

    Parameters
    ----------
    relu
        max(x, 0) of every result.
    precision
        Format of the operands; `depth` counts words of them.

    Raises
    ------
    ArchError, SystolicError
        No such fabric; it is no systolic array; or its memories are too small for `depth`.
    """
    machine = arch.load_tile(fabric) if isinstance(fabric, str) else fabric
    array = SystolicArray.of(machine)
    region = gemm_region(array, Form(depth, relu, precision))
    params = [Param(BUFFER, DType.F32, 2), Param(_BLOCKS, DType.I32)]
    for stream in Stream:
        names = (base_name(stream, window) for window in range(windows(region.layout, stream)))
        params += [Param(name, DType.I32) for name in names]
    loop = CountedLoop("", "gemm", _BLOCKS, region.dfg, region_report(region))
    return GemmProgram(loops_program("gemm", machine, params, [loop]), region.layout)


@dataclass(frozen=True, slots=True)
class CountedLoop:
    """A mapped loop of a program that is made by hand.

    Attributes
    ----------
    number
        Ends the name of the region that starts the loop; "" if there is one loop only.
    name
        Of its own region.
    trip
        The parameter that says how often it runs.
    """

    number: str
    name: str
    trip: str
    dfg: DFG
    report: MapResult


def loops_program(
    name: str, fabric: Fabric, params: Sequence[Param], loops: Sequence[CountedLoop]
) -> Program:
    """The program of loops that run one after the other, each behind a region that sets its trip
    count.

    Raises
    ------
    InternalError
        A mapping is not legal.
    """
    regions: list[Region] = []
    mappings: dict[int, Mapping] = {}
    reports: dict[int, MapResult] = {}
    for loop in loops:
        start = _start_graph(loop.trip)
        first = len(regions)
        mappings[first] = list_schedule(MapProblem(start, fabric))
        regions.append(Region(f"start{loop.number}", "straight", start, next=first + 1))
        assert loop.report.mapping is not None
        mappings[first + 1], reports[first + 1] = loop.report.mapping, loop.report
        onward = first + 2 if loop is not loops[-1] else None
        regions.append(Region(loop.name, "loop", loop.dfg, next=onward, counted=True))
    for number, region in enumerate(regions):
        faults = violations(region.dfg, fabric, mappings[number], straight=number not in reports)
        if faults:
            raise InternalError(f"region {region.name} of {name}: {faults[0].message}")
    kernel = Kernel(name, tuple(params), tuple(regions))
    return encode(kernel, fabric, mappings, reports=reports)


def _start_graph(trip: str) -> DFG:
    builder = GraphBuilder("start")
    builder.mark(builder.live_in(trip), Control.TRIP)
    return builder.build()


def region_report(region: GemmRegion) -> MapResult:
    """What is proved for this graph, with the loads of a column of B on one PE."""
    ii, depth = region.mapping.ii, region.layout.depth
    least = depth + 1
    bound = Bound("ResMII", least, f"a PE at the edge issues {least} loads for a block")
    return MapResult(
        status="optimal" if ii == least else "feasible",
        ii=ii,
        lower_bound=least,
        bounds=(bound,),
        mapping=region.mapping,
        mapper="systolic",
        wall_s=0.0,
        refuted=tuple(Refutation(below, "ResMII") for below in range(1, least)),
        subject=region.mapping.subject,
    )
