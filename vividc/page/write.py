"""The page: data, style and code in one file that asks for nothing from anywhere."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Final

from vividc.errors import demand_type, printable
from vividc.host.files import write_whole
from vividc.page.regions import fabric_data, region_data
from vividc.page.runs import WINDOW, run_data
from vividc.page.source import Data, OwnLines, line_data, source_data
from vividc.program import Program

SCHEMA: Final = "vividc.view/1"
_CODE: Final = ("dagre.min.js", "marks.js", "graph.js", "array.js", "panes.js", "main.js")
"""In the order in which a browser runs them."""
_POLICY: Final = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'"
"""A browser that keeps it lets the page load nothing."""
_MARK: Final = re.compile("@([A-Z]+)@")


def view(
    program: Program,
    path: str | os.PathLike[str],
    args: Sequence[object] | Mapping[str, object] | None = None,
    *,
    cycles: tuple[int, int] = WINDOW,
    source: str | os.PathLike[str] | None = None,
) -> None:
    """Write a program, and a run of it, as one HTML page that works without a network.

    Parameters
    ----------
    path
        The file to write.
    args
        Arguments of a run, in order or by parameter name, as `vividc.simulate` takes them; they
        are left as they are. None: the page shows no run.
    cycles
        First cycle of the window that is recorded, and the one after the last.
    source
        The kernel's source, if it is not the file that was compiled or was changed since.

    Raises
    ------
    VividcError
        The program keeps no graphs and mappings, the arguments do not fit, the window is too long
        or after the run's end, or a file cannot be read or written.
    """
    demand_type(program, Program, "the program", "compile a kernel, or vividc.load a .vivid file")
    demand_type(path, (str, os.PathLike), "the file", "give a path, as 'saxpy.html'")
    given = None if source is None else Path(source)
    text = page(program, args, cycles=cycles, source=given)
    write_whole(Path(path), text.encode())


def page(
    program: Program,
    args: Sequence[object] | Mapping[str, object] | None = None,
    *,
    cycles: tuple[int, int] = WINDOW,
    source: Path | None = None,
    folder: Path | None = None,
) -> str:
    """Return the page as text; see `view`.

    `folder`: where the program's own file lies; its source may lie beside it.
    """
    data = page_data(program, args, cycles=cycles, source=source, folder=folder)
    parts = {
        "POLICY": escape(_POLICY),
        "TITLE": escape(printable(f"{program.name} on {program.fabric.name}")),
        "STYLE": _asset("page.css"),
        "DATA": as_script(data),
        "LICENCE": _asset("dagre.LICENSE.txt"),
        "CODE": "\n".join(_asset(name) for name in _CODE),
    }
    return _MARK.sub(lambda found: parts[found[1]], _asset("page.html"))


def page_data(
    program: Program,
    args: Sequence[object] | Mapping[str, object] | None,
    *,
    cycles: tuple[int, int] = WINDOW,
    source: Path | None = None,
    folder: Path | None = None,
) -> Data:
    """Return what the page shows; see `page`."""
    text = source_data(program, folder, source)  # before the run, which may take long
    own = OwnLines(program)
    run = None
    if isinstance(args, Mapping):
        run = run_data(program, (), args, cycles)
    elif args is not None:
        run = run_data(program, args, {}, cycles)
    return {
        "schema": SCHEMA,
        "name": printable(program.name),
        "summary": repr(program)[1:-1],
        "fabric": fabric_data(program.fabric),
        "regions": [region_data(program, index, own) for index in range(len(program.regions))],
        "source": text,
        "lines": line_data(program, own, _cycles_of(run)),
        "warnings": list(program.warnings),
        "nests": len(program.nests),
        "run": run,
    }


def _cycles_of(run: Data | None) -> list[int] | None:
    """Cycles of the run in each region; None: there is no run, or it did not end."""
    if run is None or run["cycles"] is None:
        return None
    regions = run["regions"]
    assert isinstance(regions, list)
    return [region["cycles"] for region in regions]


def as_script(data: object) -> str:
    """Return JSON that may stand in a script element: nothing in it ends one."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")


def _asset(name: str) -> str:
    return files("vividc.page").joinpath("assets", name).read_text(encoding="utf-8")
