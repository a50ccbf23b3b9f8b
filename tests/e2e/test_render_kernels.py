"""The render stages on the tile, against numba, and the Gaussian stages against `vividc.render`."""

from __future__ import annotations

import struct
from functools import cache

import numpy as np
import pytest

import vividc
from benchmarks import render_kernels as scene
from benchmarks.render_kernels import WORKLOADS
from benchmarks.workloads import Arguments
from tests.dfg.memory_trace import Trace
from tests.e2e.test_kernels import assert_close
from tests.sim.native.agreement import agreed_run
from vividc import arch
from vividc.compiler.driver import lower
from vividc.compiler.regions.map_regions import map_kernel
from vividc.compiler.stage import CompileOptions
from vividc.dfg.interpret.interpreter import interpret
from vividc.dfg.regions import Kernel
from vividc.program import encode
from vividc.render import bin_and_sort
from vividc.sim.bind import bind, returned
from vividc.sim.engine import Launch

BY_NAME = {workload.name: workload for workload in WORKLOADS}
QUICK = {"radix_histogram", "radix_offsets", "radix_scatter", "tile_ranges", "dense_relu"}
SCRATCHPAD_BYTES = 32 * 1024
COUNT = 300


@cache
def lowered(name: str) -> Kernel:
    return lower(kernel_of(name))


def word(value: object) -> int:
    """A scalar argument of 32 bits as the machine holds it."""
    if isinstance(value, np.floating):
        bits: int = struct.unpack("@I", struct.pack("@f", float(value)))[0]
        return bits
    assert isinstance(value, np.integer)
    return int(value) & 0xFFFFFFFF


def interpreted(kernel: Kernel, arguments: Arguments) -> int | float | bool | None:
    """Run the graphs on arrays laid end to end, updated in place; returns the kernel's value."""
    memory = bytearray()
    inputs: dict[str, int] = {}
    places: list[tuple[int, np.ndarray]] = []
    for param, value in zip(kernel.params, arguments, strict=True):
        if isinstance(value, np.ndarray):
            inputs[f"&{param.name}"] = len(memory)
            inputs |= {f"{param.name}.shape{k}": n for k, n in enumerate(value.shape)}
            places.append((len(memory), value))
            memory += value.tobytes()
        else:
            inputs[param.name] = word(value)
    done = interpret(kernel, memory, inputs)
    for start, array in places:
        raw = np.frombuffer(bytes(memory[start : start + array.nbytes]), array.dtype)
        if array.flags.writeable:
            array[...] = raw.reshape(array.shape)
        else:
            np.testing.assert_array_equal(raw, array.ravel())
    if kernel.returns is None or done.value is None:
        return None
    return returned(kernel.returns, done.value)


@pytest.mark.parametrize("name", list(BY_NAME))
def test_graphs_agree_with_numba(name: str) -> None:
    ours, numba = BY_NAME[name].fresh(), BY_NAME[name].fresh()
    value = kernel_of(name)(*numba)
    result = interpreted(lowered(name), ours)
    assert_close(ours, numba)
    assert result == value


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=() if n in QUICK else pytest.mark.slow) for n in BY_NAME]
)
def test_witnesses_agree(name: str) -> None:
    workload, machine = BY_NAME[name], arch.load("vivid-tile")
    mapped, results = map_kernel(lowered(name), machine, CompileOptions(time_limit_s=60.0))
    mappings = {i: r.mapping for i, r in results.items() if r.mapping is not None}
    program = encode(mapped, machine, mappings, reports=results)
    by_array, by_numba = workload.fresh(), workload.fresh()
    result = vividc.simulate(program, *by_array, engine="native")
    value = kernel_of(name)(*by_numba)
    assert_close(by_array, by_numba)
    assert result.value == value

    bound = bind(program, workload.fresh(), {})
    launch = Launch(bound.memory.copy(), bound.inputs, 10**6, bound.extents)
    run = agreed_run(program, launch)
    trace = Trace(lowered(name))
    done = interpret(lowered(name), bound.memory, bound.inputs, watch=trace)
    trace.demand_order()
    np.testing.assert_array_equal(bound.memory, run.memory)
    assert done.value == run.value


@pytest.mark.parametrize("name", list(BY_NAME))
def test_inputs_fit_a_scratchpad(name: str) -> None:
    arrays = [a for a in BY_NAME[name].fresh() if isinstance(a, np.ndarray)]
    assert sum(array.nbytes for array in arrays) <= SCRATCHPAD_BYTES


def test_every_kernel_is_in_the_table() -> None:
    for file in {workload.file for workload in WORKLOADS}:
        names = {w.name for w in WORKLOADS if w.file == file}
        first = next(w for w in WORKLOADS if w.file == file)
        found = first.kernel().py_func.__globals__
        assert {n for n, v in found.items() if isinstance(v, vividc.KernelFunction)} == names


@cache
def kernel_of(name: str) -> vividc.KernelFunction:
    kernel = BY_NAME[name].kernel()
    assert isinstance(kernel, vividc.KernelFunction)
    return kernel


def host(name: str, *arguments: object) -> object:
    return kernel_of(name)(*arguments)


def blank(*shape: int) -> np.ndarray:
    return np.zeros(shape, np.float32)


@cache
def chosen() -> np.ndarray:
    return scene.some(np.random.default_rng(3), COUNT)


