"""3DGS rendered whole by the array: against the reference, and scenes that are unusual."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import vividc
from vividc.render import Camera, Gaussians, SceneError, psnr, render_reference, scaled_camera
from vividc.render.array import (
    ArrayOptions,
    Device,
    RenderPrecision,
    render_array,
)
from vividc.render.array.splats.blend import EXP_EXCESS, Band, balanced
from vividc.render.array.splats.frame import render_splats


def gaussians(means: list[list[float]], **changes: object) -> Gaussians:
    n = len(means)
    parts: dict[str, object] = {
        "means": np.array(means, np.float32).reshape(n, 3),
        "scales": np.full((n, 3), 0.1, np.float32),
        "rotations": np.tile(np.array([1, 0, 0, 0], np.float32), (n, 1)),
        "opacity": np.full(n, 0.8, np.float32),
        "sh": np.ones((n, 1, 3), np.float32),
    }
    return Gaussians(**{**parts, **changes})  # type: ignore[arg-type]


def every_tenth(scene: Gaussians) -> Gaussians:
    columns = (scene.means, scene.scales, scene.rotations, scene.opacity, scene.sh)
    return Gaussians(*(column[::10] for column in columns))


def ahead(width: int = 40, height: int = 24) -> Camera:
    """Looks along -z from the origin."""
    return Camera(np.eye(4, dtype=np.float32), 40.0, width, height)


def test_no_gaussians_are_white() -> None:
    frame = render_splats(gaussians([]), ahead())
    np.testing.assert_array_equal(frame.image, np.ones((24, 40, 3)))
    assert (frame.cycles, frame.stages, frame.frames_a_second) == (0, (), 0.0)


@pytest.mark.parametrize("name", ["means", "scales", "rotations", "opacity", "sh"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_parameters_that_are_no_numbers_are_refused(name: str, value: float) -> None:
    scene = gaussians([[0, 0, -3], [0, 1, -3]])
    wrong = getattr(scene, name).copy()
    wrong[1] = value
    with pytest.raises(SceneError, match=f"`{name}` of Gaussian 1 is not finite"):
        render_array(replace(scene, **{name: wrong}), ahead())


def test_images_of_too_many_screen_tiles_are_refused() -> None:
    with pytest.raises(SceneError, match="256x1 screen tiles"):
        render_splats(gaussians([[0, 0, -3]]), ahead(4081, 16))


def test_scratchpads_smaller_than_the_launches_are_refused(tmp_path: Path) -> None:
    (tmp_path / "tile.yaml").write_text(
        "extends: vivid-tile\nscratchpad: {size_bytes: 16384, banks: 8}\n"
    )
    file = tmp_path / "small.yaml"
    file.write_text("extends: vivid\ntiles: {rows: 4, cols: 4, fabric: tile.yaml}\n")
    with pytest.raises(SceneError, match="scratchpads of 32768 bytes"):
        render_array(gaussians([[0, 0, -3]]), ahead(), ArrayOptions(fabric=str(file)))


@vividc.kernel("void(float32[::1], float32[::1])")
def exponentials(x: np.ndarray, y: np.ndarray) -> None:
    for i in range(len(x)):
        y[i] = math.exp(x[i])


@pytest.mark.parametrize("precision", [pytest.param("fp16", marks=pytest.mark.slow), "fp8"])
def test_exps_are_not_larger_than_lookahead_allows_for(precision: RenderPrecision) -> None:
    x = np.linspace(-5.6, 0, 4000, dtype=np.float32)  # from below ln(1 / 255)
    y = np.zeros_like(x)
    policy = {"exp": precision}
    program = vividc.compile(
        exponentials, loops=vividc.LoopOptions(auto=False), precision=policy, time_limit_s=20.0
    )
    vividc.simulate(program, x, y)
    seen = y >= np.float32(1 / 255)
    excess = np.log(y[seen].astype(np.float64)) - x[seen]
    assert 0.1 * EXP_EXCESS[precision] < excess.max() < EXP_EXCESS[precision]
    assert (np.diff(y) >= 0).all()


@pytest.mark.slow
@pytest.mark.parametrize("precision", ["fp16", "fp8"])
def test_lookahead_in_a_format_gives_the_same_picture(
    device: Device, mic: Gaussians, mic_cameras: tuple, precision: RenderPrecision
) -> None:
    view = mic_cameras[0]
    camera, mic = Camera(view.c2w, 80.0, 75, 50), every_tenth(mic)
    late, early = (
        render_splats(mic, camera, ArrayOptions(lookahead=on, precision=precision), device=device)
        for on in (False, True)
    )
    np.testing.assert_array_equal(early.image, late.image)
    assert early.counts["exponentials"] < late.counts["exponentials"] / 2
    single = render_splats(mic, camera, device=device)
    assert 40 < psnr(early.image, single.image) < 120
    blocks = render_splats(
        mic, camera, ArrayOptions(precision=precision), device=device, culling="blocks"
    )
    np.testing.assert_array_equal(blocks.image, late.image)


@pytest.mark.slow
def test_what_is_behind_the_camera_leaves_white(device: Device) -> None:
    frame = render_splats(gaussians([[0, 0, 3], [0, 0, -0.1]]), ahead(), device=device)
    np.testing.assert_array_equal(frame.image, np.ones((24, 40, 3)))
    assert [stage.name for stage in frame.stages] == ["projection"]


@pytest.mark.slow
@pytest.mark.parametrize("scale", [0.0, 1e-20, 0.3, 40.0, 1e18])
def test_one_gaussian_of_any_size(device: Device, scale: float) -> None:
    scene = gaussians([[0.1, 0.05, -3]], scales=np.full((1, 3), scale, np.float32))
    frame = render_splats(scene, ahead(), device=device)
    reference = render_reference(scene, ahead()).image
    np.testing.assert_allclose(frame.image, reference, atol=1e-5)


@pytest.mark.slow
def test_flat_transparent_and_coinciding_gaussians(device: Device) -> None:
    scales = np.full((303, 3), 0.1, np.float32)
    scales[300], scales[301] = (1e-30, 0.2, 0.2), (1e-30, 1e-30, 3.0)
    opacity = np.full(303, 0.02, np.float32)
    opacity[302] = 1e-38
    means = [[0, 0, -3]] * 300 + [[0.3, 0, -3], [-0.3, 0.1, -3], [1e30, 0, -3]]
    scene = gaussians(means, scales=scales, opacity=opacity)
    frame = render_splats(scene, ahead(), device=device)
    np.testing.assert_allclose(frame.image, render_reference(scene, ahead()).image, atol=1e-5)


@pytest.mark.slow
def test_lookahead_gives_the_same_picture_with_fewer_exps(
    device: Device, mic: Gaussians, mic_cameras: tuple
) -> None:
    view = mic_cameras[0]
    camera, mic = Camera(view.c2w, 80.0, 75, 50), every_tenth(mic)
    reference = render_reference(mic, camera).image
    late, early = (
        render_splats(mic, camera, ArrayOptions(lookahead=on), device=device)
        for on in (False, True)
    )
    np.testing.assert_array_equal(early.image, late.image)
    assert early.counts["exponentials"] < late.counts["exponentials"] / 2
    assert psnr(early.image, reference) > 80
    names = ["projection", "colour", "sorting", "binning", "blend"]
    assert [stage.name for stage in early.stages] == names
    blocks = render_splats(mic, camera, device=device, culling="blocks")
    np.testing.assert_array_equal(blocks.image, late.image)


def test_rows_of_a_screen_tile_with_nearly_all_splats_are_shared_out() -> None:
    """Tiles with few splats stay whole; four rows of blocks of one list go to four tiles."""
    long = Band(0, 0, 14, 4, 0, 400)
    short = [Band(16 * number, 0, 14, 4, 400, 402) for number in (1, 2, 3)]
    shares = [share for share in balanced([long, *short], 16) if share]
    assert sorted((share[0] for share in shares), key=lambda band: (band.x, band.y)) == [
        *(Band(0, y, height, 1, 0, 400) for y, height in ((0, 4), (4, 4), (8, 4), (12, 2))),
        *short,
    ]
    assert all(len(share) == 1 for share in shares)


@pytest.mark.slow
def test_a_screen_tile_with_nearly_all_splats_is_shared_out(device: Device) -> None:
    """Of one list of 400 splats four tiles blend a row of blocks each."""
    places = np.random.default_rng(5).uniform(-0.15, 0.15, (400, 2))
    means = np.column_stack((places, np.linspace(-3, -1, 400))).tolist()
    scene = gaussians(means, scales=np.full((400, 3), 0.02, np.float32))
    camera = ahead(16, 14)
    frame = render_splats(scene, camera, device=device)
    assert len(frame.stages[-1].stats[0]["tiles"]) == 4
    reference = render_reference(scene, camera)
    assert psnr(frame.image, reference.image) > 80


@pytest.mark.slow
def test_margins_and_samples(device: Device, mic: Gaussians, mic_cameras: tuple) -> None:
    camera, mic = scaled_camera(mic_cameras[1], 64, 64), every_tenth(mic)
    whole = render_splats(mic, camera, device=device)
    wide = render_splats(mic, camera, ArrayOptions(exponent_margin=1.0), device=device)
    np.testing.assert_array_equal(wide.image, whole.image)
    assert wide.counts["exponentials"] > whole.counts["exponentials"]
    narrow = render_splats(mic, camera, ArrayOptions(exponent_margin=-1.0), device=device)
    assert narrow.counts["exponentials"] < whole.counts["exponentials"]
    assert 20 < psnr(narrow.image, whole.image) < 80
    some = render_splats(mic, camera, ArrayOptions(sample=0.3), device=device)
    assert some.simulated is not None
    np.testing.assert_array_equal(some.image[some.simulated], whole.image[some.simulated])
    np.testing.assert_array_equal(some.image[~some.simulated], 1)
    assert 0 < some.sampled < 0.5


@pytest.mark.slow
@pytest.mark.parametrize("degree", [0, 1, 2])
def test_lower_degrees_of_colour(
    device: Device, mic: Gaussians, mic_cameras: tuple, degree: int
) -> None:
    camera, mic = scaled_camera(mic_cameras[1], 48, 48), every_tenth(mic)
    fewer = mic.sh[:, : (degree + 1) ** 2].copy()
    scene = Gaussians(mic.means, mic.scales, mic.rotations, mic.opacity, fewer)
    frame = render_splats(scene, camera, device=device)
    assert psnr(frame.image, render_reference(scene, camera).image) > 80
