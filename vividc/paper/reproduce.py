"""Measures what the exhibits need, and writes the report."""

from __future__ import annotations

import json
import platform
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Final

from vividc.errors import VividcError, demand_callable, demand_type
from vividc.host.files import write_whole
from vividc.host.plot import to_svg
from vividc.paper import machine, rendered
from vividc.paper.exhibit import Exhibit
from vividc.paper.frames import Key, Measure, Rows, measured
from vividc.paper.page import page
from vividc.paper.rendered import Frames
from vividc.paper.scenes import CHECKOUT, Scenes
from vividc.program.kept import COMPILER, source_digest
from vividc.render.array.device.programs import kernel_folder

SCHEMA: Final = "vividc.reproduce/1"
ROWS: Final = "frames.jsonl"
PAGE: Final = "index.html"
DATA: Final = "report.json"
_ROOMS: Final = (*COMPILER, "launch", "sim", "render", "paper")
_PACKAGES: Final = ("vividc", "numba", "llvmlite", "ortools", "numpy")
_SECONDS: Final = {"3dgs": 5.0, "kilonerf": 7.0, "instant-ngp": 18.0, "tensorf": 42.0}
"""About what a frame takes two cores: 800x800, a twentieth of a NeRF's blocks, FP8 or FP32."""
_SCALE: Final = 0.05 * 800 * 800


@dataclass(frozen=True, slots=True)
class Recipe:
    """How an exhibit is made: of frames, or of something else, which takes some seconds."""

    keys: Callable[[Frames], list[Key]]
    build: Callable[[Frames, Rows], Exhibit]
    seconds: float = 0.0


def _no_frames(build: Callable[[Scenes], Exhibit], seconds: float) -> Recipe:
    return Recipe(lambda _: [], lambda frames, _: build(frames.scenes), seconds)


_RECIPES: Final = {
    "fig1b": Recipe(rendered.figure_1b_keys, rendered.figure_1b),
    "table2": Recipe(rendered.table_2_keys, rendered.table_2),
    "eq45": _no_frames(machine.equations, 2),
    "fig6": _no_frames(machine.figure_6, 1),
    "fig7ab": Recipe(rendered.figure_7_keys, rendered.figure_7),
    "fig7c": Recipe(rendered.figure_7c_keys, rendered.figure_7c),
    "weights": Recipe(rendered.weights_keys, rendered.weights),
    "table3": Recipe(rendered.table_3_keys, rendered.table_3),
    "fig8a": _no_frames(machine.figure_8a, 2),
    "fig8b": _no_frames(machine.figure_8b, 90),
}
EXHIBITS: Final = tuple(_RECIPES)
"""Names, in the paper's order."""


@dataclass(frozen=True, slots=True)
class Report:
    """What was written.

    Attributes
    ----------
    page
        The HTML file; beside it the data, the rows of frames and the pictures.
    measured, kept
        Frames that were rendered, and that a run before had rendered.
    """

    exhibits: tuple[Exhibit, ...]
    page: Path
    measured: int
    kept: int


def reproduce(
    output: Path | str,
    *,
    only: Sequence[str] = (),
    quick: bool = False,
    scenes: Sequence[Path | str] = (),
    tell: Callable[[str], None] | None = None,
    measure: Measure | None = None,
) -> Report:
    """Measure the paper's tables and figures, and write them beside the paper's figures.

    Frames are kept in the folder: what was interrupted goes on where it stopped. Rows of other code
    than this one are measured again.

    Parameters
    ----------
    output
        Folder; it is made.
    only
        Names of `EXHIBITS`; empty: all.
    quick
        Pictures of 200x200, of which a twentieth is simulated, in place of 800x800.
    scenes
        Folders with scenes, the first first; behind them comes that of the checkout.
    tell
        Called with a line before it starts, and after each frame.
    measure
        In place of a process that renders a frame.

    Raises
    ------
    VividcError
        An exhibit is unknown, scenes are missing, or the folder cannot be written.
    """
    folder = Path(output)
    demand_type(quick, bool, "quick", "give True or False")
    demand_callable(tell, "tell")
    chosen = {name: _RECIPES[name] for name in EXHIBITS if name in _known(only)}
    frames = _frames(Scenes((*map(Path, scenes), CHECKOUT)), quick)
    frames.scenes.models()  # before anything is measured
    keys = list(dict.fromkeys(key for recipe in chosen.values() for key in recipe.keys(frames)))
    _make(folder)
    rows, done = _rows(keys, frames.scenes, folder, tell, measure, chosen)
    exhibits = tuple(recipe.build(frames, rows) for recipe in chosen.values())
    _write(folder, exhibits)
    return Report(exhibits, folder / PAGE, done, len(keys) - done)


