"""The program of a systolic matrix product: a start that sets the trip count, and the loop."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from vividc import arch
from vividc.arch.fabric import Fabric
from vividc.dfg.cfg import DType, Param
from vividc.dfg.graph_builder import GraphBuilder
from vividc.dfg.ir import DFG, Control
from vividc.dfg.regions import Kernel, Region
from vividc.errors import InternalError
from vividc.mapper import Bound, Mapping, MapProblem, MapResult, Refutation, violations
from vividc.mapper.list_schedule import list_schedule
from vividc.mapper.systolic import (
    BUFFER,
    OFFSETS,
    STREAMS,
    BlockLayout,
    GemmRegion,
    Stream,
    SystolicArray,
    Widths,
    base_name,
    bias_name,
    gemm_region,
    plan,
    windows,
)
from vividc.program import WORD_BYTES, Program, encode

_BLOCKS = "blocks"
"""Parameter: how many blocks of rows a launch multiplies."""

_LINE = 16
"""Words along the second dimension of the buffer: no dimension of an array may be as long as it."""


@dataclass(frozen=True)
class Shape:
    """A product on an array, without its program: its layout, and its cycles in closed form."""

    layout: BlockLayout
    ii: int
    span: int
    overhead: int

    @staticmethod
    def of(
        array: SystolicArray, depth: int, widths: Widths = None, *, relu: bool = False
    ) -> Shape:
        """The product of `gemm_region` with the same arguments.

        Raises
        ------
        SystolicError
            The array's memories are too small for `depth`.
        """
        schedule, layout = plan(array, depth, widths, relu=relu)
        span = schedule.drain(array.rows - 1, array.cols - 1) + 1 + relu
        controller = array.fabric.controller
        start = 1 + controller.control_latency
        return Shape(layout, schedule.ii, span, start + controller.switch_cycles)

    def cycles(self, blocks: int) -> int:
        """Cycles of one launch over `blocks` blocks, 1 or more: exact, as no two accesses of a
        cycle meet in a bank.
        """
        return self.overhead + (blocks - 1) * self.ii + self.span


@dataclass(frozen=True)
class Operands:
    """Where one launch finds its operands in the scratchpad.

    Attributes
    ----------
    source, target
        Streams of A and C.
    band
        Which block of columns of C is computed.
    blocks
        How many blocks of rows.
    """

    source: int
    target: int
    band: int
    blocks: int


@dataclass(frozen=True)
class GemmProgram:
    """A program for products with one inner dimension, and the form of its operands."""

    program: Program
    layout: BlockLayout

    def launch(
        self, buffer: NDArray[np.float32], given: Operands, bias: NDArray[np.float32]
    ) -> dict[str, object]:
        """Arguments of a launch, by parameter; `buffer`: float32 [room, STREAMS], `bias`: float32
        [columns of a block].
        """
        named: dict[str, object] = {BUFFER: buffer.reshape(-1, _LINE), _BLOCKS: given.blocks}
        for col in range(self.layout.cols):
            named[bias_name(col)] = float(bias[col])
        band = given.band * self.layout.c(0, self.layout.cols)
        starts = {Stream.A: given.source, Stream.B: Stream.B, Stream.C: given.target}
        for stream, number in starts.items():
            first = number + (band * STREAMS if stream is Stream.C else 0)
            for window in range(windows(self.layout, stream)):
                named[base_name(stream, window)] = first * WORD_BYTES + window * OFFSETS
        return named


@lru_cache(maxsize=16)
def gemm_program(
    fabric: str | Fabric, depth: int, widths: Widths = None, *, relu: bool = False
) -> GemmProgram:
    """The program for products with inner dimension `depth` on `fabric`.

    Parameters
    ----------
    widths
        Columns of A and of C as they lie in the scratchpad; None: `depth`, and those of one block.
    relu
        max(x, 0) of every result.

    Raises
    ------
    ArchError, SystolicError
        No such fabric; it is no systolic array; or its memories are too small for `depth`.
    """
    machine = arch.load(fabric) if isinstance(fabric, str) else fabric
    array = SystolicArray.of(machine)
    region = gemm_region(array, depth, widths, relu=relu)
    faults = violations(region.dfg, machine, region.mapping)
    if faults:
        raise InternalError(f"systolic mapping of depth {depth}: {faults[0].message}")
    kernel, mappings = _kernel(array, region)
    reports = {1: _report(region)}
    return GemmProgram(encode(kernel, machine, mappings, reports=reports), region.layout)


def _kernel(array: SystolicArray, region: GemmRegion) -> tuple[Kernel, dict[int, Mapping]]:
    start = _start()
    first = list_schedule(MapProblem(start, array.fabric))
    faults = violations(start, array.fabric, first, straight=True)
    if faults:
        raise InternalError(f"start of a systolic product: {faults[0].message}")
    params = [Param(BUFFER, DType.F32, 2), Param(_BLOCKS, DType.I32)]
    params += [Param(bias_name(j), DType.F32) for j in range(array.cols)]
    for stream in Stream:
        names = (base_name(stream, window) for window in range(windows(region.layout, stream)))
        params += [Param(name, DType.I32) for name in names]
    regions = (
        Region("start", "straight", start, next=1),
        Region("gemm", "loop", region.dfg, counted=True),
    )
    return Kernel("gemm", tuple(params), regions), {0: first, 1: region.mapping}


def _start() -> DFG:
    builder = GraphBuilder("start")
    builder.mark(builder.live_in(_BLOCKS), Control.TRIP)
    return builder.build()


def _report(region: GemmRegion) -> MapResult:
    """What is proved: a PE issues one FMA for each inner index."""
    ii, depth = region.mapping.ii, region.layout.depth
    bound = Bound("ResMII", depth, f"a PE issues {depth} FMAs for a block")
    return MapResult(
        status="optimal" if ii == depth else "feasible",
        ii=ii,
        lower_bound=depth,
        bounds=(bound,),
        mapping=region.mapping,
        mapper="systolic",
        wall_s=0.0,
        refuted=tuple(Refutation(below, "ResMII") for below in range(1, depth)),
        subject=region.mapping.subject,
    )
