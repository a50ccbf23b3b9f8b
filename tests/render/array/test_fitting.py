"""Weights of a format whose sums are near those of float32."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from vividc.formats import E4M3
from vividc.render import read_scene
from vividc.render.array.models.kilonerf_fit import Scales, fitted_networks
from vividc.render.array.network.calibration import Calibrated, calibrated
from vividc.render.array.network.fitting import fitted, rounded
from vividc.render.arrays import Float32Array
from vividc.render.radiance import InstantNGP, KiloNeRF

MIC = Path(__file__).parents[3] / "scenes" / "mic"


def layer(
    seed: int, layers: int, samples: int, inputs: int, outputs: int
) -> tuple[Float32Array, Float32Array, Float32Array]:
    """Inputs of E4M3 that depend on one another, sums, and weights."""
    rng = np.random.default_rng(seed)
    mixed = rng.standard_normal((layers, samples, 4)) @ rng.standard_normal((layers, 4, inputs))
    noise = rng.standard_normal((layers, samples, inputs))
    x = rounded(E4M3, (mixed + noise / 4).astype(np.float32), np.zeros(mixed.shape, np.int64))
    weights = rng.standard_normal((layers, inputs, outputs)).astype(np.float32)
    bias = rng.standard_normal((layers, 1, outputs)).astype(np.float32)
    return x, (x @ weights + bias).astype(np.float32), weights


def loss(x: Float32Array, sums: Float32Array, weights: Float32Array, bias: Float32Array) -> float:
    return float(np.square(x @ weights + bias[:, None] - sums).mean())


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("samples", "inputs"), [(200, 20), (10, 20), (1, 3), (500, 1)])
def test_sums_are_nearer_than_with_weights_rounded_as_they_are(
    seed: int, samples: int, inputs: int
) -> None:
    x, sums, weights = layer(seed, 3, samples, inputs, 5)
    exponents = np.full(weights.shape, 3)
    found, bias = fitted(E4M3, x, sums, weights, exponents)
    np.testing.assert_array_equal(rounded(E4M3, found, exponents), found)
    plain = rounded(E4M3, weights, exponents)
    exact = (sums - x @ weights).mean(axis=1)
    assert loss(x, sums, found, bias) < loss(x, sums, plain, exact)
    if samples > 2 * inputs > 2:
        assert loss(x, sums, found, bias) < 0.6 * loss(x, sums, plain, exact)


def test_layers_are_fitted_each_for_itself() -> None:
    x, sums, weights = layer(1, 4, 50, 8, 3)
    exponents = np.random.default_rng(2).integers(-2, 4, weights.shape)
    together = fitted(E4M3, x, sums, weights, exponents)
    for k in range(4):
        one = slice(k, k + 1)
        alone = fitted(E4M3, x[one], sums[one], weights[one], exponents[one])
        np.testing.assert_array_equal(alone[0], together[0][one])
        np.testing.assert_array_equal(alone[1], together[1][one])


@pytest.mark.parametrize("scale", [0.0, 1e-30, 1e15, 2.0**60])
@pytest.mark.parametrize("factor", [1e-15, 1.0, 1e15])
def test_inputs_and_sums_of_any_size_give_numbers(scale: float, factor: float) -> None:
    x, _, weights = layer(3, 2, 40, 6, 2)
    x[0] *= np.float32(scale)
    sums = np.float32(factor) * (x @ weights)
    found, bias = fitted(E4M3, x, sums, weights, np.zeros(weights.shape, np.int64))
    assert np.isfinite(found).all()
    assert np.isfinite(bias).all()


@pytest.mark.parametrize("power", [-30, -3, 5, 40])
def test_powers_of_two_change_nothing_else(power: int) -> None:
    x, sums, weights = layer(5, 2, 80, 7, 3)
    exponents = np.full(weights.shape, 2)
    found, bias = fitted(E4M3, x, sums, weights, exponents)
    larger = np.ldexp(x, power), np.ldexp(sums, 2)
    other = fitted(E4M3, *larger, np.ldexp(weights, 2 - power), exponents - 2 + power)
    np.testing.assert_array_equal(np.ldexp(other[0], power - 2), found)
    np.testing.assert_array_equal(np.ldexp(other[1], -2), bias)


def test_an_input_that_never_changes_is_the_biases() -> None:
    x, sums, weights = layer(4, 1, 60, 5, 2)
    x[:, :, 2] = 8.0
    sums = (x @ weights).astype(np.float32)
    exponents = np.zeros(weights.shape, np.int64)
    found, bias = fitted(E4M3, x, sums, weights, exponents)
    plain = rounded(E4M3, weights, exponents)
    assert loss(x, sums, found, bias) < loss(x, sums, plain, 0 * bias)


def kilonerf() -> KiloNeRF:
    scene = read_scene(MIC / "mic_kilonerf.npz")[1]
    assert isinstance(scene, KiloNeRF)
    return scene


def test_networks_are_fitted_whichever_are_computed_together(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = kilonerf()
    few = KiloNeRF(
        scene.march,
        np.where(scene.network < 5, scene.network, -1),
        tuple(weights[:5] for weights in scene.weights),
        tuple(biases[:5] for biases in scene.biases),
        scene.transmittance_min,
    )
    exponents = np.full(5, 4)
    scales = Scales(*(exponents for _ in range(6)))
    together = fitted_networks(few, scales)
    monkeypatch.setattr("vividc.render.array.models.kilonerf_fit.AT_ONCE", 2)
    for one, other in zip(together, fitted_networks(few, scales), strict=True):
        for a, b in zip(one, other, strict=True):
            np.testing.assert_array_equal(a, b)
    grid = exponents_of(few, exponents)
    for weights, before in zip(together[0], grid, strict=True):
        np.testing.assert_array_equal(rounded(E4M3, weights, before), weights)


def exponents_of(scene: KiloNeRF, exponents: npt.NDArray[np.int64]) -> list[npt.NDArray[np.int64]]:
    """Of each layer's weights where all results have one scale: encodings have none."""
    grid = [np.zeros(weights.shape, np.int64) for weights in scene.weights]
    grid[0] += exponents[:, None, None]
    grid[3][:, 32:] += exponents[:, None, None]
    return grid


def test_float32_and_fp16_keep_the_weights() -> None:
    scene = read_scene(MIC / "mic_ngp_hash.npz")[1]
    assert isinstance(scene, InstantNGP)
    nets = {"sigma": Calibrated(scene.density_weights), "rgb": Calibrated(scene.colour_weights)}
    assert calibrated(scene, "fp32", nets) == [*nets.values()]
    for made, given in zip(calibrated(scene, "fp16", nets), nets.values(), strict=True):
        assert made.weights is given.weights
        assert len(made.largest) == len(given.weights)
    sigma, rgb = calibrated(scene, "fp8", nets)
    for made, given in zip(
        (*sigma.weights, *rgb.weights), (*scene.density_weights, *scene.colour_weights), strict=True
    ):
        assert made.shape == given.shape
        assert 0 < np.abs(made - given).max() < 0.2 * np.abs(given).max()
    assert [len(bias) for bias in rgb.biases] == [w.shape[1] for w in scene.colour_weights]
