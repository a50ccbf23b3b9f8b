"""The stages of the renderers: against numba by interpretation and on the tile, and the Gaussian
ones against `vividc.render`.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import vividc
from benchmarks.render_kernels import COUNT, WORKLOADS, limit, scene, view_arguments
from tests.e2e.test_kernels import assert_close
from vividc import arch
from vividc.dfg.interpreter import interpret
from vividc.driver import lower
from vividc.render.spherical_harmonics import sh_colour
from vividc.sim.bind import bind

BY_NAME = {workload.name: workload for workload in WORKLOADS}
QUICK = {"radix_scatter", "volume_blend", "dense_relu", "tile_entries", "vm_density"}
ON_TILE = [pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in BY_NAME]


@pytest.mark.parametrize("name", BY_NAME)
def test_its_graphs_mean_what_numba_means(name: str) -> None:
    workload = BY_NAME[name]
    kernel, ours, theirs = workload.kernel(), workload.fresh(), workload.fresh()
    lowered = lower(kernel)
    launch = SimpleNamespace(
        name=lowered.name,
        params=lowered.params,
        fabric=arch.load("vivid-tile"),
        banks={},
        locals=lowered.locals,
        stored_arrays=frozenset(),
    )
    bound = bind(launch, ours, {})  # type: ignore[arg-type]
    memory = bound.memory.copy()
    done = interpret(lowered, memory, bound.inputs)
    bound.copy_back(memory, frozenset(bound.arrays))
    value = kernel(*theirs)
    assert_close(ours, theirs)
    assert value is None or done.value == value


@pytest.mark.parametrize("name", ON_TILE)
def test_it_runs_on_the_tile(name: str) -> None:
    workload = BY_NAME[name]
    kernel, ours, theirs = workload.kernel(), workload.fresh(), workload.fresh()
    result = vividc.simulate(vividc.compile(kernel, time_limit_s=60.0), *ours)
    value = kernel(*theirs)
    assert_close(ours, theirs)
    assert result.value == value


def test_projection_is_the_references() -> None:
    """Means, covariances, conics and radii of Gaussians of `mic`, as `vividc.render` has them."""
    gaussians, _, projection = scene()
    view, focal, centre_x, centre_y = view_arguments()
    pixel, depth = np.zeros((COUNT, 2), np.float32), np.zeros(COUNT, np.float32)
    host("project_means")(gaussians.means.copy(), view, focal, centre_x, centre_y, pixel, depth)
    spatial = np.zeros((COUNT, 6), np.float32)
    host("covariance_3d")(gaussians.scales.copy(), gaussians.rotations.copy(), spatial)
    flat = np.zeros((COUNT, 3), np.float32)
    host("covariance_2d")(gaussians.means.copy(), spatial, view, focal, limit(), flat)
    conic, radius = np.zeros((COUNT, 3), np.float32), np.zeros(COUNT, np.float32)
    host("conic_and_radius")(flat, conic, radius)
    seen, splats = projection.index, projection.splats
    assert len(seen) > COUNT // 2
    close = {"rtol": 2e-4, "atol": 2e-4}
    np.testing.assert_allclose(pixel[seen, 0], splats.mean_x, **close)
    np.testing.assert_allclose(pixel[seen, 1], splats.mean_y, **close)
    np.testing.assert_allclose(depth[seen], projection.depth, **close)
    np.testing.assert_allclose(conic[seen, 0], splats.conic_a, **close)
    np.testing.assert_allclose(conic[seen, 1], splats.conic_b, **close)
    np.testing.assert_allclose(conic[seen, 2], splats.conic_c, **close)
    assert np.abs(radius[seen] - projection.radius).max() <= 1  # a ceiling next to an integer


def test_colours_are_the_references() -> None:
    directions, sh, colour = BY_NAME["sh_colour"].fresh()
    host("sh_colour")(directions, sh, colour)
    expected = sh_colour(np.asarray(sh), np.asarray(directions))
    np.testing.assert_allclose(np.asarray(colour), expected, rtol=1e-5, atol=1e-6)


def test_a_radix_sort_of_its_passes_sorts() -> None:
    """Eight passes of 4 bits, stable, as the depth sort of the reference."""
    keys = np.random.default_rng(5).integers(0, 1 << 32, 300, dtype=np.uint32)
    keys[100:150] = keys[:50]
    expected = np.argsort(keys, kind="stable")
    values, counts = np.arange(300, dtype=np.int32), np.zeros(16, np.int32)
    for shift in range(0, 32, 4):
        host("radix_histogram")(keys, shift, counts)
        host("radix_offsets")(counts)
        sorted_keys, sorted_values = np.zeros_like(keys), np.zeros_like(values)
        host("radix_scatter")(keys, values, shift, counts, sorted_keys, sorted_values)
        keys, values = sorted_keys, sorted_values
    np.testing.assert_array_equal(values, expected)


def test_every_file_has_only_kernels_of_the_table() -> None:
    """A kernel that nobody runs would be a claim without proof."""
    for file in {workload.file for workload in WORKLOADS}:
        names = {workload.name for workload in WORKLOADS if workload.file == file}
        first = next(workload for workload in WORKLOADS if workload.file == file)
        scope = first.kernel().py_func.__globals__
        assert {n for n, v in scope.items() if isinstance(v, vividc.KernelFunction)} == names


def host(name: str) -> vividc.KernelFunction:
    """The kernel, to be run by numba."""
    return BY_NAME[name].kernel()
