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
from vividc.mapper import MapProblem, Mapping, MapResult, violations
from vividc.mapper.list_schedule import list_schedule
from vividc.mapper.mapping import Bound, Refutation
from vividc.mapper.systolic import (
    BUFFER,
    BlockLayout,
    GemmRegion,
    SystolicArray,
    bias_name,
    gemm_region,
)
from vividc.program import Program, encode

_BLOCKS = "blocks"
"""Parameter: how many blocks of rows a launch multiplies."""

_LINE = 16
"""Words along the second dimension of the buffer: no dimension of an array may be as long as it."""


@dataclass(frozen=True)
class GemmProgram:
    """A program for blocks of `layout.rows` x `layout.cols` with one inner dimension."""

    program: Program
    layout: BlockLayout

    def cycles(self, blocks: int) -> int:
        """Cycles of one launch over `blocks` blocks, exactly: the words never meet in a bank."""
        start, loop = self.program.table
        switch = self.program.fabric.controller.switch_cycles
        return start.span + switch + (blocks - 1) * loop.ii + loop.span if blocks else 0

    def arguments(
        self, a: NDArray[np.float32], b: NDArray[np.float32], bias: NDArray[np.float32]
    ) -> dict[str, object]:
        """Arguments of a launch, by parameter.

        Parameters
        ----------
        a
            float32 [blocks * rows, depth].
        b
            float32 [depth, cols].
        bias
            float32 [cols].
        """
        named: dict[str, object] = {bias_name(j): float(bias[j]) for j in range(self.layout.cols)}
        named[BUFFER] = self.layout.pack(a, b).reshape(-1, _LINE)
        named[_BLOCKS] = a.shape[0] // self.layout.rows
        return named


@lru_cache(maxsize=16)
def gemm_program(fabric: str | Fabric, depth: int, *, relu: bool = False) -> GemmProgram:
    """The program for products with inner dimension `depth` on `fabric`.

    Raises
    ------
    ArchError, SystolicError
        No such fabric; it is no systolic array; or its memories are too small for `depth`.
    """
    machine = arch.load(fabric) if isinstance(fabric, str) else fabric
    array = SystolicArray.of(machine)
    region = gemm_region(array, depth, relu=relu)
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
    biases = (Param(bias_name(j), DType.F32) for j in range(array.cols))
    params = (Param(BUFFER, DType.F32, 2), Param(_BLOCKS, DType.I32), *biases)
    regions = (
        Region("start", "straight", start, next=1),
        Region("gemm", "loop", region.dfg, counted=True),
    )
    return Kernel("gemm", params, regions), {0: first, 1: region.mapping}


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
