"""Public dataflow graphs with every shipped mapper: II, proved bound, status, seconds and memory.

Each row is measured in a process of its own and kept in a file of rows: a run that was broken off
goes on where it stopped, and the table is written anew after each row.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import statistics
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Final

import vividc
from benchmarks import PATIENCE
from vividc.arch import Fabric
from vividc.dfg.ir import DFG
from vividc.errors import InternalError, VividcError
from vividc.mapper import MapResult, all_bounds, map_dfg, mapper_names, mii
from vividc.mapper.engines.negotiate import prepare
from vividc.mapper.problem import MapProblem

FOLDER_VARIABLE: Final = "VIVIDC_DFGS"
ROWS: Final = "mappers.jsonl"
TITLE: Final = "Mappers on public dataflow graphs"
HEADER: Final = (
    "| graph | operations | mapper | limit s | II | bound | status | II found after s | seconds "
    "| most MB | others |\n"
    "|---|---|---|---|---|---|---|---|---|---|---|"
)
NOTES: Final = (
    "The graphs are JSON files in the folder that VIVIDC_DFGS names, or in `../shared/dfgs`.",
    "Arrays below 64 PEs get all graphs, larger ones those with an operation for every fourth PE.",
    "Each row has a process of its own; memory is its peak, the solver's threads included. Rows",
    f"are kept in `{ROWS}`, whatever fabrics, mappers and time limits they were measured with: all",
    "are in the table, and what is there is not measured again. `load`: processes that the machine",
    "ran on average in the minute before a row began, others' and the row's before.",
    "",
    "Others: what other mappers reach on the same graph, as measured with them on a machine of two",
    "cores: Morpher with PathFinder on its 4x4 HyCUBE, in 45 s at most. Of graphs that are not",
    "here, SAT-MapIt on its 4x4 array (`openedge-4x4`): sqrt (8 nodes) II 5, bitcount (6) 3, gsm",
    "(14) 4 in 4.7 s, stringsearch (15) 2 in 3.2 s, sha1 (25) 3 in 8.8 s, sha2 (25) 8 in 12 s; a",
    "greedy mapper on a 4x4 mesh, graphs of 12-72 nodes: 19 of 29 kernels end at II 4, 4 fail.",
)
_PEERS: Final = {
    ("hycube-4x4", "morpher__array_add-array_add_LN1"): "4",
    ("hycube-4x4", "morpher__polybench-2mm"): "4",
    ("hycube-4x4", "morpher__polybench-atax"): "4",
    ("hycube-4x4", "morpher__polybench-cholesky"): "5",
    ("hycube-4x4", "morpher__polybench-2mm_unroll4"): "none",
    ("hycube-4x4", "morpher__polybench-bicg_unroll3"): "none",
    ("hycube-4x4", "morpher__polybench-cholesky_unroll4"): "none",
    ("hycube-4x4", "morpher__polybench-doitgen_unroll4"): "none",
    ("hycube-4x4", "morpher__pedometer-pedometer_LN1"): "none",
}
_LARGE_ARRAY: Final = 64
_WORK: Final = 4
_SMALL: Final = 60
"""Operations up to which the summary looks at gaps: the size that targets are set for."""

_BUSY: Final = 1.25
"""Load by core from which on the table says that seconds are longer."""

_GRACE_S: Final = 60.0
"""Seconds beyond its limit after which a mapper's process is ended."""


@dataclass(frozen=True, slots=True)
class Row:
    """One graph with one mapper on one fabric; what is None was not found, or not measured.

    `found_s`: seconds after which the final II was found; `seconds`: of the whole run; `most_mb`:
    peak of resident memory; `load`: of the machine when the row began; `hurried`: the clock ended
    it.
    """

    fabric: str
    graph: str
    operations: int
    mapper: str
    time_limit_s: float
    bound: int
    status: str
    ii: int | None = None
    found_s: float | None = None
    seconds: float | None = None
    most_mb: float | None = None
    load: float | None = None
    hurried: bool = False

    @property
    def gap(self) -> int | None:
        """How far the II is from its bound."""
        return None if self.ii is None else self.ii - self.bound

    def __str__(self) -> str:
        cells = [
            self.graph,
            str(self.operations),
            self.mapper,
            f"{self.time_limit_s:g}",
            _shown(self.ii),
            str(self.bound),
            f"{self.status}, stopped by the clock" if self.hurried else self.status,
            _shown(self.found_s, ".1f"),
            _shown(self.seconds, ".1f"),
            _shown(self.most_mb, ".0f"),
            _PEERS.get((self.fabric, self.graph), "-"),
        ]
        return f"| {' | '.join(cells)} |"


