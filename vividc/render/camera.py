"""Pinhole cameras, and the files of reference views (`ref_*.npz`) from which they are read."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from vividc.errors import demand_type, quoted
from vividc.host.inputs import SCENE_BYTES
from vividc.host.npz import read_npz
from vividc.render.arrays import Float32Array, frozen_float32
from vividc.render.errors import SceneError

LARGEST_PX: Final = 8192
"""A picture of this side takes 805 MB in float32."""
_INTEGERS: Final = (int, np.integer)
_NUMBERS: Final = (int, float, np.integer, np.floating)
_VIEWS_HINT = "expected an npz with c2w [V,4,4], focal, size and images [V,size,size,3]"


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """A pinhole camera with square pixels and its principal point at the image centre.

    Attributes
    ----------
    c2w
        [4, 4] float32 camera to world, OpenGL axes: x right, y up, looking along -z.
    focal
        Focal length in pixels.
    width, height
        Image size in pixels.
    """

    c2w: Float32Array
    focal: float
    width: int
    height: int

    def __post_init__(self) -> None:
        demand_type(self.c2w, np.ndarray, "a camera's pose", "give a matrix [4, 4] of float32")
        demand_type(self.focal, _NUMBERS, "a focal length", "give pixels as a number")
        for side in (self.width, self.height):
            demand_type(side, _INTEGERS, "a picture's side", "give pixels as an integer")
        if self.c2w.shape != (4, 4) or not np.isfinite(self.c2w).all():
            raise SceneError(
                f"a camera pose must be a finite 4x4 matrix, got shape {self.c2w.shape}",
                hint="c2w maps camera to world, OpenGL axes",
            )
        sides = (self.width, self.height)
        if not all(1 <= side <= LARGEST_PX for side in sides) or not 0 < self.focal < math.inf:
            size = "x".join(quoted(side, 20) for side in sides)
            raise SceneError(
                f"impossible camera: {size} pixels, focal {quoted(self.focal, 20)}",
                hint=f"size and focal length are in pixels; sides are 1 to {LARGEST_PX}",
            )

    @property
    def position(self) -> Float32Array:
        """[3] float32 centre of projection in world space."""
        return self.c2w[:3, 3]

    @property
    def world_to_view(self) -> Float32Array:
        """[3, 4] float32 world to camera with OpenCV axes: y down, looking along +z."""
        rotation = self.c2w[:3, :3] * np.array([1, -1, -1], dtype=np.float32)
        translation = -np.einsum("ij,i->j", rotation, self.position)
        return np.concatenate((rotation.T, translation[:, None]), axis=1)


def scaled_camera(camera: Camera, width: int, height: int) -> Camera:
    """Return the camera that sees the same picture at another size of the same aspect ratio."""
    demand_type(camera, Camera, "the camera", "give a Camera")
    for side in (width, height):
        demand_type(side, _INTEGERS, "a picture's side", "give pixels as an integer")
    if width * camera.height != height * camera.width:
        raise SceneError(
            f"{width}x{height} has another aspect ratio than {camera.width}x{camera.height}",
            hint="scale both sides by the same factor",
        )
    return Camera(camera.c2w, camera.focal * width / camera.width, width, height)


def load_cameras(path: Path | str) -> tuple[Camera, ...]:
    """Return the cameras of a reference file: c2w [V,4,4] OpenGL, `focal` and `size` in pixels."""
    demand_type(path, (str, os.PathLike), "the path", "give a string or a pathlib.Path")
    path = Path(path)
    arrays = _load_arrays(path, ("c2w", "focal", "size"))
    poses, focal, size = arrays["c2w"], arrays["focal"], arrays["size"]
    if poses.shape[1:] != (4, 4) or focal.size != 1 or size.size != 1:
        raise SceneError(
            f"unexpected shapes: c2w {poses.shape}, focal {focal.shape}, size {size.shape}",
            loc=str(path),
            hint=_VIEWS_HINT,
        )
    number = float(size.item())
    if not 1 <= number <= LARGEST_PX:
        reason = f"the size is {number:g} pixels, not 1 to {LARGEST_PX}"
        raise SceneError(reason, loc=str(path), hint=_VIEWS_HINT)
    pixels = int(number)
    return tuple(
        Camera(frozen_float32(pose), float(focal.item()), pixels, pixels) for pose in poses
    )


def load_reference_images(path: Path | str) -> Float32Array:
    """Return the reference renders of a file, [V, height, width, 3] float32, not clipped."""
    demand_type(path, (str, os.PathLike), "the path", "give a string or a pathlib.Path")
    path = Path(path)
    return frozen_float32(_load_arrays(path, ("images",))["images"])


def _load_arrays(path: Path, names: tuple[str, ...]) -> dict[str, npt.NDArray[np.generic]]:
    arrays = read_npz(path, SCENE_BYTES, SceneError, _VIEWS_HINT)
    lacking = [name for name in names if name not in arrays]
    if lacking:
        raise SceneError(
            f"the file of views lacks an array: {lacking[0]}", loc=str(path), hint=_VIEWS_HINT
        )
    odd = [name for name in names if arrays[name].dtype.kind not in "fiu"]
    if odd:
        reason = f"the array `{odd[0]}` does not hold numbers"
        raise SceneError(reason, loc=str(path), hint=_VIEWS_HINT)
    return arrays
