"""Where trained scenes and photographs are, and the cameras that look at them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from vividc.render import (
    Camera,
    Picture,
    Scene,
    SceneError,
    View,
    orbit_camera,
    psnr,
    read_views,
    render_reference,
    scaled_camera,
    ssim,
)
from vividc.render.arrays import Float32Array

MIC: Final = "mic"
GAUSSIANS: Final = "3dgs"
MODELS: Final = {
    "mic_3dgs_sh3.ply": "ref_gs.npz",
    "mic_kilonerf.npz": "ref_kilo.npz",
    "mic_ngp_hash.npz": "ref_ngp.npz",
    "mic_tensorf_vm.npz": "ref_tf.npz",
}
"""Each model of `mic`, and its reference renders."""
METHODS: Final = (GAUSSIANS, "kilonerf", "instant-ngp", "tensorf")
"""In the order of `MODELS`."""
_SIZES: Final = (100, 200, 400)
"""Sides of the photographs that there are; other sizes are compared with the reference alone."""
_VIEWS: Final = 3
"""Held-out photographs whose views the array renders, evenly spread."""
_AZIMUTHS: Final = (30.0, 150.0, 270.0)
CHECKOUT: Final = Path(__file__).resolve().parents[2] / "scenes"
"""The scenes of a checkout."""


@dataclass(frozen=True, slots=True)
class Compared:
    """One view: the picture, and how near it is to what it is compared with."""

    picture: Picture
    psnr_db: float
    ssim: float


@dataclass(frozen=True, slots=True)
class Scenes:
    """Folders with `mic/` (models, and photographs as `mic_200.npz`) or `playbot/`.

    Attributes
    ----------
    folders
        A file is taken from the first that has it.
    """

    folders: tuple[Path, ...]

    def models(self) -> dict[str, dict[str, Path]]:
        """Return the file of each scene by method.

        Raises
        ------
        SceneError
            A model of `mic` is in no folder.
        """
        files = {}
        for method, name in zip(METHODS, MODELS, strict=True):
            path = self._find(name)
            if path is None:
                raise SceneError(
                    f"`{MIC}/{name}` is in none of {', '.join(map(str, self.folders))}",
                    loc="--scenes",
                    hint="give the folder `scenes` of vividc's repository",
                )
            files[method] = path
        found = {MIC: files}
        for folder in self.folders:
            for path in sorted((folder / "playbot").glob("*.npz")):
                found.setdefault(path.stem, {GAUSSIANS: path})
        return found

    def photographs(self, size: int) -> Path | None:
        """Return where the held-out photographs of a size are, if they are."""
        return self._find(f"mic_{size}.npz") if size in _SIZES else None

    def chosen_views(self, scene: str, size: int) -> list[int]:
        """Return the views that the array renders: some of the photographs, or around the scene."""
        path = self.photographs(size)
        if scene != MIC:
            return list(range(len(_AZIMUTHS)))
        if path is None:
            return [0]
        count = len(read_views(path))
        return [count * number // _VIEWS for number in range(_VIEWS)]

    def view(
        self, scene: str, method: str, view: int, size: int, model: Scene
    ) -> tuple[Camera, Float32Array | None]:
        """Return a camera of a square picture, and the photograph if there is one of that size."""
        if scene != MIC:
            return orbit_camera(model, _AZIMUTHS[view], 20.0, "-y", size, size), None
        path = self.photographs(size)
        if path is not None:
            found = read_views(path)[view]
            return found.camera, found.truth()
        renders = self._find(MODELS[self.models()[MIC][method].name])
        assert renders is not None
        return scaled_camera(read_views(renders)[view].camera, size, size), None

    def _find(self, name: str) -> Path | None:
        paths = (folder / MIC / name for folder in self.folders)
        return next((path for path in paths if path.is_file()), None)


def compare(scene: Scene, views: Sequence[View]) -> Iterator[Compared]:
    """Render each view on the host and compare it with its picture."""
    for view in views:
        truth = view.truth()
        if truth is None:
            continue
        picture = render_reference(scene, view.camera)
        shown, truth = np.clip(picture.image, 0, 1), np.clip(truth, 0, 1)
        yield Compared(picture, psnr(shown, truth), ssim(shown, truth))
