"""The trained models of `scenes/mic`: against the renders that came with them, and lookahead."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from vividc.render import load_cameras, load_reference_images, over_background, psnr, read_scene
from vividc.render.radiance import RadianceField, linear, pixel_rays, render_field, render_rays

MIC = Path(__file__).parents[3] / "scenes" / "mic"
MODELS = {
    "mic_kilonerf.npz": "ref_kilo.npz",
    "mic_ngp_hash.npz": "ref_ngp.npz",
    "mic_tensorf_vm.npz": "ref_tf.npz",
}
FIRST_ROW, ROWS, SIDE = 30, 8, 200
"""Rows through the head of the microphone in the first view."""


@cache
def model(name: str) -> RadianceField:
    return read_scene(MIC / name)[1]


def band(name: str, **switches):
    camera = load_cameras(MIC / MODELS[name])[0]
    directions = pixel_rays(camera, FIRST_ROW * SIDE, ROWS * SIDE)
    return render_rays(model(name), camera.position, directions, **switches)


@pytest.mark.parametrize("name", MODELS)
def test_equals_the_render_that_came_with_the_model(name: str) -> None:
    """An independent float64 renderer made them; a sample more or less at a face is 1e-3."""
    expected = load_reference_images(MIC / MODELS[name])[0][FIRST_ROW : FIRST_ROW + ROWS]
    rgbt, counts = band(name)
    image = over_background(rgbt).reshape(ROWS, SIDE, 3)
    assert psnr(image, expected) > 100
    np.testing.assert_allclose(image, expected, atol=1e-3)
    assert counts.density_samples > 5000
    assert (rgbt[:, 3] < 1e-3).sum() > 50


@pytest.mark.parametrize("name", MODELS)
def test_lookahead_culling_1_keeps_every_bit(name: str) -> None:
    early, few = band(name, lookahead=True)
    late, all_of_them = band(name, lookahead=False)
    np.testing.assert_array_equal(early, late)
    assert few.colour_samples == few.counted_samples == all_of_them.counted_samples
    assert all_of_them.colour_samples == all_of_them.density_samples == few.density_samples
    assert few.colour_samples < few.density_samples
    assert 0 < few.avoided_colour_share < 1
    assert all_of_them.avoided_colour_share == 0


@pytest.mark.parametrize("name", MODELS)
def test_another_layer_can_stand_in(name: str) -> None:
    """Every linear layer goes through the given one, and is called by its name."""
    seen: set[str] = set()

    def spying(layer, inputs, weights, bias):
        seen.add(layer)
        return linear(layer, inputs, weights, bias)

    np.testing.assert_array_equal(band(name, layer=spying)[0], band(name)[0])
    assert (
        seen
        == {
            "mic_kilonerf.npz": {"w1", "w2", "w3", "w4", "w5"},
            "mic_ngp_hash.npz": {"sigma0", "sigma1", "rgb0", "rgb1", "rgb2"},
            "mic_tensorf_vm.npz": {"basis", "mlp0", "mlp1", "mlp2"},
        }[name]
    )


def test_an_image_is_its_rays_row_by_row() -> None:
    camera = load_cameras(MIC / "ref_kilo.npz")[0]
    small = type(camera)(camera.c2w, camera.focal / 10, 20, 16)
    shares: list[float] = []
    rgbt, counts = render_field(model("mic_kilonerf.npz"), small, progress=shares.append)
    rays, _ = render_rays(model("mic_kilonerf.npz"), small.position, pixel_rays(small, 0, 320))
    np.testing.assert_array_equal(rgbt.reshape(-1, 4), rays)
    assert counts.rays == 320
    assert shares == [1.0]


@pytest.mark.parametrize("name", MODELS)
def test_a_camera_that_looks_away_sees_white(name: str) -> None:
    camera = load_cameras(MIC / MODELS[name])[0]
    away = camera.c2w.copy()
    away[:3, :3] *= np.array([-1, 1, -1], dtype=np.float32)
    turned = type(camera)(away, camera.focal / 50, 4, 4)
    rgbt, counts = render_field(model(name), turned)
    np.testing.assert_array_equal(over_background(rgbt), np.ones((4, 4, 3)))
    assert (counts.density_samples, counts.avoided_colour_share) == (0, 0.0)
