"""Blending by the array: every block of pixels gets its list and its place in the picture."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import vividc
from benchmarks.workloads import Workload
from tests.render.sum_blend import sum_blend
from vividc.errors import ArgumentError
from vividc.render import (
    Camera,
    Crop,
    Gaussians,
    SceneError,
    TileLists,
    assemble,
    blend_image,
    blend_on_array,
    cut_small_launches,
    over_background,
    psnr,
    render_reference,
    scaled_camera,
    tile_lists,
)


@cache
def program(fabric: str = "vivid-tile") -> vividc.Program:
    return vividc.compile(sum_blend, fabric=fabric, time_limit_s=20)


def on_host(kernel: vividc.KernelFunction, lists: TileLists, words: int) -> np.ndarray:
    """Return the picture that numba gives, launch by launch; blocks without splats are white."""
    crop = Crop(0, 0, lists.width, lists.height)
    launches = cut_small_launches(lists, crop, words)
    outputs = []
    for launch in launches:
        arguments = launch.arguments()
        if len(launch.splats):
            kernel(*arguments.values())
        else:
            arguments["out"][3::4] = 1
        outputs.append(arguments["out"])
    return assemble(crop, launches, outputs)


def test_each_block_gets_its_list_and_its_place(mic: Gaussians, mic_cameras: tuple) -> None:
    camera = scaled_camera(mic_cameras[0], 100, 100)
    picture = blend_on_array(program(), mic, camera)
    expected = on_host(sum_blend, tile_lists(mic, camera), 4096)
    np.testing.assert_array_equal(picture.image, expected)
    assert picture.stats["runs"] == picture.launches
    assert picture.milliseconds == pytest.approx(picture.cycles / 1e6)


def test_long_lists_take_the_whole_scratchpad(mic: Gaussians, mic_cameras: tuple) -> None:
    camera = scaled_camera(mic_cameras[0], 60, 60)
    lists = tile_lists(mic, camera)
    with pytest.raises(SceneError, match="the 4096 words of the scratchpad"):
        cut_small_launches(lists, Crop(0, 0, 60, 60), 4096)
    picture = blend_on_array(program(), mic, camera)
    np.testing.assert_array_equal(picture.image, on_host(sum_blend, lists, 8192))


def test_lists_that_fit_no_scratchpad_are_refused(mic: Gaussians, mic_cameras: tuple) -> None:
    with pytest.raises(SceneError, match="the 8192 words of the scratchpad"):
        blend_on_array(program(), mic, scaled_camera(mic_cameras[0], 20, 20))


def test_small_launches_cover_the_picture_and_keep_it(mic_tiles: TileLists) -> None:
    crop = Crop(70, 10, 50, 40)
    launches = cut_small_launches(mic_tiles, crop, 4096)
    assert max(launch.words for launch in launches) <= 4096
    assert max(launch.block.width for launch in launches) == 8
    total = sum(len(launch.splats) * launch.block.pixels for launch in launches)
    lists = mic_tiles.lengths[0:4, 4:8].sum() * 256
    assert total < lists / 3
    some = launches[:: len(launches) // 8]
    whole = over_background(blend_image(mic_tiles, crop).rgbt)
    for launch in some:
        place = launch.block.rows_and_columns_in(crop)
        alone = blend_image(mic_tiles, launch.block)
        np.testing.assert_array_equal(over_background(alone.rgbt), whole[place])


def test_a_scene_out_of_sight_is_white(mic: Gaussians, mic_cameras: tuple) -> None:
    pose = mic_cameras[0].c2w.copy()
    pose[:3, :3] *= np.array([-1, 1, -1], dtype=np.float32)
    picture = blend_on_array(program(), mic, Camera(pose, 20, 16, 16))
    np.testing.assert_array_equal(picture.image, np.ones((16, 16, 3)))
    assert (picture.launches, picture.cycles) == (0, 0)


def test_other_programs_are_refused(mic: Gaussians, mic_cameras: tuple) -> None:
    @vividc.kernel("void(float32[::1], int32)")
    def zero(x, n):
        for i in range(n):
            x[i] = np.float32(0)

    small = scaled_camera(mic_cameras[0], 100, 100)
    other = vividc.compile(zero, fabric="vivid-tile", time_limit_s=10)
    with pytest.raises(SceneError, match="`zero` is not a blending kernel: its parameters are x"):
        blend_on_array(other, mic, small)
    with pytest.raises(ArgumentError):
        blend_on_array(program("vivid-tile-unit"), mic, small)


@pytest.mark.slow
def test_gs_blend_on_the_array_gives_the_reference(mic: Gaussians, mic_cameras: tuple) -> None:
    """The whole picture; exp and fused multiply-adds round differently from numpy's."""
    blend = Workload("gs_blend", lambda _: ()).kernel()
    compiled = vividc.compile(blend, fabric="vivid-tile", time_limit_s=120)
    picture = blend_on_array(compiled, mic, mic_cameras[0])
    reference = render_reference(mic, mic_cameras[0])
    assert psnr(picture.image, reference.image) > 120
