"""Cutting crops into kernel launches, and putting their outputs together."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vividc.render import (
    SPM_WORDS,
    BlendLaunch,
    Crop,
    SceneError,
    Splats,
    TileLists,
    assemble,
    blend_block,
    blend_image,
    cut_launches,
    over_background,
)
from vividc.render.arrays import frozen_float32

ARGUMENT_NAMES = (
    "mean_x", "mean_y", "conic_a", "conic_b", "conic_c", "opacity", "red", "green", "blue",
    "out", "x0", "y0", "width", "height", "n",
)  # fmt: skip


def tiles_with(lengths: np.ndarray, width: int, height: int) -> TileLists:
    """Return tile lists of the given lengths [tile rows, tile columns] with arbitrary splats."""
    total = int(lengths.sum())
    rng = np.random.default_rng(total)
    splats = Splats(*(frozen_float32(rng.uniform(0.1, 1, total)) for _ in range(9)))
    start = np.concatenate(([0], np.cumsum(lengths)))
    return TileLists(splats, width, height, np.arange(total), start)


def one_tile(length: int) -> TileLists:
    return tiles_with(np.array([[length]]), 16, 16)


def run(launch: BlendLaunch) -> np.ndarray:
    """Do what the kernel does, from its arguments alone."""
    arguments = launch.arguments()
    x0, y0, width, height, n = (int(arguments[k]) for k in ("x0", "y0", "width", "height", "n"))
    splats = Splats(*(arguments[name][:n] for name in ARGUMENT_NAMES[:9]))
    arguments["out"][:] = blend_block(splats, Crop(x0, y0, width, height)).rgbt.ravel()
    return arguments["out"]


def test_arguments_have_the_kernels_names_order_and_types() -> None:
    arguments = BlendLaunch(one_tile(5).tile(0, 0), Crop(3, 4, 2, 6)).arguments()
    assert tuple(arguments) == ARGUMENT_NAMES
    for name in ARGUMENT_NAMES[:9]:
        assert (arguments[name].dtype, arguments[name].shape) == (np.float32, (5,))
    assert (arguments["out"].dtype, arguments["out"].shape) == (np.float32, (4 * 2 * 6,))
    scalars = [arguments[name] for name in ARGUMENT_NAMES[10:]]
    assert scalars == [3, 4, 2, 6, 5]
    assert {type(scalar) for scalar in scalars} == {np.int32}


def test_an_empty_list_still_has_arrays() -> None:
    launch = BlendLaunch(one_tile(0).tile(0, 0), Crop(0, 0, 16, 16))
    arguments = launch.arguments()
    assert arguments["n"] == 0
    for name in ARGUMENT_NAMES[:9]:
        np.testing.assert_array_equal(arguments[name], np.zeros(1, dtype=np.float32))
    assert launch.words == 9 + 4 * 256


def test_arguments_are_fresh_and_writable() -> None:
    launch = BlendLaunch(one_tile(5).tile(0, 0), Crop(0, 0, 2, 2))
    first, second = launch.arguments(), launch.arguments()
    first["out"][:] = 7
    first["red"][:] = 7
    assert not (second["out"] == 7).any()
    assert not (second["red"] == 7).any()


@given(data=st.data())
@settings(max_examples=60)
def test_launches_cover_any_crop_exactly_once_and_fit(data: st.DataObject) -> None:
    width, height = data.draw(st.integers(1, 70)), data.draw(st.integers(1, 70))
    grid = (-(-height // 16), -(-width // 16))
    cells = grid[0] * grid[1]
    lengths = data.draw(st.lists(st.integers(0, 903), min_size=cells, max_size=cells))
    tiles = tiles_with(np.array(lengths).reshape(grid), width, height)
    x0, y0 = data.draw(st.integers(0, width - 1)), data.draw(st.integers(0, height - 1))
    crop = Crop(
        x0, y0, data.draw(st.integers(1, width - x0)), data.draw(st.integers(1, height - y0))
    )
    covered = np.zeros((height, width), dtype=int)
    for launch in cut_launches(tiles, crop):
        block = launch.block
        assert launch.words <= SPM_WORDS
        assert launch.words == sum(a.size for a in launch.arguments().values() if np.ndim(a))
        right, bottom = block.x0 + block.width - 1, block.y0 + block.height - 1
        assert (block.x0 // 16, block.y0 // 16) == (right // 16, bottom // 16)
        assert len(launch.splats) == tiles.lengths[block.y0 // 16, block.x0 // 16]
        covered[block.y0 : bottom + 1, block.x0 : right + 1] += 1
    expected = np.zeros_like(covered)
    expected[crop.y0 : crop.y0 + crop.height, crop.x0 : crop.x0 + crop.width] = 1
    np.testing.assert_array_equal(covered, expected)


@pytest.mark.parametrize(
    ("length", "heights"),
    [(796, [16]), (797, [8, 8]), (840, [8, 8]), (862, [5, 5, 6]), (903, [1] * 16)],
)
def test_blocks_shrink_as_the_list_grows(length: int, heights: list[int]) -> None:
    launches = cut_launches(one_tile(length), Crop(0, 0, 16, 16))
    assert [launch.block.height for launch in launches] == heights


def test_blocks_become_narrower_than_a_tile_where_no_row_fits() -> None:
    launches = cut_launches(one_tile(905), Crop(0, 0, 16, 16))
    assert {(launch.block.width, launch.block.height) for launch in launches} == {(8, 1)}
    assert sum(launch.block.pixels for launch in launches) == 256


def test_a_list_too_long_for_one_pixel_is_refused_with_sizes() -> None:
    with pytest.raises(SceneError, match="910 splats") as raised:
        cut_launches(one_tile(910), Crop(0, 0, 16, 16))
    assert "8190 words and 4 words for the pixel" in str(raised.value)
    assert "8192 words" in str(raised.value)


def test_the_scratchpad_may_have_another_size() -> None:
    assert len(cut_launches(one_tile(904), Crop(0, 0, 16, 16), spm_words=16384)) == 1


def test_mic_crop_is_reassembled_from_its_launches(mic_tiles: TileLists) -> None:
    crop = Crop(88, 148, 32, 32)
    launches = cut_launches(mic_tiles, crop)
    image = assemble(crop, launches, [run(launch) for launch in launches])
    np.testing.assert_array_equal(image, over_background(blend_image(mic_tiles, crop).rgbt))


def test_every_tile_of_mic_fits_the_scratchpad(mic_tiles: TileLists) -> None:
    whole = Crop(0, 0, mic_tiles.width, mic_tiles.height)
    launches = cut_launches(mic_tiles, whole)
    assert max(launch.words for launch in launches) <= SPM_WORDS
    assert sum(launch.block.pixels for launch in launches) == whole.pixels


def test_mic_head_is_cut_into_smaller_blocks_of_the_same_picture(mic_tiles: TileLists) -> None:
    crop = Crop(80, 16, 16, 16)
    assert int(mic_tiles.lengths[1, 5]) == 3275
    launches = cut_launches(mic_tiles, crop)
    assert len(launches) > 1
    blended = [blend_block(launch.splats, launch.block).rgbt.ravel() for launch in launches]
    expected = over_background(blend_image(mic_tiles, crop).rgbt)
    np.testing.assert_array_equal(assemble(crop, launches, blended), expected)


def test_assemble_refuses_what_was_not_cut_from_the_crop() -> None:
    crop = Crop(0, 0, 16, 16)
    launches = cut_launches(one_tile(797), crop)
    outputs = [run(launch) for launch in launches]
    with pytest.raises(SceneError, match="2 launches, but 1 outputs"):
        assemble(crop, launches, outputs[:1])
    with pytest.raises(SceneError, match="exactly once"):
        assemble(crop, launches[:1], outputs[:1])
    with pytest.raises(SceneError, match="exactly once"):
        assemble(crop, [*launches, launches[0]], [*outputs, outputs[0]])
    with pytest.raises(SceneError, match="has shape"):
        assemble(crop, launches, [outputs[0], outputs[1][:-1]])


def test_a_crop_must_lie_in_the_image() -> None:
    with pytest.raises(SceneError, match="not a part of the 16x16 image"):
        cut_launches(one_tile(3), Crop(8, 8, 16, 16))
