"""Loops that wait for no dependence through memory compute what numba does, on both engines."""

from __future__ import annotations

from copy import deepcopy

import numpy as np
import pytest

import vividc
from tests.ssa.polyhedral import dependence_kernels as k


@pytest.mark.parametrize(
    ("kernel", "ii"),
    [(k.backwards, 1), (k.by_three, 1), (k.rows, 1), (k.triangle, 1), (k.carried_backwards, 7)],
    ids=lambda item: getattr(item, "name", ""),
)
def test_loops_at_their_resources(kernel: vividc.KernelFunction, ii: int) -> None:
    loops = vividc.LoopOptions(auto=False)
    program = vividc.compile(kernel, "vivid-tile", loops=loops, time_limit_s=60.0)
    (found,) = (region.ii for region in program.regions if region.kind == "loop")
    assert found == ii
    random = np.random.default_rng(3)
    arrays = [random.standard_normal(shape).astype(np.float32) for shape in ((6, 6), 40)]
    expected = deepcopy(arrays)
    kernel(*expected, np.int32(9))
    for engine in ("reference", "native"):
        actual = deepcopy(arrays)
        vividc.simulate(program, *actual, 9, engine=engine)
        for ours, theirs in zip(actual, expected, strict=True):
            assert np.array_equal(ours, theirs)
