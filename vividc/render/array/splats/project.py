"""The first stages of 3DGS on the array: projection and footprints, then the colour of visible
splats.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vividc.launch import At, Job
from vividc.launch.turns import Turns
from vividc.machine.words import WORD_BYTES
from vividc.render.array.device.device import Device
from vividc.render.array.device.frame import Ledger
from vividc.render.array.splats.scene import DeviceScene, camera_words, screen_tiles
from vividc.render.arrays import Float32Array, Int32Array
from vividc.render.camera import Camera

ROW_WORDS = 13
ENTRY_WORDS = 3
_CHUNK = 170
"""Gaussians that a tile works on at once; the words of two chunks fit a scratchpad."""
_PLACES = 2
_PLACE_WORDS = 4096
_CAMERA_WORDS = 17
_FILE = "render/splat_project"
_MAPPING_S = 30.0


@dataclass(frozen=True, slots=True, eq=False)
class DeviceSplats:
    """The splats that are seen, in DRAM, in scene order with gaps: each chunk's from its own start.

    Attributes
    ----------
    rows
        [slots, 13] float32, as in `kernels/render/splat_blend.py`.
    entries
        [slots, 3] int32: bounds in screen tiles, slot, bits of the depth.
    sources
        [slots] int32: row of the scene within the chunk.
    counts
        Of each chunk, how many are seen.
    chunk
        Slots of a chunk.
    nearest, farthest
        Bits of the least and largest depth.
    """

    rows: Float32Array
    entries: Int32Array
    sources: Int32Array
    counts: tuple[int, ...]
    chunk: int
    nearest: int
    farthest: int

    def __len__(self) -> int:
        return sum(self.counts)

    def spans(self) -> list[tuple[int, int]]:
        """Return first and one-past-last slot of what each chunk holds."""
        return [(self.chunk * i, self.chunk * i + n) for i, n in enumerate(self.counts) if n]


def project_on_array(
    device: Device, ledger: Ledger, scene: DeviceScene, camera: Camera, margin: float
) -> DeviceSplats:
    """Project a scene, and compute the colours of the visible splats."""
    if len(scene.geometry) == 0:
        rows, entries = np.zeros((0, ROW_WORDS), np.float32), np.zeros((0, ENTRY_WORDS), np.int32)
        return DeviceSplats(rows, entries, np.zeros(0, np.int32), (), _CHUNK, 0, 0)
    splats = _footprints(device, ledger, scene, camera, margin)
    if len(splats):
        _colour(device, ledger, scene, camera, splats)
    return splats


def _footprints(
    device: Device, ledger: Ledger, scene: DeviceScene, camera: Camera, margin: float
) -> DeviceSplats:
    columns, rows = screen_tiles(camera)
    chunks = -(-len(scene.geometry) // _CHUNK)
    slots = chunks * _CHUNK
    placed = np.zeros((len(scene.geometry), 6), dtype=np.float32)
    splats = np.zeros((slots, ROW_WORDS), dtype=np.float32)
    entries = np.zeros((slots, ENTRY_WORDS), dtype=np.int32)
    sources = np.zeros(slots, dtype=np.int32)
    depths = np.zeros((chunks, 2), dtype=np.int32)
    job = device.new_job()
    plan = _Projection(device, job, scene, camera_words(camera), placed)
    written = plan.covariances(chunks)
    target = _Footprints(splats, entries, sources, depths)
    scalars: dict[str, object] = {"margin": margin, "columns": columns, "rows": rows}
    runs = plan.footprints(chunks, written, target, scalars)
    result = device.finish(ledger, "projection", job)
    counts = tuple(int(result.values[run] or 0) for run in runs)
    seen = [i for i, count in enumerate(counts) if count]
    nearest = min((int(depths[i, 0]) for i in seen), default=0)
    farthest = max((int(depths[i, 1]) for i in seen), default=0)
    return DeviceSplats(splats, entries, sources, counts, _CHUNK, nearest, farthest)


@dataclass(frozen=True, slots=True, eq=False)
class _Footprints:
    """Where the footprints go."""

    splats: Float32Array
    entries: Int32Array
    sources: Int32Array
    depths: Int32Array


@dataclass(slots=True, eq=False)
class _Projection:
    """The launch graph of projection: on each tile all covariances, then all footprints."""

    device: Device
    job: Job
    scene: DeviceScene
    camera: Float32Array
    placed: Float32Array

    def covariances(self, chunks: int) -> list[int]:
        """Return the step after which each chunk lies projected in DRAM."""
        program = self.device.programs.get(f"{_FILE}:splat_covariance")
        tiles = self.device.tiles
        camera_at = _PLACES * _PLACE_WORDS * WORD_BYTES - _CAMERA_WORDS * WORD_BYTES
        cameras = self.job.move_in(range(min(tiles, chunks)), self.camera, camera_at)
        turns, written = Turns(range(tiles), _PLACES), []
        for chunk in range(chunks):
            tile, place, before = turns.take()
            start = place * (_PLACE_WORDS - _CAMERA_WORDS) * WORD_BYTES
            part = slice(chunk * _CHUNK, (chunk + 1) * _CHUNK)
            geometry = self.scene.geometry[part]
            n = len(geometry)
            here = self.job.move_in(tile, geometry, start, after=before)
            out = start + geometry.nbytes
            run = self.job.run(
                tile,
                program,
                geometry=At(start, geometry.shape),
                camera=At(camera_at, (_CAMERA_WORDS,)),
                placed=At(out, (n, 6)),
                after=[here, cameras, *before],
            )
            written.append(self.job.move_out(tile, out, self.placed[part], after=[run]))
            turns.free(tile, place, written[-1])
        return written

    def footprints(
        self, chunks: int, written: list[int], target: _Footprints, scalars: dict[str, object]
    ) -> list[int]:
        """Return the runs, whose values are how many Gaussians of each chunk are seen."""
        program = self.device.programs.get(f"{_FILE}:splat_footprints", time_limit_s=_MAPPING_S)
        tiles = self.device.tiles
        turns, runs = Turns(range(tiles), _PLACES), []
        for tile in range(min(tiles, chunks)):
            for place in range(_PLACES):
                turns.free(tile, place, *written[tile::tiles])
        for chunk in range(chunks):
            tile, place, before = turns.take()
            part = slice(chunk * _CHUNK, (chunk + 1) * _CHUNK)
            placed, opacity = self.placed[part], self.scene.opacity[part]
            at = _addresses(place * _PLACE_WORDS * WORD_BYTES, len(placed))
            moves = [
                self.job.move_in(tile, placed, at["placed"], after=[written[chunk], *before]),
                self.job.move_in(tile, opacity, at["opacity"], after=before),
            ]
            arrays = {
                "placed": At(at["placed"], placed.shape),
                "opacity": At(at["opacity"], opacity.shape),
                "splats": At(at["splats"], (ROW_WORDS * _CHUNK,)),
                "entries": At(at["entries"], (ENTRY_WORDS * _CHUNK,)),
                "sources": At(at["sources"], (_CHUNK,)),
                "depths": At(at["depths"], (2,)),
            }
            first = {"first": chunk * _CHUNK}
            run = self.job.run(tile, program, after=[*moves, *before], **arrays, **scalars, **first)
            runs.append(run)
            results = {
                "splats": target.splats[part],
                "entries": target.entries[part],
                "sources": target.sources[part],
                "depths": target.depths[chunk],
            }
            leaving = [
                self.job.move_out(tile, at[name], array, after=[run])
                for name, array in results.items()
            ]
            turns.free(tile, place, *leaving)
        return runs


def _addresses(start: int, count: int) -> dict[str, int]:
    """Where the arrays of a chunk lie, from byte `start` of the scratchpad on."""
    words = {"placed": 6 * count, "opacity": count, "splats": ROW_WORDS * _CHUNK}
    words |= {"entries": ENTRY_WORDS * _CHUNK, "sources": _CHUNK, "depths": 2}
    at = {}
    for name, size in words.items():
        at[name] = start
        start += WORD_BYTES * size
    return at


def _colour(
    device: Device, ledger: Ledger, scene: DeviceScene, camera: Camera, splats: DeviceSplats
) -> None:
    """Fill in the colours of the splats that are seen; only their coefficients are fetched."""
    program = device.programs.get(f"{_FILE}:splat_colours_{scene.degree}")
    job = device.new_job()
    words = scene.appearance.shape[1]
    most = min(_CHUNK, _PLACE_WORDS // (words + ROW_WORDS))
    turns = Turns(range(device.tiles), _PLACES)
    eye = {f"eye_{axis}": camera.position[k] for k, axis in enumerate("xyz")}
    for first, last in _pieces(splats.spans(), most):
        tile, place, before = turns.take()
        start = place * _PLACE_WORDS * WORD_BYTES
        chunk = first // splats.chunk * splats.chunk
        source = scene.appearance[chunk : chunk + splats.chunk]
        rows_at = start + (last - first) * words * WORD_BYTES
        rows = splats.rows[first:last]
        moves = [
            job.gather(tile, source, splats.sources[first:last], start, after=before),
            job.move_in(tile, rows, rows_at, after=before),
        ]
        run = job.run(
            tile,
            program,
            appearance=At(start, (last - first, words)),
            splats=At(rows_at, rows.shape),
            after=[*moves, *before],
            **eye,
        )
        turns.free(tile, place, job.move_out(tile, rows_at, rows, after=[run]))
    device.finish(ledger, "colour", job)


def _pieces(spans: list[tuple[int, int]], most: int) -> list[tuple[int, int]]:
    """Cut spans into pieces of at most `most`."""
    return [
        (start, min(start + most, last))
        for first, last in spans
        for start in range(first, last, most)
    ]