def test_projection_equals_the_reference_renderer() -> None:
    camera, gaussians, projection = (
        scene.mic_camera(),
        scene.mic_gaussians(),
        scene.mic_projection(),
    )
    index = projection.index[chosen()]
    means, view, focal = gaussians.means[index], scene.view_matrix(), np.float32(camera.focal)
    pixel, depth = blank(COUNT, 2), blank(COUNT)
    centre = np.float32((camera.width - 1) / 2), np.float32((camera.height - 1) / 2)
    host("project_means", means, view, focal, *centre, pixel, depth)
    world, screen = blank(COUNT, 6), blank(COUNT, 3)
    host("covariance_3d", gaussians.scales[index], gaussians.rotations[index], world)
    limits = scene.view_limit(camera, camera.width), scene.view_limit(camera, camera.height)
    host("covariance_2d", means, world, view, focal, *limits, screen)
    conic, radius = blank(COUNT, 3), blank(COUNT)
    host("conic_and_radius", screen, conic, radius)

    splats = projection.splats.take(chosen())
    np.testing.assert_allclose(pixel.T, (splats.mean_x, splats.mean_y), rtol=1e-5, atol=1e-4)
    np.testing.assert_allclose(depth, projection.depth[chosen()], rtol=1e-6)
    # The determinant of a long thin footprint cancels, which magnifies the last bits.
    reference = np.stack((splats.conic_a, splats.conic_b, splats.conic_c), axis=1)
    np.testing.assert_allclose(conic, reference, rtol=1e-3, atol=1e-4)
    assert np.abs(radius - projection.radius[chosen()]).max() <= 1  # a ceil of rounded numbers
    assert np.mean(radius == projection.radius[chosen()]) > 0.99


def test_colour_equals_the_reference_renderer() -> None:
    gaussians, splats = scene.mic_gaussians(), scene.mic_projection().splats.take(chosen())
    index = scene.mic_projection().index[chosen()]
    offset = gaussians.means[index] - scene.mic_camera().position
    directions = offset / np.sqrt(np.einsum("ni,ni->n", offset, offset))[:, None]
    colour = blank(COUNT, 3)
    host("sh_colour", directions, np.ascontiguousarray(gaussians.sh[index]), colour)
    np.testing.assert_allclose(colour.T, (splats.red, splats.green, splats.blue), atol=1e-5)


def test_sorted_tiles_equal_the_reference_renderer() -> None:
    """From tile bounds to ranges, by eight passes over the depth and two over the tile."""
    projection, camera = scene.mic_projection(), scene.mic_camera()
    columns, rows = (-(-size // scene.TILE_PX) for size in (camera.width, camera.height))
    pixel = np.stack((projection.splats.mean_x, projection.splats.mean_y), axis=1)
    bounds, copies = np.zeros((len(pixel), 4), np.int32), np.zeros(len(pixel), np.int32)
    host("tile_bounds", pixel, projection.radius.copy(), columns, rows, bounds, copies)
    count = int(copies.sum())
    tiles, depths = np.zeros(count, np.uint32), np.zeros(count, np.uint32)
    splats = np.zeros(count, np.int32)
    bits = projection.depth.copy().view(np.uint32)
    assert host("tile_entries", bounds, copies, bits, columns, tiles, depths, splats) == count

    order = np.arange(count, dtype=np.int32)
    for keys, passes in ((depths, 8), (tiles, 2)):
        sorted_keys = keys[order]
        for digit in range(passes):
            sorted_keys, order = radix_pass(sorted_keys, order, 4 * digit)
    ranges = np.zeros((columns * rows, 2), np.int32)
    host("tile_ranges", tiles[order], ranges)

    reference = bin_and_sort(projection, camera.width, camera.height)
    np.testing.assert_array_equal(splats[order], reference.order)
    np.testing.assert_array_equal(ranges[:, 1] - ranges[:, 0], np.diff(reference.start))
    filled = ranges[:, 1] > 0
    np.testing.assert_array_equal(ranges[filled, 0], reference.start[:-1][filled])


def radix_pass(keys: np.ndarray, values: np.ndarray, shift: int) -> tuple[np.ndarray, np.ndarray]:
    """Keys and values by one digit of the keys."""
    counts = np.zeros(16, np.int32)
    host("radix_histogram", keys, shift, counts)
    host("radix_offsets", counts)
    sorted_keys, sorted_values = np.zeros_like(keys), np.zeros_like(values)
    host("radix_scatter", keys, values, shift, counts, sorted_keys, sorted_values)
    return sorted_keys, sorted_values


def test_the_far_edge_of_a_footprint_is_not_part_of_it() -> None:
    """As in the reference rasteriser: x + radius = 16 ends in tile 0, 17 meets tile 1."""
    pixel, radius = np.array([[9, 8], [10, 8]], np.float32), np.array([7, 7], np.float32)
    bounds, copies = np.zeros((2, 4), np.int32), np.zeros(2, np.int32)
    host("tile_bounds", pixel, radius, 4, 4, bounds, copies)
    np.testing.assert_array_equal(bounds, [[0, 0, 1, 1], [0, 0, 2, 1]])
    np.testing.assert_array_equal(copies, [1, 2])


def test_softplus_of_very_negative_features_is_not_zero() -> None:
    features, density = np.array([-20.0, 0.0, 60.0], np.float32), blank(3)
    arguments: Arguments = (features, np.float32(-10.0), density)
    interpreted(lowered("softplus"), arguments)
    np.testing.assert_allclose(density, np.logaddexp(0.0, features - 10.0), rtol=1e-5)
