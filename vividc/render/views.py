"""Views of a scene: cameras with the pictures they took, from `transforms.json` or npz."""

from __future__ import annotations

import io
import json
import math
import os
import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image, UnidentifiedImageError

from vividc.errors import demand_type
from vividc.host.inputs import GRAPH_BYTES, PICTURE_BYTES, demand_few_values, read_bytes, read_text
from vividc.render.archive import read_archive
from vividc.render.arrays import LARGEST_FLOAT32, Float32Array, frozen_float32
from vividc.render.camera import LARGEST_PX, Camera, scaled_camera
from vividc.render.errors import SceneError

_NPZ_LAYOUT = (
    "expected an npz with c2w [V,4,4], images [V,H,W,3], focal and size, "
    "or test_poses [V,4,4], test_images [V,H,W,4] and focal"
)
_JSON_LAYOUT = (
    "expected the transforms.json of NeRF-Synthetic: camera_angle_x, and frames with file_path "
    "and transform_matrix"
)
_DEFAULT_PX = 800
"""Side of the pictures of NeRF-Synthetic, where neither `w` nor a picture says another."""
_FORMATS = ("PNG", "JPEG", "WEBP", "BMP")
"""Others run programs, or unpack without a bound."""
_DAMAGE = (
    *(OSError, ValueError, SyntaxError, TypeError, IndexError, KeyError, OverflowError),
    *(struct.error, zlib.error, Image.DecompressionBombError, Image.DecompressionBombWarning),
)
"""What Pillow's readers raise."""
_BYTE_MAX = 255
_RGBA = 4
_IMAGE_AXES = 3
_VIEW_NAMES = (("c2w", "images"), ("test_poses", "test_images"))


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """A camera, and the picture that is to be seen through it if there is one.

    Attributes
    ----------
    camera
        The camera; its size is the picture's.
    name
        What the file calls it.
    picture
        The file of the picture, or the picture itself [height, width, 3 or 4], or None.
    """

    camera: Camera
    name: str
    picture: Path | npt.NDArray[np.generic] | None = None

    def truth(self) -> Float32Array | None:
        """Return the picture over white, [height, width, 3] float32 in 0..1, if there is one.

        Raises
        ------
        SceneError
            The picture's file cannot be read, or has another size than the camera.
        """
        if self.picture is None:
            return None
        pixels = read_picture(self.picture) if isinstance(self.picture, Path) else self.picture
        if pixels.shape[:2] != (self.camera.height, self.camera.width):
            raise SceneError(
                f"the picture of view {self.name} has {pixels.shape[1]}x{pixels.shape[0]} pixels, "
                f"its camera {self.camera.width}x{self.camera.height}",
                hint="all pictures of one file have one size",
            )
        return _over_white(pixels)

    def truth_at(self, width: int, height: int) -> Float32Array | None:
        """Return the picture at another size, or None if there is none or no whole factor.

        Smaller pictures are means over squares of pixels.
        """
        factor = self.camera.width // width
        if factor * width != self.camera.width or factor * height != self.camera.height:
            return None
        picture = self.truth()
        if picture is None or factor == 1:
            return picture
        squares = picture.reshape(height, factor, width, factor, _IMAGE_AXES)
        return frozen_float32(squares.mean(axis=(1, 3), dtype=np.float64))

    def camera_at(self, width: int, height: int) -> Camera:
        """Return the camera at another size of the same aspect ratio."""
        return scaled_camera(self.camera, width, height)


def read_views(path: Path | str) -> tuple[View, ...]:
    """Read the views of a `.json` (Blender, as NeRF-Synthetic) or `.npz` file.

    Raises
    ------
    SceneError
        The file is missing, damaged, or lacks a field; it has no view.
    """
    demand_type(path, (str, os.PathLike), "the path", "give a string or a pathlib.Path")
    path = Path(path)
    views = _json_views(path) if path.suffix == ".json" else _npz_views(path)
    if not views:
        raise SceneError("the file holds no view", loc=str(path))
    return views


def _npz_views(path: Path) -> tuple[View, ...]:
    archive = read_archive(path, _NPZ_LAYOUT)
    names = next((pair for pair in _VIEW_NAMES if pair[0] in archive), None)
    if names is None:
        raise archive.error("neither `c2w` nor `test_poses` is there")
    poses = archive.floats(names[0], (None, 4, 4))
    focal = archive.number("focal", above=0)
    if names[1] not in archive:
        size = archive.whole("size", above=0)
        return tuple(View(Camera(pose, focal, size, size), str(i)) for i, pose in enumerate(poses))
    images = archive.arrays[names[1]]
    fits = images.ndim == _IMAGE_AXES + 1 and images.shape[3] in (_IMAGE_AXES, _RGBA)
    if not fits or len(images) != len(poses) or images.dtype.kind not in "fu":
        raise archive.error(
            f"the array `{names[1]}` is {images.dtype} {list(images.shape)}, not pictures of the "
            f"{len(poses)} poses"
        )
    height, width = images.shape[1:3]
    return tuple(
        View(Camera(pose, focal, width, height), str(i), image)
        for i, (pose, image) in enumerate(zip(poses, images, strict=True))
    )


