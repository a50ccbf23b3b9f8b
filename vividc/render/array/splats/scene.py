"""A scene of Gaussians and a camera as the arrays that lie in the accelerator's DRAM."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vividc.render.arrays import Float32Array
from vividc.render.camera import Camera
from vividc.render.crop import TILE_PX
from vividc.render.errors import SceneError
from vividc.render.ply import Gaussians

_FOV_MARGIN = 1.3
_LARGEST_TILE = 255
"""Bounds in screen tiles are a byte each."""


@dataclass(frozen=True, slots=True, eq=False)
class DeviceScene:
    """The Gaussians of a scene in DRAM.

    Attributes
    ----------
    geometry
        [N, 10] float32: centre, standard deviations, rotation.
    opacity
        [N, 1] float32.
    appearance
        [N, 3 + 3 K] float32: centre, spherical-harmonics coefficients [K, 3].
    degree
        Of the spherical harmonics, 0 to 3.
    """

    geometry: Float32Array
    opacity: Float32Array
    appearance: Float32Array
    degree: int


def device_scene(scene: Gaussians) -> DeviceScene:
    """Lay a scene out for the kernels.

    Raises
    ------
    SceneError
        A parameter is not finite.
    """
    columns = {
        "means": scene.means,
        "scales": scene.scales,
        "rotations": scene.rotations,
        "opacity": scene.opacity[:, None],
        "sh": scene.sh.reshape(len(scene), 3 * scene.sh.shape[1]),
    }
    for name, values in columns.items():
        wrong = np.flatnonzero(~np.isfinite(values).all(axis=1))
        if wrong.size:
            raise SceneError(
                f"`{name}` of Gaussian {wrong[0]} is not finite",
                hint="remove such Gaussians from the scene",
            )
    means, scales, rotations, opacity, sh = columns.values()
    return DeviceScene(
        geometry=np.concatenate((means, scales, rotations), axis=1),
        opacity=np.array(opacity, order="C"),
        appearance=np.concatenate((means, sh), axis=1),
        degree=scene.sh_degree,
    )


def camera_words(camera: Camera) -> Float32Array:
    """Return [17] float32: world to view [3, 4], focal length, limits of x/z and y/z, centre."""
    size = np.array([camera.width, camera.height], dtype=np.float32)
    focal = np.float32(camera.focal)
    limits = np.float32(_FOV_MARGIN) * size / (2 * focal)
    centre = (size - np.float32(1)) / np.float32(2)
    view = camera.world_to_view.astype(np.float32).ravel()
    return np.concatenate((view, [focal], limits, centre)).astype(np.float32)


def screen_tiles(camera: Camera) -> tuple[int, int]:
    """Return the columns and rows of screen tiles that cover the image.

    Raises
    ------
    SceneError
        They are more than a byte counts.
    """
    columns, rows = -(-camera.width // TILE_PX), -(-camera.height // TILE_PX)
    if max(columns, rows) > _LARGEST_TILE:
        raise SceneError(
            f"an image of {camera.width}x{camera.height} pixels has {columns}x{rows} screen tiles, "
            f"and the array's lists know {_LARGEST_TILE} in a row",
            hint=f"render at most {_LARGEST_TILE * TILE_PX} pixels a side",
        )
    return columns, rows
