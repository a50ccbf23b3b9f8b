"""The quality table: the float32 references of the four methods against held-out photographs.

The photographs are not in the repository: they are looked for beside the checkout, in
`../shared/scenes`. Without them the scenes of `scenes/mic` are compared with their reference
renders alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import mean
from typing import Final

import numpy as np
import numpy.typing as npt

from vividc.paper.scenes import MODELS, compare
from vividc.render import (
    Camera,
    Picture,
    ReferenceOptions,
    Scene,
    View,
    orbit_camera,
    psnr,
    read_scene,
    read_views,
    render_reference,
)
from vividc.render.array import ArrayOptions, render_array

TITLE = "Quality of the float32 references"
NOTES = (
    "PSNR and SSIM are of the clipped picture over white; mean (least to greatest) over the views.",
    "`render` is the independent float64 render that came with the model. Work is of all views:",
    "of Gaussians, exps that Lookahead Culling II takes, and avoids; of the others, colour",
    "samples that Lookahead Culling I takes, and avoids. `same`: without lookahead, the first view",
    "is the same to the last bit.",
    "The last table leaves out colours of little weight: dB lost against the same photographs in",
    "float32 on the host; and in FP8 on the array, against three of those of 200x200, what FP8",
    "loses included. The paper loses 0.20, 0.13 and 0.38 dB.",
)
HEADER = (
    "| scene | method | against | size | views | PSNR dB | SSIM | taken | avoided | same "
    "| s a view |\n|---|---|---|---|---|---|---|---|---|---|---|"
)
_ROOT = Path(__file__).resolve().parents[1]
_MIC = _ROOT / "scenes" / "mic"
SHARED = _ROOT.parent / "shared" / "scenes"
_TRUTHS = ("mic_200.npz", "mic_400.npz")
WEIGHTS: Final[Mapping[str, tuple[float, ...]]] = {
    "kilonerf": (3e-3, 5e-3, 1e-2),
    "instant-ngp": (3e-3, 7.5e-3),
    "tensorf": (3e-3, 7e-3, 7.5e-3, 9e-3),
}
"""Of what is left out. The paper loses 0.20, 0.13 and 0.38 dB to culling and FP8 together: the last
ones lose less in float32 over all photographs; 0.003, of TensoRF 0.0075, with FP8 on three views.
"""
_ON_ARRAY: Final = 3
"""Views."""
_WITHOUT = ReferenceOptions(lookahead=False)
_ORBIT = (30.0, 20.0, "-y", 400, 400)


def rows() -> Iterator[str]:
    """Yield the lines of the table, as they are measured."""
    for model, renders in MODELS.items():
        method, scene = read_scene(_MIC / model)
        yield _row("mic", method, "render", scene, read_views(_MIC / renders))
        for truth in _TRUTHS:
            if (SHARED / "mic" / truth).is_file():
                views = read_views(SHARED / "mic" / truth)
                yield _row("mic", method, "photographs", scene, views)
    for file in sorted((SHARED / "playbot").glob("*.npz")):
        method, scene = read_scene(file)
        yield _lookahead_row(file.stem, method, scene, orbit_camera(scene, *_ORBIT))
    if not SHARED.is_dir():
        yield f"\nNo photographs: `../{SHARED.relative_to(_ROOT.parent)}` is not there."
    elif all((SHARED / "mic" / truth).is_file() for truth in _TRUTHS):
        yield from _losses()


def _losses() -> Iterator[str]:
    """Yield the lines of a table: what leaving out colours of little weight loses."""
    sides = [read_views(SHARED / "mic" / truth) for truth in _TRUTHS]
    yield ""
    yield "| method | `--weight-min` | colour samples | 200x200 | 400x400 | all views | in FP8 |"
    yield "|---|---|---|---|---|---|---|"
    for model in MODELS:
        method, scene = read_scene(_MIC / model)
        if method not in WEIGHTS:
            continue
        whole = [_seen(scene, views, 0.0) for views in sides]
        some = sides[0][:: -(-len(sides[0]) // _ON_ARRAY)]
        exact = _seen(scene, some, 0.0)[0]
        for least in (0.0, *WEIGHTS[method]):
            fewer = [_seen(scene, views, least) for views in sides]
            lost = [whole[side][0] - fewer[side][0] for side in range(len(sides))]
            samples = sum(found[1] for found in fewer) / sum(found[1] for found in whole)
            narrow = exact - _seen_in_fp8(scene, some, least)
            parts = (*lost, np.concatenate(lost), narrow)
            means = (f"{round(mean(part), 2) + 0.0:.2f}" for part in parts)
            yield f"| {method} | {least:g} | {samples - 1:.0%} | {' | '.join(means)} |"


def _seen(scene: Scene, views: Sequence[View], least: float) -> tuple[npt.NDArray[np.float64], int]:
    """PSNR of each view against its photograph, and colour samples of all."""
    quality, samples = [], 0
    for view in views:
        truth = view.truth()
        assert truth is not None
        picture = render_reference(scene, view.camera, ReferenceOptions(weight_min=least))
        quality.append(psnr(np.clip(picture.image, 0, 1), np.clip(truth, 0, 1)))
        samples += int(picture.counts["colour_samples"])
    return np.array(quality), samples


def _seen_in_fp8(scene: Scene, views: Sequence[View], least: float) -> npt.NDArray[np.float64]:
    """PSNR of each view of the array against its photograph."""
    quality = []
    for view in views:
        truth = view.truth()
        assert truth is not None
        options = ArrayOptions(precision="fp8", weight_min=least)
        image = render_array(scene, view.camera, options).image
        quality.append(psnr(np.clip(image, 0, 1), np.clip(truth, 0, 1)))
    return np.array(quality)


def _row(name: str, method: str, against: str, scene: Scene, views: Sequence[View]) -> str:
    results = list(compare(scene, views))
    camera = views[0].camera
    quality = [result.psnr_db for result in results]
    cells = (
        *(name, method, against, f"{camera.width}x{camera.height}", len(results)),
        f"{mean(quality):.2f} ({min(quality):.2f} to {max(quality):.2f})",
        f"{mean(result.ssim for result in results):.4f}",
        *_work([result.picture for result in results]),
        _same(scene, camera, results[0].picture),
        f"{mean(result.picture.seconds for result in results):.1f}",
    )
    return f"| {' | '.join(map(str, cells))} |"


def _lookahead_row(name: str, method: str, scene: Scene, camera: Camera) -> str:
    """Return a row of a scene without photographs."""
    picture = render_reference(scene, camera)
    cells = (
        *(name, method, "-", f"{camera.width}x{camera.height}", 1, "-", "-", *_work([picture])),
        *(_same(scene, camera, picture), f"{picture.seconds:.1f}"),
    )
    return f"| {' | '.join(map(str, cells))} |"


def _same(scene: Scene, camera: Camera, picture: Picture) -> str:
    without = render_reference(scene, camera, _WITHOUT)
    return "yes" if np.array_equal(without.image, picture.image) else "NO"


def _work(pictures: Sequence[Picture]) -> tuple[str, str]:
    """Return how much was computed, and the share that was avoided."""
    counts = [picture.counts for picture in pictures]
    pair = ("exponentials", "evaluated")
    if pair[0] not in counts[0]:
        pair = ("colour_samples", "density_samples")
    taken, all_of_them = (sum(count[name] for count in counts) for name in pair)
    return f"{taken:,}", f"{1 - taken / all_of_them:.1%}"
