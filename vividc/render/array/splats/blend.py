"""Blending of 3DGS on the array: one screen tile at a time, its list part by part."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias

import numpy as np

import vividc
from vividc.launch.turns import deal
from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger
from vividc.render.array.device.kernels import Options, exp_in
from vividc.render.array.device.launch import Gathered, Launch
from vividc.render.array.device.launches import Phase
from vividc.render.array.options import RenderPrecision
from vividc.render.array.splats.project import DeviceSplats
from vividc.render.array.splats.sort import ScreenLists
from vividc.render.array.steering import PARTS_OF_A_SHARE, RUN_ENTRIES, WORTH_CUTTING
from vividc.render.arrays import Float32Array, Int32Array, frozen_float32
from vividc.render.camera import Camera
from vividc.render.crop import TILE_PX

_FILE = "render/splat_blend"
_STAGE = "blend"
_SIDE = 4
_BLOCK_PIXELS = _SIDE * _SIDE
_LIST_PART = 160
"""Entries of a list that a run takes, as in the kernels' file."""
_COUNTS = 4
_CLEAR = frozen_float32(np.tile(np.array([0, 0, 0, 1]), TILE_PX * TILE_PX))
"""Black, and nothing in the way."""
Culling: TypeAlias = Literal["none", "blocks", "pixels"]
"""What Lookahead Culling II decides before exp: nothing, blocks of pixels, or then also pixels."""
_KERNELS: dict[Culling, str] = {
    "none": "blend_late",
    "blocks": "blend_blocks",
    "pixels": "blend_lookahead",
}
EXP_EXCESS: Final[dict[RenderPrecision, float]] = {"fp32": 0.0, "fp16": 0.001, "fp8": 0.0715}
"""How far the logarithm of exp in a format may lie above the exponent, where exp is 1/255 or more:
Lookahead Culling II keeps what is that much below its threshold. float16 errs by 0.75 units in the
last place (`vividc.dfg.expand.exp`); float8's line is highest at 3/8 and at 1/2
between two powers of two, where its logarithm is 0.0711 too large.
"""


