"""Cuts a crop into launches of the blending kernel and reassembles their outputs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from vividc.render.arrays import Float32Array
from vividc.render.crop import Crop, check_inside, tiles_meeting
from vividc.render.errors import SceneError
from vividc.render.splat.blend_reference import over_background
from vividc.render.splat.block_cull import seen_in
from vividc.render.splat.splat import Splats, TileLists

SPM_WORDS = 8192
"""32-bit words of a 32 KB scratchpad, which must hold all arrays of one launch."""
_SPLAT_WORDS = 9
_PIXEL_WORDS = 4


@dataclass(frozen=True, slots=True, eq=False)
class BlendLaunch:
    """One launch of the blending kernel: a depth-sorted list of splats over some pixels.

    `block` is in pixels of the whole image, within one screen tile.
    """

    splats: Splats
    block: Crop

    @property
    def words(self) -> int:
        """32-bit words of all arrays of the launch."""
        return _list_words(len(self.splats)) + _PIXEL_WORDS * self.block.pixels

    def arguments(self) -> dict[str, Float32Array | np.int32]:
        """Return the kernel's arguments in order, as fresh writable arrays and int32 scalars.

        The nine splat arrays are float32[n] (one zero if n is 0); `out` is float32
        [4 * width * height], zeroed, for r, g, b, T of each pixel, row-major.
        """
        return {
            **self._splat_arrays(),
            "out": np.zeros(_PIXEL_WORDS * self.block.pixels, dtype=np.float32),
            "x0": np.int32(self.block.x0),
            "y0": np.int32(self.block.y0),
            "width": np.int32(self.block.width),
            "height": np.int32(self.block.height),
            "n": np.int32(len(self.splats)),
        }

    def _splat_arrays(self) -> dict[str, Float32Array]:
        length = max(len(self.splats), 1)
        padded = {name: np.zeros(length, dtype=np.float32) for name in self.splats.arrays()}
        for name, values in self.splats.arrays().items():
            padded[name][: len(values)] = values
        return padded


def cut_launches(
    tiles: TileLists, crop: Crop, spm_words: int = SPM_WORDS
) -> tuple[BlendLaunch, ...]:
    """Return the launches that together cover `crop` exactly once, by tile rows.

    Each covers one tile's part of the crop, or a band of its rows where the whole part does
    not fit the scratchpad. Where not even a row fits beside the tile's list, the list is reduced to
    what can be seen in the part, and the part halved until it fits: the picture is the same.

    Raises
    ------
    SceneError
        So many splats are seen at one pixel that their list does not fit.
    """
    check_inside(crop, tiles.width, tiles.height)
    launches: list[BlendLaunch] = []
    for tile_x, tile_y, part in tiles_meeting(crop):
        launches += _cut_block(tiles.tile(tile_x, tile_y), part, spm_words)
    return tuple(launches)


def cut_small_launches(
    tiles: TileLists, crop: Crop, spm_words: int, side: int = 8
) -> tuple[BlendLaunch, ...]:
    """Return launches of at most `side` x `side` pixels, each with what can be seen in it alone.

    They cover `crop` exactly once; the pictures are those of `cut_launches`, with less work. The
    list of a block in which nothing can be seen is empty.

    Raises
    ------
    SceneError
        So many splats are seen at one pixel that their list does not fit.
    """
    check_inside(crop, tiles.width, tiles.height)
    launches: list[BlendLaunch] = []
    for tile_x, tile_y, part in tiles_meeting(crop):
        splats = tiles.tile(tile_x, tile_y)
        for block in _blocks(part, side):
            launches += _cut_block(seen_in(splats, block), block, spm_words)
    return tuple(launches)


def _blocks(part: Crop, side: int) -> Iterator[Crop]:
    right, bottom = part.x0 + part.width, part.y0 + part.height
    for y0 in range(part.y0, bottom, side):
        for x0 in range(part.x0, right, side):
            yield Crop(x0, y0, min(side, right - x0), min(side, bottom - y0))


def _cut_block(splats: Splats, block: Crop, spm_words: int) -> list[BlendLaunch]:
    rows = _rows_that_fit(len(splats), block, spm_words)
    if rows >= 1:
        return [BlendLaunch(splats, band) for band in _bands(block, rows)]
    seen = seen_in(splats, block)
    if len(seen) < len(splats):
        return _cut_block(seen, block, spm_words)
    if block.pixels == 1:
        raise SceneError(
            f"{len(splats)} splats are seen at pixel ({block.x0}, {block.y0}): their "
            f"{_list_words(len(splats))} words and {_PIXEL_WORDS} words for the pixel exceed the "
            f"{spm_words} words of the scratchpad",
            hint="choose another crop, a larger scratchpad, or a larger image (fewer splats "
            "share a pixel)",
        )
    return [launch for half in _halves(block) for launch in _cut_block(splats, half, spm_words)]


def _halves(block: Crop) -> tuple[Crop, Crop]:
    """Return the two halves of a block of at least two pixels, cut across its longer side."""
    x0, y0, width, height = block.x0, block.y0, block.width, block.height
    if width >= height:
        left = width // 2
        return Crop(x0, y0, left, height), Crop(x0 + left, y0, width - left, height)
    top = height // 2
    return Crop(x0, y0, width, top), Crop(x0, y0 + top, width, height - top)


def assemble(
    crop: Crop, launches: Sequence[BlendLaunch], outputs: Sequence[Float32Array]
) -> Float32Array:
    """Return the picture [height, width, 3] of `crop` over white from each launch's `out`."""
    if len(launches) != len(outputs):
        raise SceneError(f"{len(launches)} launches, but {len(outputs)} outputs")
    rgbt = np.zeros((crop.height, crop.width, _PIXEL_WORDS), dtype=np.float32)
    covered = np.zeros((crop.height, crop.width), dtype=np.int32)
    for launch, out in zip(launches, outputs, strict=True):
        block = launch.block
        if out.shape != (_PIXEL_WORDS * block.pixels,):
            raise SceneError(
                f"the output of the block {block} has shape {out.shape}, "
                f"not ({_PIXEL_WORDS * block.pixels},)"
            )
        place = block.rows_and_columns_in(crop)
        rgbt[place] = out.reshape(block.height, block.width, _PIXEL_WORDS)
        covered[place] += 1
    if not (covered == 1).all():
        raise SceneError(
            f"the launches do not cover the crop {crop} exactly once",
            hint="pass the launches that were cut from this crop",
        )
    return over_background(rgbt)


def _list_words(splats: int) -> int:
    return _SPLAT_WORDS * max(splats, 1)


def _rows_that_fit(splats: int, part: Crop, spm_words: int) -> int:
    return (spm_words - _list_words(splats)) // (_PIXEL_WORDS * part.width)


def _bands(part: Crop, max_rows: int) -> Iterator[Crop]:
    """Yield bands of at most `max_rows` rows, as equal in height as can be."""
    count = -(-part.height // max_rows)
    edges = [part.height * i // count for i in range(count + 1)]
    for top, bottom in pairwise(edges):
        yield Crop(part.x0, part.y0 + top, part.width, bottom - top)
