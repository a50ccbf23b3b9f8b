"""The first stages of 3DGS on the array: projection and footprints, then the colour of visible
splats.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vividc.render.array.device.device import Device
from vividc.render.array.device.launch import Gathered, Launch
from vividc.render.array.device.launches import Phase, in_turn
from vividc.render.array.splats.scene import DeviceScene, camera_words, screen_tiles
from vividc.render.arrays import Float32Array, Int32Array
from vividc.render.camera import Camera

ROW_WORDS = 13
ENTRY_WORDS = 3
_MOST = 166
"""Gaussians that a tile works on at once; the words of two chunks fit a scratchpad."""
_FILE = "render/splat_project"


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
    device: Device, scene: DeviceScene, camera: Camera, margin: float
) -> DeviceSplats:
    """Project a scene, and compute the colours of the visible splats."""
    if len(scene.geometry) == 0:
        rows, entries = np.zeros((0, ROW_WORDS), np.float32), np.zeros((0, ENTRY_WORDS), np.int32)
        return DeviceSplats(rows, entries, np.zeros(0, np.int32), (), _MOST, 0, 0)
    splats = _footprints(device, scene, camera, margin)
    if len(splats):
        _colour(device, scene, camera, splats)
    return splats


def _footprints(device: Device, scene: DeviceScene, camera: Camera, margin: float) -> DeviceSplats:
    columns, rows = screen_tiles(camera)
    chunk = _chunk(len(scene.geometry), device.tiles)
    chunks = -(-len(scene.geometry) // chunk)
    slots = chunks * chunk
    placed = np.zeros((len(scene.geometry), 6), dtype=np.float32)
    splats = np.zeros((slots, ROW_WORDS), dtype=np.float32)
    entries = np.zeros((slots, ENTRY_WORDS), dtype=np.int32)
    sources = np.zeros(slots, dtype=np.int32)
    depths = np.zeros((chunks, 2), dtype=np.int32)
    seen_from = camera_words(camera)
    parts = [slice(first, first + chunk) for first in range(0, slots, chunk)]
    covariances = [
        Launch(
            inputs={"geometry": scene.geometry[part]},
            outputs={"placed": placed[part]},
            shared={"camera": seen_from},
        )
        for part in parts
    ]
    footprints = [
        Launch(
            inputs={"placed": placed[part], "opacity": scene.opacity[part]},
            outputs={
                "splats": splats[part],
                "entries": entries[part],
                "sources": sources[part],
                "depths": depths[number],
            },
            scalars={"margin": margin, "columns": columns, "rows": rows, "first": part.start},
        )
        for number, part in enumerate(parts)
    ]
    phases = [
        Phase(f"{_FILE}:splat_covariance", in_turn(covariances, device.tiles)),
        Phase(f"{_FILE}:splat_footprints", in_turn(footprints, device.tiles)),
    ]
    _, returned = device.run_phases("projection", phases)
    counts = tuple(returned[i % device.tiles][i // device.tiles] for i in range(chunks))
    seen = [i for i, count in enumerate(counts) if count]
    nearest = min((int(depths[i, 0]) for i in seen), default=0)
    farthest = max((int(depths[i, 1]) for i in seen), default=0)
    return DeviceSplats(splats, entries, sources, counts, chunk, nearest, farthest)


def _chunk(gaussians: int, tiles: int) -> int:
    """Return how many Gaussians a tile works on at once, so that all have as many."""
    share = -(-gaussians // tiles)
    return -(-share // -(-share // _MOST))


def _colour(device: Device, scene: DeviceScene, camera: Camera, splats: DeviceSplats) -> None:
    """Fill in the colours of the splats that are seen; only their coefficients are fetched."""
    words = scene.appearance.shape[1]
    eye = {f"eye_{axis}": camera.position[k] for k, axis in enumerate("xyz")}
    launches = []
    most = device.fitting(words + ROW_WORDS, arrays=2)
    for first, last in _pieces(splats.spans(), most):
        chunk = first // splats.chunk * splats.chunk
        source = scene.appearance[chunk : chunk + splats.chunk]
        rows = splats.rows[first:last]
        launches.append(
            Launch(
                inputs={
                    "appearance": Gathered(source, splats.sources[first:last]),
                    "splats": rows,
                },
                outputs={"splats": rows},
                scalars=eye,
            )
        )
    kernel = f"{_FILE}:splat_colours_{scene.degree}"
    device.run_shares("colour", kernel, in_turn(launches, device.tiles))


def _pieces(spans: list[tuple[int, int]], most: int) -> list[tuple[int, int]]:
    """Cut spans into pieces of at most `most`."""
    return [
        (start, min(start + most, last))
        for first, last in spans
        for start in range(first, last, most)
    ]