@dataclass(frozen=True, slots=True)
class Band:
    """Rows of blocks of a screen tile to blend: its place in pixels, rows of pixels in the image,
    rows of blocks, and the tile's list."""

    x: int
    y: int
    height: int
    block_rows: int
    first: int
    last: int

    @property
    def work(self) -> int:
        """Entries of the list in each row of blocks, and what its runs cost beside them."""
        length = self.last - self.first
        return length * self.block_rows + RUN_ENTRIES * -(-length // _LIST_PART)

    def halves(self) -> tuple[Band, Band]:
        """The upper and the lower half of its rows of blocks."""
        upper = self.block_rows // 2
        rows = upper * _SIDE
        return (
            replace(self, height=min(self.height, rows), block_rows=upper),
            replace(
                self,
                y=self.y + rows,
                height=self.height - rows,
                block_rows=self.block_rows - upper,
            ),
        )


def _launches(
    band: Band, splats: DeviceSplats, lists: ScreenLists, image: Float32Array, counts: Int32Array
) -> Iterator[Launch]:
    """Yield the launches of a band, part by part of its list; `counts` are those of its tile."""
    target = _blocks_of(image, band)
    starts = range(band.first, band.last, _LIST_PART)
    for start in starts:
        slots = lists.slots[start : min(start + _LIST_PART, band.last)]
        yield Launch(
            shapes={"pixels": _CLEAR.shape},
            inputs={"splats": Gathered(splats.rows, slots)},
            carried={"pixels": target, "counts": counts},
            starts={"pixels": _CLEAR, "counts": counts},
            scalars={
                "n": len(slots),
                "x0": np.float32(band.x),
                "y0": np.float32(band.y),
                "height": band.height,
                "last": int(start == starts[-1]),
            },
        )


def blend_splats(
    device: Device,
    splats: DeviceSplats,
    lists: ScreenLists,
    camera: Camera,
    culling: Culling,
    chosen: Int32Array,
    precision: RenderPrecision = "fp32",
) -> Float32Array:
    """Return the picture [height, width, 3] over white, of the `chosen` screen tiles.

    Those without splats are not run. The picture is the same with every kind of culling. exp is
    computed in `precision`.
    """
    columns, rows = -(-camera.width // TILE_PX), -(-camera.height // TILE_PX)
    side = TILE_PX // _SIDE
    image = np.ones((rows * side, _SIDE, columns * side, _SIDE, 4), dtype=np.float32)
    counts = np.zeros((device.tiles, _COUNTS), dtype=np.int32)
    shares = [
        [launch for band in share for launch in _launches(band, splats, lists, image, own)]
        for own, share in zip(
            counts, balanced(_screens(lists, camera, columns, chosen), device.tiles), strict=True
        )
    ]
    kernel, options = _kernel(culling, precision)
    device.run_phases(_STAGE, [Phase(kernel, shares, options)])
    _count(device.ledger, counts, culling)
    whole = image.reshape(rows * TILE_PX, columns * TILE_PX, 4)
    return np.ascontiguousarray(whole[: camera.height, : camera.width, :3])


def _blocks_of(image: Float32Array, band: Band) -> Float32Array:
    """Return a band of the image [block rows, rows, block columns, columns, 4], by block."""
    row, column, side = band.y // _SIDE, band.x // _SIDE, TILE_PX // _SIDE
    return image[row : row + band.block_rows, :, column : column + side].transpose(0, 2, 1, 3, 4)


def blend_program(
    device: Device, culling: Culling, precision: RenderPrecision = "fp32"
) -> vividc.Program:
    """Return the program that blends with this culling, and with exp in this format."""
    kernel, options = _kernel(culling, precision)
    return device.programs.get(kernel, **options)


def _kernel(culling: Culling, precision: RenderPrecision) -> tuple[str, Options]:
    """Return the kernel, and options of its compilation."""
    return f"{_FILE}:{_KERNELS[culling]}", exp_in(precision)


def _count(ledger: Ledger, counts: Int32Array, culling: Culling) -> None:
    """Book what was decided: pairs of an entry and a pixel, exponents, exps."""
    tests, exponents, survivors = (int(n) for n in counts.sum(axis=0, dtype=np.int64)[:3])
    pairs = exponents if culling == "none" else _BLOCK_PIXELS * tests
    exponentials = survivors if culling == "pixels" else exponents
    ledger.count(evaluated=pairs, exponents=exponents, exponentials=exponentials)


def _screens(lists: ScreenLists, camera: Camera, columns: int, chosen: Int32Array) -> list[Band]:
    """Return those of the chosen screen tiles in which something may be seen, each whole."""
    bands = []
    lengths = np.diff(lists.start)[chosen]
    for tile in chosen[lengths > 0].tolist():
        x, y = tile % columns * TILE_PX, tile // columns * TILE_PX
        height = min(TILE_PX, camera.height - y)
        first, last = int(lists.start[tile]), int(lists.start[tile + 1])
        bands.append(Band(x, y, height, -(-height // _SIDE), first, last))
    return bands


def balanced(screens: Sequence[Band], tiles: int) -> list[list[Band]]:
    """Give each tile whole screen tiles, or bands of them where the last tile then ends earlier.

    A band reads the list of its whole screen tile, and what an entry costs is known roughly only:
    where pixels are done early it is less. So cutting has to promise a good deal.
    """
    whole = _shares(screens, tiles)
    mean = sum(screen.work for screen in screens) / tiles
    cut = [_shares(_cut(screens, mean / parts), tiles) for parts in PARTS_OF_A_SHARE]
    best = min(cut, key=_longest)
    return best if _longest(best) < WORTH_CUTTING * _longest(whole) else whole


def _cut(screens: Sequence[Band], most: float) -> list[Band]:
    """Halve what is more work than `most`, down to single rows of blocks."""
    bands, todo = [], list(screens)
    while todo:
        band = todo.pop()
        if band.work > most and band.block_rows > 1:
            todo += band.halves()
        else:
            bands.append(band)
    return bands


def _shares(bands: Sequence[Band], tiles: int) -> list[list[Band]]:
    """Give each tile bands; of those with the same work the ones higher up are dealt first."""
    rows = sorted(bands, key=lambda band: (band.y, band.x))
    return [[rows[n] for n in share] for share in deal([band.work for band in rows], tiles)]


def _longest(shares: Sequence[Sequence[Band]]) -> int:
    return max(sum(band.work for band in share) for share in shares)
