"""Blending of 3DGS on the array: a screen tile at a time, its list part by part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

import numpy as np

import vividc
from vividc.launch import At, Job
from vividc.render.array.device import Device
from vividc.render.array.frame import Ledger
from vividc.render.array.options import RenderPrecision
from vividc.render.array.splat_project import ROW_WORDS, WORD, DeviceSplats
from vividc.render.array.splat_sort import ScreenLists
from vividc.render.arrays import Float32Array, Int32Array, frozen_float32
from vividc.render.camera import Camera
from vividc.render.crop import TILE_PX

_FILE = "render/splat_blend"
_STAGE = "blend"
_MAPPING_S = 150.0
"""Seven loops; their IIs are the time of a frame."""
_SIDE = 4
_BLOCK_PIXELS = _SIDE * _SIDE
_LIST_PART = 160
"""Entries of a list that a run takes, as in the kernels' file."""
_PART_BYTES = WORD * ROW_WORDS * _LIST_PART
_TILE_BYTES = WORD * 4 * TILE_PX * TILE_PX
_PIXELS_AT = 2 * _PART_BYTES
_COUNTS_AT = _PIXELS_AT + 2 * _TILE_BYTES
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
last place (`vividc.dfg.passes.expand_exp_narrow`); float8's line is highest at 3/8 and at 1/2
between two powers of two, where its logarithm is 0.0711 too large.
"""


@dataclass(frozen=True, slots=True)
class _Screen:
    """A screen tile to blend: its place in pixels, rows of pixels in the image, and its list."""

    x: int
    y: int
    height: int
    first: int
    last: int

    @property
    def length(self) -> int:
        return self.last - self.first


@dataclass(slots=True, eq=False)
class _Blend:
    """The launch graph of blending."""

    job: Job
    program: vividc.Program
    splats: DeviceSplats
    lists: ScreenLists
    image: Float32Array
    counts: Int32Array

    def tile(self, tile: int, share: Sequence[_Screen]) -> None:
        """Add the steps of one tile: the next part of a list is fetched while one is blended."""
        zeros = self.counts[tile]
        counted = self.job.move_in(tile, zeros, _COUNTS_AT)
        parts_freed: list[list[int]] = [[counted], [counted]]
        pixels_freed: list[list[int]] = [[], []]
        number, run = 0, counted
        for screen, place in zip(share, _alternating(len(share)), strict=True):
            starts = range(screen.first, screen.last, _LIST_PART)
            pixels_at = _PIXELS_AT + place * _TILE_BYTES
            clear = self.job.move_in(tile, _CLEAR, pixels_at, after=pixels_freed[place])
            for start in starts:
                slots = self.lists.slots[start : min(start + _LIST_PART, screen.last)]
                at = number % 2 * _PART_BYTES
                freed = parts_freed[number % 2]
                rows = self.job.gather(tile, self.splats.rows, slots, at, after=freed)
                run = self.job.run(
                    tile,
                    self.program,
                    splats=At(at, (ROW_WORDS * len(slots),)),
                    pixels=At(pixels_at, (_TILE_BYTES // WORD,)),
                    counts=At(_COUNTS_AT, (_COUNTS,)),
                    n=len(slots),
                    x0=np.float32(screen.x),
                    y0=np.float32(screen.y),
                    height=screen.height,
                    last=int(start == starts[-1]),
                    after=[rows, clear, *freed],
                )
                parts_freed[number % 2] = [run]
                number += 1
            target = _blocks_of(self.image, screen)
            pixels_freed[place] = [self.job.move_out(tile, pixels_at, target, after=[run])]
        self.job.move_out(tile, _COUNTS_AT, zeros, after=[run])


def blend_splats(
    device: Device,
    ledger: Ledger,
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
    program = blend_program(device, culling, precision)
    columns, rows = -(-camera.width // TILE_PX), -(-camera.height // TILE_PX)
    side = TILE_PX // _SIDE
    image = np.ones((rows * side, _SIDE, columns * side, _SIDE, 4), dtype=np.float32)
    job = device.new_job()
    tiles = device.tiles
    counts = np.zeros((tiles, _COUNTS), dtype=np.int32)
    graph = _Blend(job, program, splats, lists, image, counts)
    screens = _screens(lists, camera, columns, chosen)
    for tile, share in enumerate(_shares(screens, tiles)):
        if share:
            graph.tile(tile, share)
    device.finish(ledger, _STAGE, job)
    _count(ledger, counts, culling)
    whole = image.reshape(rows * TILE_PX, columns * TILE_PX, 4)
    return np.ascontiguousarray(whole[: camera.height, : camera.width, :3])


def _blocks_of(image: Float32Array, screen: _Screen) -> Float32Array:
    """Return a screen tile of the image [block rows, rows, block columns, columns, 4], by block."""
    row, column, side = screen.y // _SIDE, screen.x // _SIDE, TILE_PX // _SIDE
    return image[row : row + side, :, column : column + side].transpose(0, 2, 1, 3, 4)


def blend_program(
    device: Device, culling: Culling, precision: RenderPrecision = "fp32"
) -> vividc.Program:
    """Return the program that blends with this culling, and with exp in this format."""
    policy = {} if precision == "fp32" else {"precision": {"exp": precision}}
    return device.programs.get(f"{_FILE}:{_KERNELS[culling]}", time_limit_s=_MAPPING_S, **policy)


def _count(ledger: Ledger, counts: Int32Array, culling: Culling) -> None:
    """Book what was decided: pairs of an entry and a pixel, exponents, exps."""
    tests, exponents, survivors = (int(n) for n in counts.sum(axis=0, dtype=np.int64)[:3])
    pairs = exponents if culling == "none" else _BLOCK_PIXELS * tests
    exponentials = survivors if culling == "pixels" else exponents
    ledger.count(evaluated=pairs, exponents=exponents, exponentials=exponentials)


def _screens(lists: ScreenLists, camera: Camera, columns: int, chosen: Int32Array) -> list[_Screen]:
    """Return those of the chosen screen tiles in which something may be seen."""
    found = []
    lengths = np.diff(lists.start)[chosen]
    for tile in chosen[lengths > 0].tolist():
        x, y = tile % columns * TILE_PX, tile // columns * TILE_PX
        height = min(TILE_PX, camera.height - y)
        found.append(_Screen(x, y, height, int(lists.start[tile]), int(lists.start[tile + 1])))
    return found


def _shares(screens: Sequence[_Screen], tiles: int) -> list[list[_Screen]]:
    """Give each tile screen tiles: the longest lists first, each to the tile with the least."""
    shares: list[list[_Screen]] = [[] for _ in range(tiles)]
    load = [0] * tiles
    for screen in sorted(screens, key=lambda screen: -screen.length):
        tile = load.index(min(load))
        shares[tile].append(screen)
        load[tile] += screen.length
    return shares


def _alternating(count: int) -> list[int]:
    return [number % 2 for number in range(count)]