def _json_views(path: Path) -> tuple[View, ...]:
    document = _read_json(path)
    frames = document.get("frames")
    if not isinstance(frames, list) or not all(isinstance(frame, dict) for frame in frames):
        raise SceneError("`frames` is not a list of objects", loc=str(path), hint=_JSON_LAYOUT)
    pictures = [_picture_path(path, frame) for frame in frames]
    width, height = _size(document, path, pictures)
    focal = _focal(document, path, width)
    return tuple(
        View(Camera(_pose(path, i, frame), focal, width, height), _name(i, frame), picture)
        for i, (frame, picture) in enumerate(zip(frames, pictures, strict=True))
    )


def _read_json(path: Path) -> Mapping[str, Any]:
    text = read_text(path, GRAPH_BYTES, SceneError, "check the path")
    demand_few_values(text, GRAPH_BYTES, path, SceneError)
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise SceneError(f"not JSON: {error}", loc=str(path), hint=_JSON_LAYOUT) from error
    if not isinstance(document, dict):
        raise SceneError("the JSON is not an object", loc=str(path), hint=_JSON_LAYOUT)
    return document


def _pose(path: Path, index: int, frame: Mapping[str, Any]) -> Float32Array:
    matrix = frame.get("transform_matrix")
    try:
        pose = np.array(matrix, dtype=np.float64)
    except (TypeError, ValueError):
        pose = np.empty(0)
    if pose.shape != (4, 4) or not (np.abs(pose) <= LARGEST_FLOAT32).all():
        raise SceneError(
            f"frames[{index}].transform_matrix is not a finite 4x4 matrix",
            loc=str(path),
            hint=_JSON_LAYOUT,
        )
    return frozen_float32(pose)


def _name(index: int, frame: Mapping[str, Any]) -> str:
    return str(frame.get("file_path", index))


def _picture_path(path: Path, frame: Mapping[str, Any]) -> Path | None:
    """Return the file of a frame's picture, if it is there; `.png` is added where there is no
    ending.
    """
    name = frame.get("file_path")
    if not isinstance(name, str) or not name:
        return None
    file = path.parent / name
    file = file if file.suffix else Path(f"{file}.png")
    return file if os.path.isfile(file) else None


def _size(document: Mapping[str, Any], path: Path, pictures: list[Path | None]) -> tuple[int, int]:
    if "w" in document or "h" in document:
        return int(_number(document, path, "w")), int(_number(document, path, "h"))
    first = next((picture for picture in pictures if picture is not None), None)
    if first is None:
        return _DEFAULT_PX, _DEFAULT_PX
    height, width = read_picture(first).shape[:2]
    return width, height


def _focal(document: Mapping[str, Any], path: Path, width: int) -> float:
    if "fl_x" in document:
        return _number(document, path, "fl_x")
    angle = _number(document, path, "camera_angle_x")
    if not angle < math.pi:
        raise SceneError(f"camera_angle_x is {angle:g}, not below pi", loc=str(path))
    return 0.5 * width / math.tan(0.5 * angle)


def _number(document: Mapping[str, Any], path: Path, name: str) -> float:
    value = document.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise SceneError(f"`{name}` is not a number", loc=str(path), hint=_JSON_LAYOUT)
    if not (math.isfinite(value) and value > 0):
        raise SceneError(f"`{name}` is {value}, not positive", loc=str(path), hint=_JSON_LAYOUT)
    return float(value)


def read_picture(path: Path) -> npt.NDArray[np.uint8]:
    data = read_bytes(path, PICTURE_BYTES, SceneError)
    try:
        with Image.open(io.BytesIO(data), formats=_FORMATS) as picture:
            if max(picture.size) > LARGEST_PX:
                what = "x".join(map(str, picture.size))
                reason = f"a picture of {what} pixels: sides are at most {LARGEST_PX}"
                raise SceneError(reason, loc=str(path))
            return np.asarray(picture.convert("RGBA"), dtype=np.uint8)
    except UnidentifiedImageError as error:
        hint = f"expected: {', '.join(_FORMATS)}"
        raise SceneError("not a picture", loc=str(path), hint=hint) from error
    except _DAMAGE as error:
        raise SceneError(f"cannot read the picture: {error}", loc=str(path)) from error


def _over_white(pixels: npt.NDArray[np.generic]) -> Float32Array:
    scale = _BYTE_MAX if pixels.dtype == np.uint8 else 1
    values = pixels.astype(np.float32) / np.float32(scale)
    if pixels.shape[2] == _IMAGE_AXES:
        return frozen_float32(values)
    alpha = values[..., _IMAGE_AXES:]
    return frozen_float32(values[..., :_IMAGE_AXES] * alpha + (1 - alpha))
