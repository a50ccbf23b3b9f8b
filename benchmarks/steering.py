"""What the sizes that steer the renderers are worth: frames of `mic` with each of them halved, and
doubled.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Final

from benchmarks.paper import SCENES
from vividc.paper.scenes import METHODS, MIC
from vividc.render import SceneError, read_scene
from vividc.render.array import ArrayFrame, ArrayOptions, render_array, steering

TITLE: Final = "Sizes that steer the renderers"
NOTES: Final = """\
`mic` at 800x800, lookahead culling, FP8, on `vivid`: cycles of a frame with one size halved or
doubled, over those with the sizes of `vividc/render/array/steering.py`, as predicted from a
twentieth of the blocks; of 3DGS whole frames. A launch has as much as it has room for at most, so
some sizes change nothing above or below a value.
""".splitlines()
HEADER: Final = "| method | size | is | halved | doubled | most of it |\n|---|---|---|---|---|---|"
_NERF: Final = ("LEAST_PARTS", "LAUNCH_SAMPLES", "LAUNCHES_OF_BLOCKS")
_SIZES: Final[dict[str, tuple[str, ...]]] = {
    "3dgs": (
        *("SORTED_CHUNK", "CHUNKS_A_TILE", "SHORTEST_CHUNK", "RUN_ENTRIES"),
        *("PARTS_OF_A_SHARE", "WORTH_CUTTING"),
    ),
    "kilonerf": (*_NERF, "GROUPED"),
    "instant-ngp": _NERF,
    "tensorf": (*_NERF, "SAMPLES_A_CELL"),
}
_SIDE: Final = 800
_SHARE: Final = 0.05
_ROOM: Final = "vividc.render.array."


def rows() -> Iterator[str]:
    """Yield the lines of the table, method by method."""
    for method in METHODS:
        _, scene = read_scene(SCENES.models()[MIC][method])
        camera, _ = SCENES.view(MIC, method, 0, _SIDE, scene)
        options = ArrayOptions(precision="fp8", sample=1.0 if method == "3dgs" else _SHARE)
        base = render_array(scene, camera, options)
        for name in _SIZES[method]:
            own = getattr(steering, name)
            cells, stages = [], dict[str, float]()
            for factor in (0.5, 2):
                with sized(name, scaled(own, factor)):
                    try:
                        other = render_array(scene, camera, options)
                    except SceneError:
                        cells.append("no room")
                        continue
                share = sum(other.predicted.values()) / sum(base.predicted.values())
                cells.append(f"{share:.3f}")
                stages |= _changes(base, other)
            most = max(stages, key=lambda stage: stages[stage], default="-")
            yield f"| {method} | {name} | {own} | {' | '.join(cells)} | {most} |"


def _changes(base: ArrayFrame, other: ArrayFrame) -> dict[str, float]:
    """By how many cycles stages differ."""
    changes = {
        name: abs(cycles - base.predicted.get(name, 0)) for name, cycles in other.predicted.items()
    }
    return {name: cycles for name, cycles in changes.items() if cycles}


def scaled(size: Any, factor: float) -> Any:
    """A size, or several, times a factor: whole numbers stay whole and at least 1, and shares below
    1.
    """
    if isinstance(size, tuple):
        return tuple(dict.fromkeys(scaled(one, factor) for one in size))
    if isinstance(size, float):
        return min(size * factor, 0.99)
    return max(int(size * factor), 1)


@contextmanager
def sized(name: str, size: object) -> Iterator[None]:
    """Give a size another value, in all modules that have it."""
    users = [m for n, m in sys.modules.items() if n.startswith(_ROOM) and hasattr(m, name)]
    own = getattr(steering, name)
    for module in users:
        setattr(module, name, size)
    try:
        yield
    finally:
        for module in users:
            setattr(module, name, own)
