"""KiloNeRF in float8: its words, its kernels as numba runs them, and crops on the array."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import vividc
from vividc.formats import E4M3, round_array, to_floats
from vividc.render import SceneError, psnr, read_scene, read_views, render_reference, scaled_camera
from vividc.render.array import ArrayOptions, render_array
from vividc.render.array.device.programs import kernel_folder, kernel_module
from vividc.render.array.models.kilonerf_words import CHUNK_WORDS, fp8_words, in_words, scales
from vividc.render.radiance import KiloNeRF
from vividc.render.radiance.kilonerf import positional_encoding
from vividc.render.radiance.layers import relu, sigmoid

MIC = Path(__file__).parents[3] / "scenes" / "mic"
KERNELS = kernel_module(kernel_folder() / "render" / "kilonerf_fp8.py")
SAMPLES = 5
ROOM = (SAMPLES + 1) * CHUNK_WORDS


@pytest.fixture(scope="module")
def model() -> KiloNeRF:
    return read_scene(MIC / "mic_kilonerf.npz")[1]


def numbers(words: np.ndarray) -> np.ndarray:
    """Numbers of rows of float8 words."""
    return to_floats(E4M3, np.ascontiguousarray(words).view(np.uint8))


def rounded(values: np.ndarray) -> np.ndarray:
    return to_floats(E4M3, round_array(E4M3, values))


def _words(values: np.ndarray) -> np.ndarray:
    """Float8 words of samples' values, with room for one more sample."""
    codes = round_array(E4M3, np.ascontiguousarray(values)).reshape(-1).view(np.uint32)
    return np.pad(codes, (0, ROOM - len(codes)))


def exact_model(model: KiloNeRF) -> KiloNeRF:
    """Two networks in which a neuron takes one input times a power of two: float8 is exact."""
    rng = np.random.default_rng(3)
    weights = []
    for array in model.weights:
        _, inputs, neurons = array.shape
        one = np.zeros((2, inputs, neurons), np.float32)
        for network in range(2):
            source = rng.integers(0, inputs, neurons)
            one[network, source, np.arange(neurons)] = rng.choice([0.5, 1, -1, 2], neurons)
        weights.append(one)
    biases = tuple(np.zeros((2, array.shape[1]), np.float32) for array in model.biases)
    return replace(model, weights=tuple(weights), biases=biases)


def terms(vectors: np.ndarray, levels: int) -> np.ndarray:
    """Terms of an encoding in the order of its words, filled up to whole chunks."""
    exact = positional_encoding(vectors, levels)
    order = in_words(np.eye(exact.shape[1], dtype=np.float32)[None], levels)[0]
    return exact @ order.T


def test_encodings_are_the_references_terms() -> None:
    vectors = np.random.default_rng(6).uniform(-1, 1, (200, 3)).astype(np.float32)
    low, high, seen = (np.zeros((200, CHUNK_WORDS), np.uint32) for _ in range(3))
    KERNELS.encode_position(vectors, low.reshape(-1), high.reshape(-1))
    KERNELS.encode_direction(vectors, seen)
    # Half a last place of what is below 1, and the error of doubling.
    both = np.concatenate((numbers(low), numbers(high)), axis=1)
    np.testing.assert_allclose(both, terms(vectors, 10), atol=2.0**-5 + 2.0**-10)
    np.testing.assert_allclose(numbers(seen), terms(vectors, 4), atol=2.0**-5 + 2.0**-10)


@pytest.mark.slow
@pytest.mark.parametrize("network", [0, 1])
def test_networks_without_rounding_are_the_references(model: KiloNeRF, network: int) -> None:
    model = exact_model(model)
    words = fp8_words(model)
    rng = np.random.default_rng(4)
    position, direction = (rng.standard_normal((SAMPLES, n)).astype(np.float32) for n in (64, 32))
    position, direction = rounded(position), rounded(direction)
    position[:, 63:] = direction[:, 27:] = 0
    low, high = (_words(half) for half in np.split(position, 2, 1))
    features, hidden = np.zeros(ROOM, np.uint32), np.zeros(ROOM, np.uint32)
    weights = words.density[network]
    KERNELS.two_chunk_layer(low, high, weights, 0, SAMPLES, features)
    KERNELS.one_chunk_layer(features, weights, KERNELS.SECOND, SAMPLES, low, np.uint32(0))
    KERNELS.one_chunk_layer(low, weights, KERNELS.THIRD, SAMPLES, features, KERNELS.LOWEST)
    sums = [KERNELS.neuron(low, sample, weights, KERNELS.LAST) for sample in range(SAMPLES)]
    density = np.array(sums, np.float32) * words.density_units[network]
    colours = np.zeros((SAMPLES, 3), np.float32)
    unit = words.colour_units[network]
    KERNELS.colour_network(
        features, _words(direction), hidden, words.colour[network], unit, colours
    )
    w1, w2, w3, w4, w5 = (array[network] for array in model.weights)
    ordered = in_words(w1[None], 10)[0]
    result = relu(relu(position @ ordered) @ w2) @ w3
    np.testing.assert_array_equal(density, result[:, 0])
    by_direction = in_words(w4[None, 32:], 4)[0]
    layer = relu(result[:, 1:] @ w4[:32] + direction @ by_direction)
    np.testing.assert_allclose(colours, sigmoid(layer @ w5), rtol=0.05)


