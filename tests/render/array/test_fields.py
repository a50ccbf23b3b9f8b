"""Instant-NGP and TensoRF on the array against the float32 references, on samples of the mic."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tests.render.array.by_numba import Host, samples_of, shown
from vividc.render import (
    SceneError,
    psnr,
    read_scene,
    read_views,
    render_reference,
    scaled_camera,
)
from vividc.render.array import ArrayField, ArrayOptions, Device, Ledger, render_array
from vividc.render.array.models.hash_encoding import hash_encoding as encoding_of
from vividc.render.array.models.instant_ngp import InstantNGPField
from vividc.render.array.models.tensorf import TensoRFField
from vividc.render.array.network.networks import dense_layer, network
from vividc.render.array.network.systolic import run_systolic
from vividc.render.radiance.layers import linear

MIC = Path(__file__).parents[3] / "scenes" / "mic"


@dataclass(frozen=True)
class Method:
    file: str
    make: Callable[..., ArrayField]
    alpha: float
    colour: float


METHODS = {
    # The place in a cell of a level of 256 errs by 2**-16 or so, and the network amplifies it.
    "instant-ngp": Method("mic_ngp_hash.npz", InstantNGPField, 5e-4, 5e-4),
    "tensorf": Method("mic_tensorf_vm.npz", TensoRFField, 2e-4, 5e-5),
}


@pytest.fixture
def host() -> Host:
    return Host()


def assert_like_reference(method: Method, device: Device, count: int) -> Ledger:
    model = read_scene(MIC / method.file)[1]
    points, directions = samples_of(model.march, count)
    field = method.make(model, device)
    alpha, colour = shown(device, field, points, directions)
    thickness, features = model.density(points, linear)
    np.testing.assert_allclose(alpha, 1 - np.exp(-thickness), rtol=method.alpha, atol=1e-6)
    exact = model.colour(points, features, directions, linear)
    np.testing.assert_allclose(colour, exact, atol=method.colour)
    assert field.march is model.march
    assert field.weight_min == model.weight_min
    assert field.transmittance_min == model.transmittance_min
    return device.settle()


@pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
@pytest.mark.parametrize("count", [1, 300])
def test_kernels_by_numba_are_near_the_reference(method: Method, count: int, host: Host) -> None:
    assert_like_reference(method, host, count)


@pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
def test_a_sample_does_not_depend_on_the_others(method: Method, host: Host) -> None:
    """The picture is then the same to the last bit with and without lookahead."""
    model = read_scene(MIC / method.file)[1]
    given = samples_of(model.march, 200)
    field = method.make(model, host)
    alpha, colour = shown(host, field, *given)
    least = float(np.median(alpha))
    fewer, some = shown(host, field, *given, least)
    listed = alpha > least
    assert 90 < np.count_nonzero(listed) < 110
    np.testing.assert_array_equal(fewer, np.where(listed, alpha, 0))
    np.testing.assert_array_equal(some, np.where(listed[:, None], colour, 0))
    few, part = shown(host, field, *(array[3::7] for array in given))
    np.testing.assert_array_equal(few, alpha[3::7])
    np.testing.assert_array_equal(part, colour[3::7])


@pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
def test_no_samples_survive(method: Method, host: Host) -> None:
    model = read_scene(MIC / method.file)[1]
    field = method.make(model, host)
    alpha, colour = shown(host, field, *samples_of(model.march, 60), least=1)
    assert not alpha.any()
    assert not colour.any()


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
def test_the_array_is_near_the_reference(method: Method, device: Device) -> None:
    ledger = assert_like_reference(method, device, 700)
    assert all(stage.cycles > 0 for stage in ledger.stages.values())


@pytest.mark.slow
@pytest.mark.parametrize("name", METHODS)
def test_a_picture_of_the_array_is_the_references(name: str) -> None:
    model = read_scene(MIC / METHODS[name].file)[1]
    camera = scaled_camera(read_views(MIC / "ref_ngp.npz")[0].camera, 16, 16)
    frame = render_array(model, camera)
    assert psnr(frame.image, render_reference(model, camera).image) > 80
    late = render_array(model, camera, ArrayOptions(lookahead=False))
    np.testing.assert_array_equal(frame.image, late.image)
    assert late.counts["colour_samples"] > frame.counts["colour_samples"]


def test_cells_are_gathered_once_a_chunk(host: Host) -> None:
    """Samples of one cell in every level take one cell's rows in each."""
    model = read_scene(MIC / "mic_ngp_hash.npz")[1]
    points = np.repeat(samples_of(model.march, 1)[0], 128, axis=0)
    out = np.zeros((8, 32, 16), np.float32)
    encoding_of(model, None).encode(host, "encoding", points, out)
    assert host.ledger.counts["encoded_cells"] == len(model.levels)


