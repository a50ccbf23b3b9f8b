"""Networks on operands of 16 and 8 bits: scales, rounding on the tiles, and pictures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.render.array.by_numba import Host, samples_of, shown
from vividc.formats import E4M3, F16, FORMATS, Format, round_array, to_floats
from vividc.gemm import Layer
from vividc.gemm.packed import packed
from vividc.render import (
    SceneError,
    psnr,
    read_scene,
    read_views,
    render_reference,
    scaled_camera,
)
from vividc.render.array import (
    ArrayField,
    ArrayOptions,
    RenderPrecision,
    open_device,
    render_array,
)
from vividc.render.array.models.instant_ngp import InstantNGPField
from vividc.render.array.models.tensorf import TensoRFField
from vividc.render.array.network import networks
from vividc.render.array.network.calibration import exponents, largest_inputs
from vividc.render.array.network.networks import Network, dense_layer, network
from vividc.render.arrays import Float32Array
from vividc.render.radiance.layers import linear

MIC = Path(__file__).parents[3] / "scenes" / "mic"
FIELDS = {"mic_ngp_hash.npz": InstantNGPField, "mic_tensorf_vm.npz": TensoRFField}
Make = Callable[..., ArrayField]


@pytest.fixture
def host(monkeypatch: pytest.MonkeyPatch) -> Host:
    monkeypatch.setattr(networks, "tpu_choice", lambda *_: ("tpu-unified", 1))
    monkeypatch.setattr(networks, "run_systolic", systolic_by_numpy)
    return Host()


def systolic_by_numpy(
    device: Host,
    stage: str,
    layers: Sequence[Layer],
    blocks: Float32Array,
    mode: str,
    *,
    words: bool,
) -> Float32Array:
    """The sums of the arrays: products of rounded operands, one after the other."""
    assert words
    fmt = FORMATS[layers[0].precision]
    rows = np.ascontiguousarray(blocks.transpose(0, 2, 1)).reshape(-1, blocks.shape[1])
    values = to_floats(fmt, rows.view(fmt.dtype))[:, : layers[0].weights.shape[0]]
    for number, layer in enumerate(layers):
        if number:
            values = to_floats(fmt, round_array(fmt, values))
        weights = to_floats(fmt, round_array(fmt, layer.weights))
        assert layer.bias is not None
        sums = np.repeat(layer.bias[None], len(values), axis=0)
        for column, row in zip(values.T, weights, strict=True):
            sums += column[:, None] * row
        values = np.maximum(sums, 0) if layer.activation == "relu" else sums
    values = packed(values, layers[-1].results)
    return np.ascontiguousarray(values.reshape(len(blocks), 16, -1).transpose(0, 2, 1))


@pytest.mark.parametrize("fmt", [F16, E4M3], ids=["fp16", "fp8"])
@pytest.mark.parametrize("gain", [1e-3, 1.0, 300.0])
def test_scales_pass_from_layer_to_layer(fmt: Format, gain: float) -> None:
    largest = [3.0 * gain, 0.2, 17.0]
    weights = [np.full((4, 4), value, np.float32) for value in (0.7 / gain, 2.0, 0.3)]
    inputs, factors_ = exponents(largest, weights, fmt)
    assert [a + b for a, b in zip(inputs, factors_, strict=True)] == [*inputs[1:], 0]
    for value, matrix, before, factor in zip(largest, weights, inputs, factors_, strict=True):
        own, other = value * 2.0**before, float(matrix.max()) * 2.0**factor
        assert max(own, other) <= fmt.max_finite
        assert 0.25 < own / other < 4  # the room above is shared
    zeros = [np.zeros((2, 2), np.float32)]
    assert exponents([1.0], zeros, fmt) == ([0], [0])


def test_what_no_scale_fits_is_refused() -> None:
    weights = [np.full((4, 4), 1e4, np.float32)]
    assert exponents([1e3], weights, F16) == ([2], [-2])
    with pytest.raises(SceneError, match=r"inputs of up to 1e\+03 and weights .* not fit e4m3"):
        exponents([1e3], weights, E4M3)
    model = read_scene(MIC / "mic_ngp_hash.npz")[1]
    large = tuple(matrix * np.float32(1e30) for matrix in model.density_weights)
    with pytest.raises(SceneError, match="inputs of the layer rgb0 leave float32"):
        largest_inputs(replace(model, density_weights=large))


@pytest.mark.parametrize("file", FIELDS)
def test_calibration_is_the_same_each_time(file: str) -> None:
    model = read_scene(MIC / file)[1]
    found = largest_inputs(model)
    assert found == largest_inputs(model)
    assert all(0.1 < value < 100 for value in found.values())
    names = {"mic_ngp_hash.npz": "sigma0 sigma1 rgb0 rgb1 rgb2", "mic_tensorf_vm.npz": "basis mlp0"}
    assert set(names[file].split()) <= set(found)
    march = replace(model.march, occupied=np.zeros_like(model.march.occupied))
    assert all(value > 0 for value in largest_inputs(replace(model, march=march)).values())


@pytest.mark.parametrize("inputs", [1, 27, 32])
def test_tiles_round_as_the_format_does(inputs: int, host: Host) -> None:
    rng = np.random.default_rng(3)
    net = network([dense_layer(np.ones((inputs, 3)))], "fp16", [3.0])
    blocks = net.empty(5)
    blocks[:, :inputs] = 3 * rng.standard_normal((5, inputs, 16))
    assert blocks.shape == (5, net.features, 16)
    found = net.rounded(host, blocks)
    rows = (blocks * net.scale).transpose(0, 2, 1).reshape(80, -1)
    exact = packed(rows, net.layers[0].precision).reshape(5, 16, -1).transpose(0, 2, 1)
    assert found.tobytes() == np.ascontiguousarray(exact).tobytes()


@pytest.mark.parametrize("precision", [pytest.param("fp16", marks=pytest.mark.slow), "fp8"])
@pytest.mark.parametrize(("file", "make"), FIELDS.items())
def test_narrow_fields_are_near_the_reference(
    file: str, make: Make, precision: RenderPrecision, host: Host
) -> None:
    """Whether kernels round themselves or not; and a sample does not depend on the others."""
    model = read_scene(MIC / file)[1]
    given = samples_of(model.march, 200)
    field = make(model, host, precision)
    alpha, colour = shown(host, field, *given)
    thickness, features = model.density(given[0], linear)
    truth = model.colour(given[0], features, given[1], linear)
    bound = {"fp16": 2e-3, "fp8": 0.12}[precision]
    assert np.abs(colour - truth).mean() < bound / 4
    assert np.abs(colour - truth).max() < bound
    np.testing.assert_allclose(alpha, 1 - np.exp(-thickness), rtol=8 * bound, atol=1e-4)
    least = float(np.median(alpha))
    fewer, part = shown(host, field, *given, least)
    np.testing.assert_array_equal(fewer, np.where(alpha > least, alpha, 0))
    np.testing.assert_array_equal(part, np.where(alpha[:, None] > least, colour, 0))


def test_features_that_fill_no_words_are_filled_up(host: Host) -> None:
    model = read_scene(MIC / "mic_ngp_hash.npz")[1]
    density, colour = model.density_weights, model.colour_weights
    odd = replace(
        model,
        density_weights=(density[0], density[1][:, :15]),
        colour_weights=(np.delete(colour[0], 15, axis=0), *colour[1:]),
    )
    points, directions = samples_of(odd.march, 40)
    exact = odd.colour(points, odd.density(points, linear)[1], directions, linear)
    _, found = shown(host, InstantNGPField(odd, host, "fp8"), points, directions)
    assert np.abs(found - exact).max() < 0.12


def test_a_piece_has_no_more_samples_than_items_can_number(
    monkeypatch: pytest.MonkeyPatch, host: Host
) -> None:
    """Of a larger scratchpad there would be room for more."""
    model = read_scene(MIC / "mic_ngp_hash.npz")[1]
    found = []
    for kib in (16, 32, 64, 512):
        monkeypatch.setattr(host, "scratchpad_bytes", kib << 10)
        found.append(InstantNGPField(model, host, "fp8").most_samples)
    assert 0 < found[0] < found[1] < 1024
    assert found[2:] == [1024, 1024]


def test_an_accelerator_without_modes_is_refused() -> None:
    net: Network = network([dense_layer(np.ones((4, 4)))], "fp8", [1.0])
    device = open_device("vivid-unit")
    with pytest.raises(SceneError, match="vivid-unit cannot run layers of fp8 numbers"):
        net.run(device, "network", net.empty(2))
    assert net.run(device, "network", net.empty(0)).shape == (0, 2, 16)
    for file, make in FIELDS.items():  # before anything is rendered
        with pytest.raises(SceneError, match="vivid-unit cannot run layers of fp8 numbers"):
            make(read_scene(MIC / file)[1], device, "fp8")


@pytest.mark.slow
@pytest.mark.parametrize("precision", ["fp16", "fp8"])
@pytest.mark.parametrize("file", FIELDS)
def test_narrow_pictures_of_the_array(file: str, precision: RenderPrecision) -> None:
    model = read_scene(MIC / file)[1]
    camera = scaled_camera(read_views(MIC / "ref_ngp.npz")[0].camera, 24, 24)
    frame = render_array(model, camera, ArrayOptions(precision=precision))
    least = {"fp16": 70, "fp8": 40}[precision]
    assert least < psnr(frame.image, render_reference(model, camera).image) < 110
    late = render_array(model, camera, ArrayOptions(lookahead=False, precision=precision))
    np.testing.assert_array_equal(frame.image, late.image)
    assert late.counts["colour_samples"] > frame.counts["colour_samples"]