def _known(only: Sequence[str]) -> Sequence[str]:
    for name in only:
        if name not in EXHIBITS:
            raise VividcError(
                f"there is no exhibit {name!r}", loc="--only", hint=f"one of {', '.join(EXHIBITS)}"
            )
    return only or EXHIBITS


def _frames(scenes: Scenes, quick: bool) -> Frames:
    if quick:
        return Frames(scenes, side=200, quality_side=200, quality_sample=0.05)
    return Frames(scenes)


def _rows(
    keys: Sequence[Key],
    scenes: Scenes,
    folder: Path,
    tell: Callable[[str], None] | None,
    measure: Measure | None,
    chosen: dict[str, Recipe],
) -> tuple[Rows, int]:
    """Return the rows of all frames, and how many were rendered."""
    say = tell or (lambda _: None)
    made_by = _made_by()
    kept = next(iter(measured([], scenes, folder / ROWS, made_by)))
    left = [key for key in keys if key not in kept]
    seconds = sum(map(_seconds, left)) + sum(recipe.seconds for recipe in chosen.values())
    say(f"{len(left)} of {len(keys)} frames to render: about {_time(seconds)}, kernels compiled")
    rows: Rows = kept
    for number, rows in enumerate(measured(keys, scenes, folder / ROWS, made_by, measure)):
        if number < len(left):
            key = left[number]
            row = rows[key]
            what = f"{row.frames_per_second:.1f} frames/s" if row.frames_per_second else row.status
            say(f"{number + 1}/{len(left)} {key.scene} {key.method} {key.size}x{key.size}: {what}")
    return rows, len(left)


def _seconds(key: Key) -> float:
    """About what a frame takes."""
    return _SECONDS[key.method] * max(key.sample * key.size**2 / _SCALE, 0.2)


def _time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} minutes"  # noqa: PLR2004


def _made_by() -> str:
    """A hash of all code that a frame depends on."""
    digest = sha256(source_digest(*_ROOMS).encode())
    for file in sorted(kernel_folder().rglob("*.py")):
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise VividcError(f"cannot be made: {fault.strerror}", loc=str(folder)) from fault


def _write(folder: Path, exhibits: Sequence[Exhibit]) -> None:
    for exhibit in exhibits:
        for name, picture in exhibit.pictures.items():
            write_whole(folder / f"{exhibit.name}-{name}.svg", to_svg(picture).encode())
    body = json.dumps({"schema": SCHEMA, **data(exhibits)}, indent=1)
    write_whole(folder / DATA, body.encode())
    write_whole(folder / PAGE, page(exhibits, list(_made_with())).encode())


def data(exhibits: Sequence[Exhibit]) -> dict[str, object]:
    """Return the figures as JSON has them: without pictures."""
    shown = []
    for exhibit in exhibits:
        lines = [asdict(line) for line in exhibit.lines]
        tables = [asdict(table) for table in exhibit.tables]
        shown.append(
            {
                "name": exhibit.name,
                "title": exhibit.title,
                "lines": lines,
                "tables": tables,
                "assumptions": list(exhibit.assumptions),
            }
        )
    return {"exhibits": shown, "made_with": dict(_made_with())}


def _made_with() -> Iterator[tuple[str, str]]:
    yield "machine", f"{platform.machine()}, Python {platform.python_version()}"
    yield "accelerator", "vivid: 16 tiles of 4x4 PEs at 1 GHz"
    for name in _PACKAGES:
        yield name, version(name)
    yield "source", _made_by()
