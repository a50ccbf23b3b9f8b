"""Opens a scene file of any of the four methods, and says which it is."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Final, TypeAlias

import numpy as np

from vividc.errors import ArgumentError, demand_type, printable, quoted
from vividc.render.archive import Archive, read_archive
from vividc.render.arrays import frozen_float32
from vividc.render.errors import SceneError
from vividc.render.ply import Gaussians, read_gaussians
from vividc.render.radiance.instant_ngp import InstantNGP, read_instant_ngp
from vividc.render.radiance.kilonerf import KiloNeRF, read_kilonerf
from vividc.render.radiance.tensorf import TensoRF, read_tensorf

GAUSSIANS: Final = "3dgs"
KILONERF: Final = "kilonerf"
INSTANT_NGP: Final = "instant-ngp"
TENSORF: Final = "tensorf"
METHODS: Final = (GAUSSIANS, KILONERF, INSTANT_NGP, TENSORF)

Scene: TypeAlias = Gaussians | KiloNeRF | InstantNGP | TensoRF

_LAYOUT: Final = (
    "a scene is a 3DGS .ply, or an npz of Gaussians (means), TensoRF (density_plane_0), "
    "Instant-NGP (table) or KiloNeRF (net_index) as in docs/rendering.md"
)
_CLAMP: Final = 80.0
_MARKS: Final = {
    "means": GAUSSIANS,
    "net_index": KILONERF,
    "table": INSTANT_NGP,
    "density_plane_0": TENSORF,
}
"""An array that only one method's npz has."""
_COEFFICIENTS: Final = (1, 4, 9, 16)


def read_scene(path: Path | str, method: str | None = None) -> tuple[str, Scene]:
    """Read a scene; return its method and it.

    Parameters
    ----------
    method
        The one it must be, of `METHODS`; None for whatever the file holds.

    Raises
    ------
    SceneError
        The file is unusable, or holds another method's scene.
    """
    demand_type(path, (str, os.PathLike), "the path", "give a string or a pathlib.Path")
    if method is not None:
        demand_type(method, str, "the method", ", ".join(METHODS))
    path = Path(path)
    if _is_ply(path):
        _demand_method(path, GAUSSIANS, method)
        return GAUSSIANS, read_gaussians(path)
    archive = read_archive(path, _LAYOUT)
    named = next((name for mark, name in _MARKS.items() if mark in archive), None)
    if named is None:
        raise archive.error(f"no scene: it holds {', '.join(sorted(archive.arrays)) or 'nothing'}")
    _demand_method(path, named, method)
    return named, _READERS[named](archive)


def demand_scene(scene: object) -> None:
    """Refuse what is neither Gaussians nor a ray-marched model.

    Raises
    ------
    ArgumentError
        It is something else.
    """
    if not isinstance(scene, Gaussians) and not hasattr(scene, "march"):
        raise ArgumentError(f"a scene cannot be {quoted(scene)}", hint="give what read_scene gave")


def read_gaussian_archive(archive: Archive) -> Gaussians:
    """Read means [N,3], log_scales [N,3], quats_wxyz [N,4], opacity [N] in 0..1 and sh [N,K,3]."""
    means = archive.floats("means", (None, 3))
    count = len(means)
    opacity = archive.floats("opacity", (count,))
    if ((opacity < 0) | (opacity > 1)).any():
        raise archive.error("opacity leaves 0..1", "give it after the sigmoid")
    sh = archive.floats("sh", (count, None, 3))
    if sh.shape[1] not in _COEFFICIENTS:
        raise archive.error(f"sh has {sh.shape[1]} coefficients a channel, not 1, 4, 9 or 16")
    rotations = archive.floats("quats_wxyz", (count, 4)).astype(np.float64)
    norms = np.linalg.norm(rotations, axis=1, keepdims=True)
    if not norms.all():
        raise archive.error(f"quats_wxyz[{int(np.argmin(norms))}] is the zero quaternion")
    log_scales = archive.floats("log_scales", (count, 3)).astype(np.float64)
    return Gaussians(
        means=means,
        scales=frozen_float32(np.exp(np.clip(log_scales, -_CLAMP, _CLAMP))),
        rotations=frozen_float32(rotations / norms),
        opacity=opacity,
        sh=sh,
    )


_READERS: Final[dict[str, Callable[[Archive], Scene]]] = {
    GAUSSIANS: read_gaussian_archive,
    KILONERF: read_kilonerf,
    INSTANT_NGP: read_instant_ngp,
    TENSORF: read_tensorf,
}


def _is_ply(path: Path) -> bool:
    """Tell by the ending, and of others by the first bytes."""
    if path.suffix in (".ply", ".npz"):
        return path.suffix == ".ply"
    try:
        with path.open("rb") as stream:
            return stream.read(3) == b"ply"
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise SceneError(
            f"cannot be read: {reason}", loc=printable(str(path)), hint="check the path"
        ) from error


def _demand_method(path: Path, method: str, wanted: str | None) -> None:
    if wanted is not None and method != wanted:
        raise SceneError(
            f"the file holds a scene of {method}, not {wanted}",
            loc=str(path),
            hint=f"use --method {method}, or leave it out",
        )
