"""The source of a program, where it is at hand and unchanged, and how hot its lines are."""

from __future__ import annotations

import hashlib
import os
import re
from collections import Counter, defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from vividc.errors import SourceLoc, VividcError, printable
from vividc.host.inputs import SOURCE_BYTES, read_text
from vividc.program import Program

Data = dict[str, object]

_LINE_END: Final = re.compile(r"\r\n?|\n")
_NO_FILE: Final = "the program records no source file"


def source_data(program: Program, folder: Path | None, given: Path | None) -> Data:
    """Return the kernel's file as lines, or why it is not shown.

    A program names its source by path and SHA-256, and may be from anyone: a file counts only if it
    has that hash, so the page shows nothing that whoever made the program had not seen.

    Parameters
    ----------
    folder
        Where the program's own file lies: the source may lie beside it.
    given
        The file that the user names as the source, whatever its content.

    Raises
    ------
    VividcError
        The file that the user names cannot be read.
    """
    recorded = program.provenance.kernel_file
    if given is not None:
        return _shown(recorded or str(given), read_text(given, SOURCE_BYTES))
    if not recorded:
        return _missing("", _NO_FILE)
    places = [Path(recorded)]
    if folder is not None:
        places += [folder / recorded, folder / Path(recorded).name]
    there = [place for place in places if os.path.isfile(place)]
    for place in there:
        try:
            text = read_text(place, SOURCE_BYTES)
        except VividcError:
            continue
        if hashlib.sha256(text.encode()).hexdigest() == program.provenance.kernel_sha256:
            return _shown(recorded, text)
    name = printable(Path(recorded).name)
    return _missing(
        recorded, f"{name} {'was changed since it was compiled' if there else 'was not found'}"
    )


def _shown(file: str, text: str) -> Data:
    return {"file": Path(file).name, "lines": _LINE_END.split(text), "missing": ""}


def _missing(file: str, reason: str) -> Data:
    return {"file": Path(file).name if file else "", "lines": [], "missing": reason}


class OwnLines:
    """Which places are lines of the kernel's own file, which the page shows.

    Places in a program are relative to the folder where it was compiled, if the file was below.
    """

    def __init__(self, program: Program) -> None:
        recorded = program.provenance.kernel_file
        files = {
            node.loc.file
            for region in program.regions
            for node in region.dfg.nodes
            if node.loc is not None
        }
        ends = [file for file in files if f"/{recorded}".endswith(f"/{file}")]
        self._file = max(ends, key=len, default=recorded)
        name = re.escape(self._file)
        self._places = re.compile(rf"(?<=\(){name}:(\d+)(?=\))") if name else None

    def line(self, loc: SourceLoc | None) -> int | None:
        """The line; None: it is elsewhere."""
        return loc.line if loc is not None and loc.file == self._file else None

    def of(self, text: str) -> str:
        """A message with lines in place of paths, which tell where the author's files lie."""
        return text if self._places is None else self._places.sub(r"line \1", text)


def line_data(program: Program, own: OwnLines, cycles: Sequence[int] | None) -> list[Data]:
    """Return how hot each line is.

    With a run, `cycles` of it in each region are shared among the lines by their operations;
    without, a line's heat is the number of its operations in loops.
    """
    heat: dict[int, float] = defaultdict(float)
    counts: dict[int, dict[int, int]] = defaultdict(dict)
    for index, region in enumerate(program.regions):
        found = (own.line(node.loc) for node in region.dfg.placed)
        lines = Counter(line for line in found if line is not None)
        weight = region.kind == "loop" if cycles is None else cycles[index]
        for line, count in lines.items():
            counts[line][index] = count
            heat[line] += weight * (count if cycles is None else count / lines.total())
    return [
        {"line": line, "heat": round(heat[line], 2), "operations": counts[line]}
        for line in sorted(counts)
    ]
