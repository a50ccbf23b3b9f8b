"""KiloNeRF: kernels as numba runs them, and whole crops on the array."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vividc.errors import ArgumentError
from vividc.render import SceneError, psnr, read_scene, read_views, render_reference, scaled_camera
from vividc.render.array import ArrayOptions, render_array
from vividc.render.array.kilonerf import _CHUNK, _by_coordinate, _pieces
from vividc.render.array.programs import _module, kernel_folder
from vividc.render.radiance import KiloNeRF
from vividc.render.radiance.kilonerf import positional_encoding

MIC = Path(__file__).parents[3] / "scenes" / "mic"
KERNELS = _module(kernel_folder() / "render" / "kilonerf.py")


@pytest.fixture(scope="module")
def model() -> KiloNeRF:
    return read_scene(MIC / "mic_kilonerf.npz")[1]


def test_samples_are_sorted_by_network() -> None:
    rng = np.random.default_rng(5)
    networks = rng.integers(-1, 7, 50).astype(np.int32)
    starts, cursors = np.zeros(9, np.int32), np.zeros(9, np.int32)
    order, places = np.zeros(50, np.int32), np.zeros(50, np.int32)
    KERNELS.sort_by_network(networks, 100, starts, cursors, order, places)
    np.testing.assert_array_equal(order, 100 + np.argsort(networks, kind="stable"))
    np.testing.assert_array_equal(order[places - 100], np.arange(100, 150))
    pieces = list(_pieces(starts[None, :]))
    assert sum(count for _, _, count in pieces) == (networks >= 0).sum()
    for network, first, count in pieces:
        assert (networks[order[first : first + count] - 100] == network).all()


def test_pieces_of_several_chunks() -> None:
    starts = np.array([[0, 0, _CHUNK], [0, 3, 3]], np.int32)  # one network
    assert list(_pieces(starts)) == [(0, 0, _CHUNK)]
    assert list(_pieces(np.array([[0, 2, 2, 5]], np.int32))) == [(1, 2, 3)]


@pytest.mark.parametrize(("name", "levels", "reach"), [("position", 10, 1), ("direction", 4, 1)])
def test_encodings_are_near_the_references(name: str, levels: int, reach: int) -> None:
    vectors = np.random.default_rng(6).uniform(-reach, reach, (200, 3)).astype(np.float32)
    out = np.zeros((600, 1 + 2 * levels), np.float32)
    getattr(KERNELS, f"encode_{name}")(vectors.ravel(), out)
    exact = positional_encoding(vectors, levels)
    terms = exact.shape[1]
    np.testing.assert_allclose(out.reshape(200, -1), exact[:, _by_coordinate(terms)], atol=2.0**-17)


def test_a_hidden_width_that_is_no_multiple_of_8_is_refused(model: KiloNeRF) -> None:
    odd = KiloNeRF(
        model.march,
        model.network,
        tuple(w[:, : min(w.shape[1], 30), : min(w.shape[2], 30)] for w in model.weights),
        model.biases,
        model.transmittance_min,
    )
    camera = scaled_camera(read_views(MIC / "ref_kilo.npz")[0].camera, 8, 8)
    with pytest.raises(SceneError, match="30 wide, which is no multiple of 8"):
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
