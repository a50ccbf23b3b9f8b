"""KiloNeRF: kernels as numba runs them, and whole crops on the array."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from vividc.errors import ArgumentError
from vividc.render import SceneError, psnr, read_scene, read_views, render_reference, scaled_camera
from vividc.render.array import ArrayOptions, Ledger, open_device, render_array
from vividc.render.array.device.programs import kernel_folder, kernel_module
from vividc.render.array.models.kilonerf import CHUNK, KiloNeRFOnArray, by_coordinate, pieces_of
from vividc.render.radiance import KiloNeRF
from vividc.render.radiance.kilonerf import positional_encoding

MIC = Path(__file__).parents[3] / "scenes" / "mic"
KERNELS = kernel_module(kernel_folder() / "render" / "kilonerf.py")


@pytest.fixture(scope="module")
def model() -> KiloNeRF:
    return read_scene(MIC / "mic_kilonerf.npz")[1]


def test_samples_are_sorted_by_network() -> None:
    rng = np.random.default_rng(5)
    networks = rng.integers(-1, 7, 50).astype(np.int32)
    starts, cursors = np.zeros(10, np.int32), np.zeros(10, np.int32)
    order, places = np.zeros(50, np.int32), np.zeros(50, np.int32)
    KERNELS.sort_by_network(networks, -1, 100, starts, cursors, order, places)
    np.testing.assert_array_equal(order, 100 + np.argsort(networks, kind="stable"))
    np.testing.assert_array_equal(order[places - 100], np.arange(100, 150))
    pieces = list(pieces_of(starts[None, :], -1))
    assert sum(count for _, _, count in pieces) == (networks >= 0).sum()
    for network, first, count in pieces:
        assert (networks[order[first : first + count] - 100] == network).all()


def test_pieces_of_several_chunks() -> None:
    starts = np.array([[0, 0, CHUNK, CHUNK], [0, 3, 3, 3]], np.int32)  # one network
    assert list(pieces_of(starts, -1)) == [(0, 0, CHUNK)]
    assert list(pieces_of(np.array([[0, 2, 2, 5, 9]], np.int32), -1)) == [(1, 2, 3)]
    assert list(pieces_of(np.array([[4, 6, 7]], np.int32), 30)) == [(30, 4, 2)]


def test_networks_are_sorted_a_range_after_the_other() -> None:
    networks = np.random.default_rng(5).integers(-1, 7, 50).astype(np.int32)
    order, places = np.zeros(50, np.int32), np.zeros(50, np.int32)
    pieces = []
    for low, count in ((-1, 3), (2, 4), (6, 1)):
        starts, cursors = np.zeros(count + 2, np.int32), np.zeros(count + 2, np.int32)
        KERNELS.sort_by_network(networks, low, 100, starts, cursors, order, places)
        pieces += pieces_of(starts[None, :], low)
    np.testing.assert_array_equal(order, 100 + np.argsort(networks, kind="stable"))
    np.testing.assert_array_equal(order[places - 100], np.arange(100, 150))
    assert [network for network, _, _ in pieces] == list(range(7))
    assert sum(count for _, _, count in pieces) == (networks >= 0).sum()


@pytest.mark.slow
def test_more_networks_than_a_scratchpad_counts_give_the_same_picture(model: KiloNeRF) -> None:
    """Cells take turns with twelve copies of each network."""
    copies, networks = 12, len(model.weights[0])
    turns = np.arange(model.network.size).reshape(model.network.shape) % copies
    many = replace(
        model,
        network=np.where(model.network < 0, -1, model.network + networks * turns),
        weights=tuple(np.tile(array, (copies, 1, 1)) for array in model.weights),
        biases=tuple(np.tile(array, (copies, 1)) for array in model.biases),
    )
    camera = scaled_camera(read_views(MIC / "ref_kilo.npz")[0].camera, 32, 32)
    frames = [render_array(scene, camera, ArrayOptions()) for scene in (model, many)]
    np.testing.assert_array_equal(frames[0].image, frames[1].image)


@pytest.mark.slow
def test_a_grid_that_fits_no_scratchpad_finds_its_networks(model: KiloNeRF) -> None:
    grid = np.random.default_rng(1).integers(-1, 274, (24, 20, 22))
    large = replace(model, network=grid)
    box = model.march.box
    points = np.random.default_rng(3).uniform(box[0], box[1], (1500, 3)).astype(np.float32)
    networks, local = KiloNeRFOnArray(large, open_device("vivid")).cells_of(points, Ledger())
    expected, exact = large.cells_of(points)
    np.testing.assert_array_equal(networks, expected)
    np.testing.assert_allclose(local, exact, atol=2e-5)


@pytest.mark.parametrize(("name", "levels", "reach"), [("position", 10, 1), ("direction", 4, 1)])
def test_encodings_are_near_the_references(name: str, levels: int, reach: int) -> None:
    vectors = np.random.default_rng(6).uniform(-reach, reach, (200, 3)).astype(np.float32)
    out = np.zeros((600, 1 + 2 * levels), np.float32)
    getattr(KERNELS, f"encode_{name}")(vectors.ravel(), out)
    exact = positional_encoding(vectors, levels)
    terms = exact.shape[1]
    np.testing.assert_allclose(out.reshape(200, -1), exact[:, by_coordinate(terms)], atol=2.0**-17)


def test_a_hidden_width_that_is_no_multiple_of_8_is_refused(model: KiloNeRF) -> None:
    odd = KiloNeRF(
        model.march,
        model.network,
        tuple(w[:, : min(w.shape[1], 30), : min(w.shape[2], 30)] for w in model.weights),
        model.biases,
        model.transmittance_min,
    )
    camera = scaled_camera(read_views(MIC / "ref_kilo.npz")[0].camera, 8, 8)
    with pytest.raises(SceneError, match="30 wide, not a multiple of 8"):
        render_array(odd, camera)


@pytest.mark.parametrize("sample", [0.0, -1.0, 1.5, float("nan")])
def test_a_share_out_of_range_is_refused(model: KiloNeRF, sample: float) -> None:
    camera = scaled_camera(read_views(MIC / "ref_kilo.npz")[0].camera, 8, 8)
    with pytest.raises(SceneError, match="of the blocks cannot be simulated"):
        render_array(model, camera, ArrayOptions(sample=sample))
    with pytest.raises(ArgumentError, match="the share of blocks cannot be 'half'"):
        render_array(model, camera, ArrayOptions(sample="half"))  # type: ignore[arg-type]


@pytest.mark.slow
def test_a_picture_of_the_array_is_the_references(model: KiloNeRF) -> None:
    camera = scaled_camera(read_views(MIC / "ref_kilo.npz")[0].camera, 20, 20)
    shares: list[float] = []
    frame = render_array(model, camera, progress=shares.append)
    reference = render_reference(model, camera)
    assert psnr(frame.image, reference.image) > 80
    for name in ("rays", "density_samples", "colour_samples", "counted_samples"):
        assert frame.counts[name] == reference.counts[name]
    assert shares == [1.0]
    late = render_array(model, camera, ArrayOptions(lookahead=False))
    np.testing.assert_array_equal(frame.image, late.image)
    assert late.cycles > frame.cycles
    part = render_array(model, camera, ArrayOptions(sample=0.4))
    assert part.simulated is not None
    np.testing.assert_array_equal(part.image[part.simulated], frame.image[part.simulated])
    assert (part.image[~part.simulated] == 1).all()
