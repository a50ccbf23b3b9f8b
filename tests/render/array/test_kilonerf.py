"""KiloNeRF: kernels as numba runs them, and whole crops on the array."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.render.array.by_numba import Host, samples_of
from vividc.errors import ArgumentError
from vividc.render import SceneError, psnr, read_scene, read_views, render_reference, scaled_camera
from vividc.render.array import ArrayOptions, RenderPrecision, open_device, render_array
from vividc.render.array.device.programs import kernel_folder, kernel_module
from vividc.render.array.march.light import light_along, picture_of
from vividc.render.array.models.grouping import Grouping, parts_of, runs_of
from vividc.render.array.models.kilonerf import KiloNeRFField
from vividc.render.array.models.kilonerf_fp32 import by_coordinate
from vividc.render.array.pieces import RAYS, Piece, Rays, Survivors, survivors_of
from vividc.render.array.records import Kept, Listed
from vividc.render.radiance import KiloNeRF
from vividc.render.radiance.kilonerf import positional_encoding
from vividc.render.radiance.layers import linear

MIC = Path(__file__).parents[3] / "scenes" / "mic"
KERNELS = kernel_module(kernel_folder() / "render" / "kilonerf.py")


@pytest.fixture(scope="module")
def model() -> KiloNeRF:
    return read_scene(MIC / "mic_kilonerf.npz")[1]


GRID = np.array([2, 3, 4], np.int32)
BOX = np.array([-1, -1, -1, *GRID / 2], np.float32)
"""Lowest corner, and cells a unit."""
GEOMETRY = np.array([0, 0, 0, *[0] * 11, 0.25, 4], np.float32)
"""Rays begin in the middle of the box, and have steps of 1/4."""


class _Group:
    """A piece of 50 samples that kernels sort, on as many rays of 64 in random directions."""

    def __init__(self, known: bool) -> None:
        rng = np.random.default_rng(5)
        directions = rng.standard_normal((64, 3))
        self.directions = (directions / np.linalg.norm(directions, axis=1)[:, None]).astype("f4")
        self.entries = rng.uniform(0, 0.4, 64).astype(np.float32)
        rays, steps = rng.permutation(64)[:50].astype(np.int32), rng.integers(0, 2, 50)
        self.items = (rays << 16 | steps).astype(np.int32)
        t = self.entries[rays] + (steps + 0.5) / 4
        self.points = self.directions[rays] * t[:, None]
        table = rng.integers(-1, 7, 24).astype(np.int32)
        self.cells = np.floor((self.points + 1) / 2 * GRID).astype(np.int32)
        self.networks = table[np.ravel_multi_index(tuple(self.cells.T), tuple(GRID))]
        self.known, self.table = int(known), np.zeros(1, np.int32) if known else table
        self.places, self.local = np.zeros(50, np.int32), np.zeros((50, 3), np.float32)
        self.order = np.argsort(self.networks, kind="stable")

    def sort(self, low: int, count: int) -> np.ndarray:
        starts, chosen = np.zeros(count + 2, np.int32), np.zeros(50, np.int32)
        KERNELS.group_samples(
            *(self.directions, self.entries, self.items, GEOMETRY, BOX, GRID, self.table),
            *(self.known, low, self.networks.copy() if self.known else chosen),
            *(starts, self.places, self.local),
        )
        return starts

    def runs(self, low: int, count: int) -> list[tuple[int, int, int]]:
        return list(runs_of(self.sort(low, count)[None, :], [0], low))


@pytest.mark.parametrize("known", [False, True])
def test_samples_are_sorted_by_network(known: bool) -> None:
    group = _Group(known)
    runs = group.runs(-1, 8)
    np.testing.assert_array_equal(group.places[group.order], np.arange(50))
    local = (group.points + 1) * GRID - 2 * group.cells - 1
    np.testing.assert_allclose(group.local, local[group.order], atol=1e-5)
    assert sum(count for _, _, count in runs) == (group.networks >= 0).sum()
    for network, first, count in runs:
        assert (group.networks[group.order[first : first + count]] == network).all()


def test_networks_are_sorted_a_range_after_the_other() -> None:
    group = _Group(known=False)
    runs = [one for given in ((-1, 3), (2, 4), (6, 1)) for one in group.runs(*given)]
    np.testing.assert_array_equal(group.places[group.order], np.arange(50))
    assert {network for network, _, _ in runs} == set(group.networks[group.networks >= 0])
    assert sum(count for _, _, count in runs) == (group.networks >= 0).sum()


@pytest.mark.parametrize("count", [0, 1, 20, 50])
def test_survivors_keep_the_order_of_networks(count: int) -> None:
    group = _Group(known=False)
    starts = group.sort(-1, 8)
    chosen = np.sort(np.random.default_rng(count).choice(50, count, replace=False))
    items = (chosen.astype(np.uint32) << 22).view(np.int32) | group.items[chosen]
    kept_starts, places, rows, rays = (
        np.full(n, -1, np.int32) for n in (len(starts), count, count, count)
    )
    KERNELS.group_survivors(
        *(items, group.places, starts, 640, 1000, np.ones(51, np.int32)),
        *(kept_starts, places, rows, rays),
    )
    order = np.argsort(group.places[chosen])
    np.testing.assert_array_equal(places[order], np.arange(count))
    np.testing.assert_array_equal(rows, 1000 + group.places[chosen][order])
    np.testing.assert_array_equal(rays, 640 + (group.items[chosen][order] >> 16))
    for network, first, number in runs_of(kept_starts[None, :], [0], -1):
        assert (group.networks[chosen[order[first : first + number]]] == network).all()
    assert kept_starts[-1] == count


def test_runs_of_several_pieces() -> None:
    starts = np.array([[0, 0, 300, 300], [0, 3, 3, 3]], np.int32)  # one network
    assert list(runs_of(starts, [0, 300], -1)) == [(0, 0, 300)]
    assert list(runs_of(np.array([[0, 2, 2, 5, 9]], np.int32), [40], -1)) == [(1, 42, 3)]
    assert list(runs_of(np.array([[4, 6, 7]], np.int32), [0], 30)) == [(30, 4, 2)]


def test_a_scratchpad_counts_all_networks_or_ranges_of_them(model: KiloNeRF) -> None:
    """Of 274 and of 3,288 networks; pieces have room for what each launch holds."""
    few = Grouping(model, Host())
    assert [low for low, _ in few._ranges] == [-1]
    many = replace(model, weights=tuple(np.repeat(w, 12, axis=0) for w in model.weights))
    grouping = Grouping(many, Host())
    assert grouping.most_samples < few.most_samples
    assert len(grouping._ranges) > 1
    assert sum(count for _, count in grouping._ranges) == 12 * len(model.weights[0]) + 1


def test_samples_of_several_chunks_share_a_launch() -> None:
    parts = list(parts_of([(3, 0, 5), (1, 5, 2), (3, 20, 9)], 8))
    assert [(part.network, part.count) for part in parts] == [(1, 2), (3, 8), (3, 6)]
    assert parts[1].places == (slice(0, 5), slice(20, 23))
    table = np.arange(60, dtype=np.float32).reshape(30, 2)
    assert [move.first for move in parts[1].moves(table, 7)] == [7, 17]
    assert [len(move.array) for move in parts[1].moves(table)] == [5, 3]


def _one_a_ray(points: np.ndarray) -> tuple[Rays, list[Piece]]:
    """Rays from the middle of the world, blocks of 64 each of which meets one point."""
    count = len(points)
    distance = np.linalg.norm(points, axis=1)
    directions = np.zeros((-(-count // RAYS) * RAYS, 3), np.float32)
    entries = np.zeros(len(directions), np.float32)
    directions[:count] = points / distance[:, None]
    entries[:count] = distance - 0.5
    rays = Rays(directions, entries, np.zeros(len(directions), np.uint32))
    items = np.arange(count, dtype=np.int32) % RAYS << 16
    firsts = range(0, count, RAYS)
    return rays, [
        Piece(number, first, 0, True, first, items[first : first + RAYS])
        for number, first in enumerate(firsts)
    ]


def _survivors(pieces: list[Piece], chosen: np.ndarray) -> list[Survivors]:
    """Those samples of pieces that are chosen, in rising order."""
    numbers = [chosen[(chosen >= p.first) & (chosen < p.first + RAYS)] for p in pieces]
    within = [n.astype(np.uint32) - p.first for p, n in zip(pieces, numbers, strict=True)]
    items = [p.items[w] | (w << 22).view(np.int32) for p, w in zip(pieces, within, strict=True)]
    counts = [len(some) for some in items]
    every = np.concatenate([np.pad(some, (0, RAYS - len(some))) for some in items])
    words = [count << 20 for count in counts]
    return list(survivors_of(pieces, words, every, np.ones(len(every), np.float32)))


@pytest.mark.slow  # numba takes its time for the networks
@pytest.mark.parametrize("precision", ["fp32", "fp8"])
def test_fields_are_near_the_reference(model: KiloNeRF, precision: RenderPrecision) -> None:
    points, _ = samples_of(model.march, 500)
    rays, pieces = _one_a_ray(points)
    geometry = np.zeros(16, np.float32)
    geometry[14] = 1
    host = Host()
    field = KiloNeRFField(model, host, precision)
    found = field.densities(Listed(host, geometry, rays, pieces))
    limits, left = np.array([0, -1], np.float32), np.ones_like(rays.entries)
    listed = light_along(host, pieces, found, limits, left, keep_all=True)
    alpha = np.concatenate([piece.weights for piece in listed])
    thickness, exact_features = model.density(points, linear)
    seen = rays.directions[: len(points)]
    truth = model.colour(points, exact_features, seen, linear)
    bound = 1e-4 if precision == "fp32" else 0.3
    assert np.abs(1 - alpha - np.exp(-thickness)).mean() < bound / 4
    colours = []
    for chosen in (np.arange(500), np.sort(np.random.default_rng(9).choice(500, 100, False))):
        some = _survivors(pieces, chosen)
        rgb = field.colours(Kept(host, geometry, rays, some))
        colours.append(picture_of(host, some, rgb, np.zeros_like(left))[chosen, :3])
        assert np.abs(colours[-1] - truth[chosen]).mean() < bound / 4
        assert np.abs(colours[-1] - truth[chosen]).max() < bound
        np.testing.assert_array_equal(colours[-1], colours[0][chosen])


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
    networks = Grouping(large, open_device("vivid"))._numbers(points)
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
