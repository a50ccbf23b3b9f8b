"""Pinhole cameras, and the files of reference views (`ref_*.npz`) they are read from."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
import numpy.typing as npt
from numpy.lib.npyio import NpzFile

from vividc.render.arrays import Float32Array, frozen_float32
from vividc.render.errors import SceneError

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
        if self.c2w.shape != (4, 4) or not np.isfinite(self.c2w).all():
            raise SceneError(
                f"a camera pose must be a finite 4x4 matrix, got shape {self.c2w.shape}",
                hint="c2w maps camera to world, OpenGL axes",
            )
        if self.width < 1 or self.height < 1 or not self.focal > 0:
            raise SceneError(
                f"impossible camera: {self.width}x{self.height} pixels, focal {self.focal}",
                hint="size and focal length are in pixels and positive",
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
    if width * camera.height != height * camera.width:
        raise SceneError(
            f"{width}x{height} has another aspect ratio than {camera.width}x{camera.height}",
            hint="scale both sides by the same factor",
        )
    return Camera(camera.c2w, camera.focal * width / camera.width, width, height)


def load_cameras(path: Path | str) -> tuple[Camera, ...]:
    """Return the cameras of a reference file: c2w [V,4,4] OpenGL, `focal` and `size` in pixels."""
    path = Path(path)
    arrays = _load_arrays(path, ("c2w", "focal", "size"))
    poses, focal, size = arrays["c2w"], arrays["focal"], arrays["size"]
    if poses.shape[1:] != (4, 4) or focal.size != 1 or size.size != 1:
        raise SceneError(
            f"unexpected shapes: c2w {poses.shape}, focal {focal.shape}, size {size.shape}",
            loc=str(path),
            hint=_VIEWS_HINT,
        )
    pixels = int(size.item())
    return tuple(
        Camera(frozen_float32(pose), float(focal.item()), pixels, pixels) for pose in poses
    )


def load_reference_images(path: Path | str) -> Float32Array:
    """Return the reference renders of a file, [V, height, width, 3] float32, not clipped."""
    path = Path(path)
    return frozen_float32(_load_arrays(path, ("images",))["images"])


def _load_arrays(path: Path, names: tuple[str, ...]) -> dict[str, npt.NDArray[np.generic]]:
    try:
        with path.open("rb") as stream:
            archive = np.load(stream, allow_pickle=False)
            if isinstance(archive, NpzFile):
                return {name: archive[name] for name in names}
    except OSError as error:
        raise SceneError(
            f"cannot read the views: {error.strerror or error}",
            loc=str(path),
            hint="check the path",
        ) from error
    except KeyError as error:
        raise SceneError(
            f"the file of views lacks an array: {error.args[0]}", loc=str(path), hint=_VIEWS_HINT
        ) from error
    except (ValueError, EOFError, BadZipFile) as error:
        raise SceneError("not a usable npz file", loc=str(path), hint=_VIEWS_HINT) from error
    raise SceneError("an npy file, not an npz", loc=str(path), hint=_VIEWS_HINT)