def test_scales_keep_results_and_weights_within_the_format() -> None:
    weights = np.full((3, 4, 2), 1e-3, np.float32)
    weights[1] = 300
    largest = np.array([1.0, 1.0, 0.0], np.float32)
    np.testing.assert_array_equal(scales(largest, (weights, 0)), [6, 0, 18])
    np.testing.assert_array_equal(scales(largest, (weights, np.array([1, 1, 1]))), [6, 1, 19])
    assert (scales(np.zeros(2, np.float32), (np.zeros((2, 4, 2), np.float32), 0)) < 99).all()


def test_what_float8_cannot_do_is_refused(model: KiloNeRF) -> None:
    camera = scaled_camera(read_views(MIC / "ref_kilo.npz")[0].camera, 8, 8)
    with pytest.raises(SceneError, match="in fp32 or fp8 only"):
        render_array(model, camera, ArrayOptions(precision="fp16"))
    sizes = ((63, 24), (24, 24), (24, 25), (51, 24), (24, 3))
    narrow = replace(
        model,
        weights=tuple(np.zeros((2, *size), np.float32) for size in sizes),
        biases=tuple(np.zeros((2, size[1]), np.float32) for size in sizes),
    )
    with pytest.raises(SceneError, match="24 wide, and float8 takes 32"):
        render_array(narrow, camera, ArrayOptions(precision="fp8"))


def test_networks_that_leave_float32_are_refused(model: KiloNeRF) -> None:
    first = model.weights[0].copy()
    first[7] = 1e38
    large = replace(model, weights=(first, *model.weights[1:]))
    with pytest.raises(SceneError, match="results of network 7 leave float32"):
        fp8_words(large)


@pytest.mark.slow
@pytest.mark.parametrize("kernel", ["density_network", "colour_network"])
def test_networks_on_a_tile_are_numbas(model: KiloNeRF, kernel: str) -> None:
    words = fp8_words(model)
    rng = np.random.default_rng(8)
    local = rng.uniform(-1, 1, (SAMPLES, 3)).astype(np.float32)
    chunks = [_words(rng.standard_normal((SAMPLES, 32)).astype(np.float32)) for _ in range(3)]
    function = getattr(KERNELS, kernel)
    program = vividc.compile(function, loops=vividc.LoopOptions(auto=False), time_limit_s=60.0)
    results = []
    for run in (function, lambda *arguments: vividc.simulate(program, *arguments)):
        arrays, weights = [chunk.copy() for chunk in chunks], words.colour[5]
        out = np.zeros((SAMPLES, 3), np.float32)
        if kernel == "density_network":
            arrays, weights = [local, *arrays], words.density[5]
            out = np.zeros(SAMPLES, np.float32)
            run(*arrays, weights, np.float32(0.01), out)
        else:
            run(*arrays, weights, np.float32(0.01), out)
        results.append([array.view(np.uint32) for array in (*arrays, out)])
    for host, array in zip(*results, strict=True):
        np.testing.assert_array_equal(host, array)


@pytest.mark.slow
def test_a_float8_picture_is_near_the_references(model: KiloNeRF) -> None:
    camera = scaled_camera(read_views(MIC / "ref_kilo.npz")[0].camera, 20, 20)
    whole = render_array(model, camera)
    frame = render_array(model, camera, ArrayOptions(precision="fp8"))
    assert psnr(frame.image, render_reference(model, camera).image) > 30
    cycles = [{stage.name: stage.cycles for stage in f.stages} for f in (whole, frame)]
    encoding = cycles[0]["position encoding"]  # in float8 the density network makes it
    assert cycles[1]["density network"] < 0.7 * (cycles[0]["density network"] + encoding)
    # Of so few pixels, configuration and filling are a good part.
    assert cycles[1]["colour network"] < 0.75 * cycles[0]["colour network"]
    late = render_array(model, camera, ArrayOptions(precision="fp8", lookahead=False))
    np.testing.assert_array_equal(frame.image, late.image)