def folder() -> Path | None:
    """Where the graphs are, if they are."""
    named = os.environ.get(FOLDER_VARIABLE)
    found = Path(named) if named else Path(__file__).resolve().parents[2] / "shared" / "dfgs"
    return found if found.is_dir() and any(found.glob("*.json")) else None


def sections(
    fabrics: Sequence[str], mappers: Sequence[str], time_limit_s: float, output: Path | None
) -> Iterator[list[str]]:
    """The table's lines, one section a fabric, again after each row: what is finished so far, with
    all rows that are kept.

    Parameters
    ----------
    fabrics
        Names of presets, or files.
    mappers
        Names of mappers; none: all.
    time_limit_s
        Limit of each row.
    output
        Folder of the file of rows; None: rows are neither read nor kept.
    """
    place = folder()
    if place is None:
        yield [f"No graphs: {FOLDER_VARIABLE} names no folder with JSON files."]
        return
    kept = None if output is None else output / ROWS
    rows = _read(kept)
    prepare()
    for fabric in fabrics:
        for graph, name, mapper in _tasks(place, fabric, mappers or mapper_names()):
            key = (fabric, name, mapper, time_limit_s)
            if key not in rows:
                rows[key] = measured(graph, name, fabric, mapper, time_limit_s)
                _keep(kept, rows[key])
                print(rows[key], file=sys.stderr)
                yield _lines(list(rows.values()))
    yield _lines(list(rows.values()))


def measured(graph: DFG, name: str, fabric: str, mapper: str, time_limit_s: float) -> Row:
    """One row, from a process of its own."""
    about = Row(fabric, name, len(graph.operations), mapper, time_limit_s, 1, "died")
    about = replace(about, load=round(os.getloadavg()[0], 1))
    context = multiprocessing.get_context("fork")
    ours, theirs = context.Pipe(duplex=False)
    child = context.Process(target=_measure, args=(theirs, about, graph))
    child.start()
    theirs.close()
    row = about
    if ours.poll(PATIENCE * time_limit_s + _GRACE_S):
        try:
            row = ours.recv()
        except EOFError:
            row = replace(about, status="died")
    else:
        row = replace(about, status="does not stop")
        child.kill()
    child.join()
    return row


def _measure(pipe: Connection, about: Row, graph: DFG) -> None:
    fabric = vividc.arch.load(about.fabric)
    try:
        with vividc.patient(PATIENCE):
            result = map_dfg(graph, fabric, about.mapper, time_limit_s=about.time_limit_s)
        row = _row_of(about, result)
    except VividcError as error:
        bound = mii(all_bounds(MapProblem(graph, fabric)))
        row = replace(about, bound=bound, status=f"refused: {error.reason}")
    except InternalError as error:
        row = replace(about, status=f"internal error: {error}")
    pipe.send(replace(row, most_mb=_peak_mb()))


def _row_of(about: Row, result: MapResult) -> Row:
    found_s = result.stats.get("found_s", result.wall_s)
    return replace(
        about,
        ii=result.ii,
        bound=result.lower_bound,
        status=result.status,
        found_s=None if result.ii is None else round(found_s, 2),
        seconds=round(result.wall_s, 2),
        hurried=result.hurried,
    )


def _peak_mb() -> float | None:
    """Most resident memory of this process; None where the system does not tell."""
    status = Path("/proc/self/status")
    if not status.exists():
        return None
    lines = status.read_text(encoding="ascii").splitlines()
    kilobytes = next((line.split()[1] for line in lines if line.startswith("VmHWM:")), None)
    return None if kilobytes is None else round(int(kilobytes) / 1024)


