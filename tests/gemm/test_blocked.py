"""Products cut to what scratchpads hold, on the accelerator."""

from __future__ import annotations

import numpy as np
import pytest

from vividc import arch
from vividc.gemm.blocked import Operands, Sizes, add_product, stacked, tiled, unstacked
from vividc.gemm.passes import with_arrays
from vividc.launch import Job

VIVID = with_arrays(arch.load_accelerator("vivid"))
RNG = np.random.default_rng(8)


@pytest.mark.parametrize("depth", [5, 40, 600])
def test_sums_go_on_from_part_to_part_of_the_inner_dimension(depth: int) -> None:
    sizes = Sizes(21, 13, depth)
    tiling = tiled(sizes, "tpu-partitioned", VIVID, added=True)
    assert sum(tiling.depths) == depth
    side = tiling.array.rows
    a, b, c = (
        RNG.integers(-4, 5, shape).astype(np.float32)
        for shape in ((21, depth), (depth, 13), (21, 13))
    )
    start = stacked(c if tiling.is_swapped(0) else c.T, side)
    job = Job(VIVID)
    made, _ = add_product(job, tiling, Operands(stacked(a, side), stacked(b.T, side), start))
    cycles = job.simulate().cycles
    np.testing.assert_array_equal(unstacked(made, 21, 13), a @ b + c)
    assert tiling.cycles(VIVID) == pytest.approx(cycles, rel=0.4)


def test_a_large_product_is_estimated_above_60_percent_of_the_peak() -> None:
    tiling = tiled(Sizes(1024, 1024, 1024), "tpu-unified", VIVID, added=True)
    peak = 1024**3 / sum(len(tile.pes) for tile in VIVID.tiles)
    assert peak / tiling.cycles(VIVID) > 0.6