@pytest.mark.parametrize("scale", [None, np.float32(64)])
def test_samples_with_more_cells_than_there_is_room_for_go_in_halves(
    scale: np.float32 | None, host: Host
) -> None:
    """Random points have a cell each in the fine levels; an odd last level is there twice."""
    model = read_scene(MIC / "mic_ngp_hash.npz")[1]
    model = replace(model, levels=model.levels[9:])
    points = np.random.default_rng(5).permutation(samples_of(model.march, 2000)[0])
    encoding = encoding_of(model, scale)
    width = encoding.features if scale is None else encoding.features // 4
    whole = np.zeros((125, width, 16), np.float32)
    encoding.encode(host, "encoding", points, whole)
    assert host.ledger.counts["words_read_by_host"] > 4 * -(-2000 // 128)
    apart = np.zeros((1, width, 16), np.float32)
    for block in (0, 60, 124):
        encoding.encode(host, "", points[16 * block : 16 * block + 16], apart)
        np.testing.assert_array_equal(apart[0].view(np.uint32), whole[block].view(np.uint32))
    if scale is None:
        np.testing.assert_array_equal(whole[:, -4:-2], whole[:, -2:])


def test_a_level_finer_than_a_cells_number_is_refused() -> None:
    model = read_scene(MIC / "mic_ngp_hash.npz")[1]
    fine = replace(model.levels[-1], scale=np.float32(2047))
    with pytest.raises(SceneError, match="2047 cells a side"):
        encoding_of(replace(model, levels=(*model.levels[:-1], fine)), None)


def test_other_numbers_of_features_a_row_are_refused() -> None:
    model = read_scene(MIC / "mic_ngp_hash.npz")[1]
    wide = replace(model.levels[0], table=np.zeros((4096, 4), np.float32))
    with pytest.raises(SceneError, match="4 features a row"):
        encoding_of(replace(model, levels=(wide, *model.levels[1:])), None)


def test_a_dense_level_of_too_few_entries_is_refused() -> None:
    model = read_scene(MIC / "mic_ngp_hash.npz")[1]
    short = replace(model.levels[0], table=model.levels[0].table[:2000])
    with pytest.raises(SceneError, match="2000 entries"):
        encoding_of(replace(model, levels=(short, *model.levels[1:])), None)


def test_a_box_outside_the_cube_is_refused() -> None:
    model = read_scene(MIC / "mic_ngp_hash.npz")[1]
    with pytest.raises(SceneError, match="leaves the cube"):
        encoding_of(replace(model, cube_side=model.cube_side / 2), None)


@pytest.mark.parametrize("sizes", [(5, 9, 3), (150, 128, 3), (64, 64)])
def test_networks_equal_numpy(sizes: tuple[int, ...], host: Host) -> None:
    rng = np.random.default_rng(1)
    weights = [rng.standard_normal(pair).astype(np.float32) for pair in pairwise(sizes)]
    biases = [rng.standard_normal(size).astype(np.float32) for size in sizes[1:]]
    x = rng.standard_normal((40, sizes[0], 16)).astype(np.float32)
    layers = [dense_layer(w, b, relu=True) for w, b in zip(weights, biases, strict=True)]
    found = network(layers, "fp32").run(host, "network", x)
    values = x.transpose(0, 2, 1)
    for weight, bias in zip(weights, biases, strict=True):
        values = np.maximum(values @ weight + bias, 0)
    np.testing.assert_allclose(found.transpose(0, 2, 1), values, rtol=1e-4, atol=1e-3)


def test_a_network_of_many_samples_runs_in_the_mode_of_fewer_cycles(device: Device) -> None:
    weights = [np.zeros(pair, np.float32) for pair in ((32, 64), (64, 16))]
    net = network([dense_layer(weight) for weight in weights], "fp32")
    assert net.mode(device, 100) is None
    assert net.mode(device, 32_768) in ("tpu-unified", "tpu-partitioned")
    for mode, expected in (("gpu", None), ("tpu-unified",) * 2, ("tpu-partitioned",) * 2):
        assert net.mode(replace(device, mode=mode), 32_768) == expected


@pytest.mark.slow
def test_both_modes_give_the_same_bits(device: Device) -> None:
    rng = np.random.default_rng(2)
    weights = [rng.standard_normal(pair).astype(np.float32) for pair in ((12, 24), (24, 5))]
    net = network([dense_layer(weight, relu=True) for weight in weights], "fp32")
    blocks = rng.standard_normal((20, 12, 16)).astype(np.float32)
    on_tiles = net.run(device, "network", blocks)
    joined = run_systolic(device, "network", net.layers, blocks, "tpu-unified")
    np.testing.assert_array_equal(on_tiles, joined)