def _tasks(place: Path, fabric: str, mappers: Sequence[str]) -> Iterator[tuple[DFG, str, str]]:
    array = vividc.arch.load(fabric)
    for path in sorted(place.glob("*.json")):
        graph = vividc.dfg.load(path)
        if _gives_work(graph, array):
            yield from ((graph, path.stem, mapper) for mapper in mappers)


def _gives_work(graph: DFG, fabric: Fabric) -> bool:
    pes = len(fabric.pes)
    return pes < _LARGE_ARRAY or _WORK * len(graph.operations) >= pes


def _read(kept: Path | None) -> dict[tuple[str, str, str, float], Row]:
    """Rows that were measured before, by fabric, graph, mapper and time limit."""
    if kept is None or not kept.exists():
        return {}
    lines = kept.read_text(encoding="utf-8").splitlines()
    rows = [Row(**json.loads(line)) for line in lines]
    return {(r.fabric, r.graph, r.mapper, r.time_limit_s): r for r in rows}


def _keep(kept: Path | None, row: Row) -> None:
    if kept is not None:
        with kept.open("a", encoding="utf-8") as file:
            file.write(json.dumps(asdict(row)) + "\n")


def _lines(rows: Sequence[Row]) -> list[str]:
    found: list[str] = []
    for fabric in dict.fromkeys(row.fabric for row in rows):
        here = [row for row in rows if row.fabric == fabric]
        found += [f"## {fabric}", "", *_load(here), *_summary(here), "", *HEADER.splitlines()]
        found += [*(str(row) for row in here), ""]
    return found


def _load(rows: Sequence[Row]) -> Iterator[str]:
    """What the machine had to do while the rows were measured, where that is known."""
    loads = [row.load for row in rows if row.load is not None]
    cores = os.cpu_count()
    if not loads or cores is None:
        return
    mean = statistics.mean(loads)
    most = max(loads)
    yield f"Load of the {cores} cores when rows began: {mean:.1f} on average, {most:.1f} at most."
    if mean > _BUSY * cores:
        yield f"Seconds are about {mean / cores:.1f} times those of an idle machine, and limits"
        yield "are as much shorter."
    yield ""


def _summary(rows: Sequence[Row]) -> Iterator[str]:
    """Per mapper: how many graphs are mapped, proved, and near their bound, how fast, how large."""
    yield (
        "| mapper | limit s | graphs | mapped | optimal | gap at most 1 | median s to the II "
        f"| up to {_SMALL} operations: optimal | gap at most 1 | median s to the II "
        "| median s | most MB | load |"
    )
    yield "|---|---|---|---|---|---|---|---|---|---|---|---|---|"
    for mapper, limit in dict.fromkeys((row.mapper, row.time_limit_s) for row in rows):
        mine = [row for row in rows if (row.mapper, row.time_limit_s) == (mapper, limit)]
        small = [row for row in mine if row.operations <= _SMALL]
        cells = [
            mapper,
            f"{limit:g}",
            str(len(mine)),
            str(sum(row.ii is not None for row in mine)),
            *_proved(mine),
            _median([row.found_s for row in mine]),
            *(f"{count} of {len(small)}" for count in _proved(small)),
            _median([row.found_s for row in small]),
            _median([row.seconds for row in mine]),
            _shown(max((row.most_mb for row in mine if row.most_mb), default=None), ".0f"),
            _median([row.load for row in mine]),
        ]
        yield f"| {' | '.join(cells)} |"


def _proved(rows: Sequence[Row]) -> tuple[str, str]:
    gaps = [row.gap for row in rows if row.gap is not None]
    return str(sum(gap == 0 for gap in gaps)), str(sum(gap <= 1 for gap in gaps))


def _median(values: Sequence[float | None]) -> str:
    known = [value for value in values if value is not None]
    return f"{statistics.median(known):.1f}" if known else "-"


def _shown(value: float | None, form: str = "") -> str:
    return "-" if value is None else format(value, form)
