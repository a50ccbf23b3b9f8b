"""A camera that orbits a scene, for scenes that come without one."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from vividc.errors import demand_type, quoted
from vividc.render.arrays import frozen_float32
from vividc.render.camera import LARGEST_PX, Camera
from vividc.render.errors import SceneError
from vividc.render.ply import Gaussians
from vividc.render.scenes import Scene, demand_scene

_FIELD_OF_VIEW = math.radians(40)
_PERCENTILES = (5, 95)
"""Of Gaussians' centres: strays must not shrink the rest."""
_SIGMAS = 3
_CLEAR = 0.25
"""World units before the scene: nearer than 0.2, Gaussians are cut off."""
_STEEPEST = 89.0
_AXES = {
    f"{sign}{axis}": (value, index)
    for index, axis in enumerate("xyz")
    for sign, value in (("+", 1.0), ("-", -1.0))
}

Float64Array = npt.NDArray[np.float64]


def orbit_camera(
    scene: Scene, azimuth: float, elevation: float, up: str, width: int, height: int
) -> Camera:
    """Return a camera that looks at the middle of a scene and sees all of it.

    Parameters
    ----------
    azimuth, elevation
        Degrees around the axis `up`, and above the plane across it.
    up
        The axis of the scene that points up: "+x", "-x", ... "-z".

    Raises
    ------
    SceneError
        An angle is no finite number, or the elevation is not within 89 degrees.
    """
    demand_scene(scene)
    for angle in (azimuth, elevation):
        demand_type(angle, (int, float), "an angle", "give degrees as a number")
    demand_type(up, str, "the axis that points up", ", ".join(_AXES))
    if up not in _AXES:
        raise SceneError(f"{quoted(up)} is not an axis", hint=", ".join(_AXES))
    for side in (width, height):
        demand_type(side, int, "a picture's side", "give pixels as an integer")
    if not math.isfinite(azimuth) or not abs(elevation) <= _STEEPEST:
        raise SceneError(
            f"no camera at azimuth {azimuth:g} and elevation {elevation:g} degrees",
            hint=f"an elevation is -{_STEEPEST:g} to {_STEEPEST:g}",
        )
    centre, radius = _extent(scene)
    axis = np.zeros(3)
    axis[_AXES[up][1]] = _AXES[up][0]
    first = np.roll(np.abs(axis), 1)
    second = np.cross(axis, first)
    around, above = math.radians(azimuth), math.radians(elevation)
    level = math.cos(around) * first + math.sin(around) * second
    back = math.cos(above) * level + math.sin(above) * axis
    right = np.cross(axis, back)
    right /= np.linalg.norm(right)
    focal = 0.5 * max(0, min(width, height, LARGEST_PX)) / math.tan(0.5 * _FIELD_OF_VIEW)
    distance = max(radius / math.sin(0.5 * _FIELD_OF_VIEW), radius + _CLEAR)
    pose = np.eye(4)
    pose[:3, :3] = np.stack((right, np.cross(back, right), back), axis=1)
    pose[:3, 3] = centre + distance * back
    return Camera(frozen_float32(pose), focal, width, height)


def _extent(scene: Scene) -> tuple[Float64Array, float]:
    """Return the middle of a scene [3], and half the diagonal of what matters of it."""
    around = 0.0
    if not isinstance(scene, Gaussians):
        low, high = scene.march.box.astype(np.float64)
    elif len(scene) == 0:
        low, high = -np.ones(3), np.ones(3)
    else:
        low, high = np.percentile(scene.means.astype(np.float64), _PERCENTILES, axis=0)
        around = _SIGMAS * float(np.percentile(scene.scales.max(axis=1), _PERCENTILES[1]))
    return 0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low)) + around
