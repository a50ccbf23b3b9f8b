"""KiloNeRF: kernels as numba runs them, and whole crops on the array."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.render.array.by_numba import Host, launches_by_numba, samples_of
from vividc.errors import ArgumentError
from vividc.render import SceneError, psnr, read_scene, read_views, render_reference, scaled_camera
from vividc.render.array import ArrayOptions, Ledger, open_device, render_array
from vividc.render.array.device.programs import kernel_folder, kernel_module
from vividc.render.array.models import kilonerf
from vividc.render.array.models.kilonerf import (
    CHUNK,
    KiloNeRFOnArray,
    by_coordinate,
    parts_of,
    pieces_of,
)
from vividc.render.array.models.kilonerf_fp8 import Fp8KiloNeRF
from vividc.render.radiance import KiloNeRF
from vividc.render.radiance.kilonerf import positional_encoding
from vividc.render.radiance.layers import linear

MIC = Path(__file__).parents[3] / "scenes" / "mic"
KERNELS = kernel_module(kernel_folder() / "render" / "kilonerf.py")


@pytest.fixture(scope="module")
def model() -> KiloNeRF:
    return read_scene(MIC / "mic_kilonerf.npz")[1]


GRID = np.array([2, 3, 4], np.int32)
BOX = np.array([-1, -1, -1, 2, 2, 2], np.float32)


class _Group:
    """A chunk of 50 points that kernels sort, the first of them number 100."""

    def __init__(self, known: bool) -> None:
        rng = np.random.default_rng(5)
        self.points = rng.uniform(-1, 1, (50, 3)).astype(np.float32)
        table = rng.integers(-1, 7, 24).astype(np.int32)
        self.cells = np.floor((self.points + 1) / 2 * GRID).astype(np.int32)
        self.networks = table[np.ravel_multi_index(tuple(self.cells.T), tuple(GRID))]
        self.chosen = self.networks.copy() if known else np.zeros(50, np.int32)
        self.known, self.table = int(known), np.zeros(1, np.int32) if known else table
        self.places, self.local = np.zeros(50, np.int32), np.zeros((50, 3), np.float32)
        self.rows, self.rays = np.zeros((2, 50), np.int32)
        self.order = np.argsort(self.networks, kind="stable")

    def sort(self, low: int, count: int, numbers: bool = False) -> list[tuple[int, int, int]]:
        starts, cursors = np.zeros((2, count + 2), np.int32)
        given = (BOX, GRID, self.table, self.known, low, 100, self.chosen, starts, cursors)
        if numbers:
            one, two = np.arange(50, dtype=np.int32), np.arange(200, 250, dtype=np.int32)
            arrays = (self.places, one, two, self.rows, self.rays)
            KERNELS.group_numbers(self.points, *given, *arrays)
        else:
            KERNELS.group_places(self.points, *given, self.places, self.local)
        return list(pieces_of(starts[None, :], low))


@pytest.mark.parametrize("known", [False, True])
def test_samples_are_sorted_by_network(known: bool) -> None:
    group = _Group(known)
    pieces = group.sort(-1, 8)
    np.testing.assert_array_equal(group.places[group.order], np.arange(100, 150))
    local = (group.points + 1) * GRID - 2 * group.cells - 1
    np.testing.assert_allclose(group.local, local[group.order], atol=1e-5)
    assert sum(count for _, _, count in pieces) == (group.networks >= 0).sum()
    for network, first, count in pieces:
        assert (group.networks[group.order[first : first + count]] == network).all()
    assert group.sort(-1, 8, numbers=True) == pieces
    np.testing.assert_array_equal(group.places[group.order], np.arange(100, 150))
    np.testing.assert_array_equal(group.rows, group.order)
    np.testing.assert_array_equal(group.rays, 200 + group.order)
    out = np.zeros((50, 3), np.float32)
    KERNELS.ungroup(group.local, group.places, 100, out)
    np.testing.assert_allclose(out, local, atol=1e-5)


def test_networks_are_sorted_a_range_after_the_other() -> None:
    group = _Group(known=False)
    pieces = [one for given in ((-1, 3), (2, 4), (6, 1)) for one in group.sort(*given)]
    np.testing.assert_array_equal(group.places[group.order], np.arange(100, 150))
    assert {network for network, _, _ in pieces} == set(group.networks[group.networks >= 0])
    assert sum(count for _, _, count in pieces) == (group.networks >= 0).sum()


def test_pieces_of_several_chunks() -> None:
    starts = np.array([[0, 0, CHUNK, CHUNK], [0, 3, 3, 3]], np.int32)  # one network
    assert list(pieces_of(starts, -1)) == [(0, 0, CHUNK)]
    assert list(pieces_of(np.array([[0, 2, 2, 5, 9]], np.int32), -1)) == [(1, 2, 3)]
    assert list(pieces_of(np.array([[4, 6, 7]], np.int32), 30)) == [(30, 4, 2)]


def test_samples_of_several_chunks_share_a_launch() -> None:
    parts = list(parts_of([(3, 0, 5), (1, 5, 2), (3, 20, 9)], 8))
    assert [(part.network, part.count) for part in parts] == [(1, 2), (3, 8), (3, 6)]
    assert parts[1].places == (slice(0, 5), slice(20, 23))
    table = np.arange(60, dtype=np.float32).reshape(30, 2)
    assert [move.first for move in parts[1].moves(table, 7)] == [7, 17]
    assert [len(move.array) for move in parts[1].moves(table)] == [5, 3]


@pytest.mark.slow  # numba takes its time for the networks
@pytest.mark.parametrize("make", [KiloNeRFOnArray, Fp8KiloNeRF])
def test_fields_are_near_the_reference(
    model: KiloNeRF, make: type[KiloNeRFOnArray], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kilonerf, "run_launches", launches_by_numba)
    points, directions = samples_of(model.march, 500)
    rays = np.arange(500, dtype=np.int32)[::-1].copy()
    field = make(model, Host())  # type: ignore[arg-type]
    thickness, features = field.density(points, Ledger())
    colour = field.colour(points, features, rays, directions, Ledger())
    exact, exact_features = model.density(points, linear)
    truth = model.colour(points, exact_features, directions[rays], linear)
    bound = 1e-4 if make is KiloNeRFOnArray else 0.3
    assert np.abs(np.exp(-thickness) - np.exp(-exact)).mean() < bound / 4
    assert np.abs(colour - truth).mean() < bound / 4
    assert np.abs(colour - truth).max() < bound
    some = np.sort(np.random.default_rng(9).choice(500, 100, replace=False))
    part = field.colour(points[some], features[some], rays[some], directions, Ledger())
    np.testing.assert_array_equal(part, colour[some])


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
    networks = KiloNeRFOnArray(large, open_device("vivid"))._numbers(points, Ledger())
    np.testing.assert_array_equal(networks, large.cells_of(points)[0])


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
