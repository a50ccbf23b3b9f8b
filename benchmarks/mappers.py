"""Public dataflow graphs with every shipped mapper: II, proved bound, status and seconds."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import vividc
from vividc.arch import Fabric
from vividc.dfg.ir import DFG
from vividc.errors import VividcError
from vividc.mapper import MapResult, all_bounds, map_dfg, mapper_names, mii
from vividc.mapper.problem import MapProblem

FOLDER_VARIABLE: Final = "VIVIDC_DFGS"
TITLE: Final = "Mappers on public dataflow graphs"
HEADER: Final = (
    "| graph | operations | mapper | II | bound | status | seconds | most memory MB |\n"
    "|---|---|---|---|---|---|---|---|"
)
NOTES: Final = (
    "The graphs are JSON files in the folder that VIVIDC_DFGS names, or in `../shared/dfgs`.",
    "Arrays below 64 PEs get all graphs, larger ones those with an operation for every fourth PE.",
    "Memory is the process's peak so far, solver threads included.",
    "",
    "What other mappers reach on graphs of this kind, as measured with them on a machine",
    "of two cores; compare only under a fabric that matches:",
    "",
    "- SAT-MapIt, its 4x4 array (`openedge-4x4`): sqrt (8 nodes) II 5, bitcount (6) 3, gsm (14) 4",
    "  in 4.7 s, stringsearch (15) 2 in 3.2 s, sha1 (25) 3 in 8.8 s, sha2 (25) 8 in 12 s.",
    "- Morpher with PathFinder, 4x4 HyCUBE (`hycube-4x4`): array_add (20) 4, atax (24) 4, 2mm (28)",
    "  4, bicg (31) 4, cholesky (26) 5; 16 of 21 graphs not mapped in 45 s.",
    "- a greedy mapper, 4x4 mesh, graphs of 12-72 nodes: 19 of 29 kernels end at II 4, 4 fail.",
)
_LARGE_ARRAY: Final = 64
_WORK: Final = 4


def folder() -> Path | None:
    """Where the graphs are, if they are."""
    named = os.environ.get(FOLDER_VARIABLE)
    found = Path(named) if named else Path(__file__).resolve().parents[2] / "shared" / "dfgs"
    return found if found.is_dir() and any(found.glob("*.json")) else None


def rows(fabric_name: str, time_limit_s: float) -> Iterator[str]:
    """One line for each graph and mapper, as it is measured."""
    place = folder()
    if place is None:
        yield f"No graphs: {FOLDER_VARIABLE} names no folder with JSON files."
        return
    fabric = vividc.arch.load(fabric_name)
    for path in sorted(place.glob("*.json")):
        try:
            graph = vividc.dfg.load(path)
        except VividcError as error:
            yield f"| {path.stem} | - | - | - | - | refused: {error.reason} | - | - |"
            continue
        if _gives_work(graph, fabric):
            for mapper in mapper_names():
                yield row(graph, path.stem, fabric, mapper, time_limit_s)


def row(graph: DFG, name: str, fabric: Fabric, mapper: str, time_limit_s: float) -> str:
    """One graph with one mapper."""
    start = f"| {name} | {len(graph.operations)} | {mapper}"
    try:
        result = map_dfg(graph, fabric, mapper, time_limit_s=time_limit_s)
    except VividcError as error:
        bound = mii(all_bounds(MapProblem(graph, fabric)))
        return f"{start} | - | {bound} | refused: {error.reason} | - | {_peak_mb()} |"
    return f"{start} | {_outcome(result)} | {_peak_mb()} |"


def _outcome(result: MapResult) -> str:
    ii = "-" if result.ii is None else result.ii
    return f"{ii} | {result.lower_bound} | {result.status} | {result.wall_s:.1f}"


def _gives_work(graph: DFG, fabric: Fabric) -> bool:
    pes = len(fabric.pes)
    return pes < _LARGE_ARRAY or _WORK * len(graph.operations) >= pes


def _peak_mb() -> str:
    """Most resident memory of this process so far; "-" where the system does not tell."""
    status = Path("/proc/self/status")
    if not status.exists():
        return "-"
    lines = status.read_text(encoding="ascii").splitlines()
    kilobytes = next((line.split()[1] for line in lines if line.startswith("VmHWM:")), None)
    return "-" if kilobytes is None else f"{int(kilobytes) / 1024:.0f}"
