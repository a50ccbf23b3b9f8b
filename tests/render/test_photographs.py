"""Held-out photographs of mic, where the checkout has them beside it (`../shared/scenes/mic`)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vividc.render import (
    Crop,
    Gaussians,
    blend_image,
    over_background,
    psnr,
    read_scene,
    read_views,
    tile_lists,
)
from vividc.render.radiance import pixel_rays, render_rays

ROOT = Path(__file__).parents[2]
PHOTOGRAPHS = ROOT.parent / "shared" / "scenes" / "mic" / "mic_200.npz"
SCENES = ("mic_3dgs_sh3.ply", "mic_kilonerf.npz", "mic_ngp_hash.npz", "mic_tensorf_vm.npz")
FIRST_ROW, ROWS, SIDE = 96, 8, 200
HELD_OUT = 13
"""A view that none of the reference renders is of."""


@pytest.mark.skipif(not PHOTOGRAPHS.exists(), reason=f"needs ../shared: {PHOTOGRAPHS.name}")
@pytest.mark.parametrize("name", SCENES)
def test_a_band_of_a_held_out_photograph(name: str) -> None:
    view = read_views(PHOTOGRAPHS)[HELD_OUT]
    scene = read_scene(ROOT / "scenes" / "mic" / name)[1]
    if isinstance(scene, Gaussians):
        band = Crop(0, FIRST_ROW, SIDE, ROWS)
        rgbt = blend_image(tile_lists(scene, view.camera), band).rgbt
    else:
        directions = pixel_rays(view.camera, FIRST_ROW * SIDE, ROWS * SIDE)
        rgbt, _ = render_rays(scene, view.camera.position, directions)
    image = over_background(rgbt.reshape(ROWS, SIDE, 4))
    truth = view.truth()
    assert truth is not None
    assert psnr(np.clip(image, 0, 1), truth[FIRST_ROW : FIRST_ROW + ROWS]) > 28
