"""`vividc map`: one dataflow graph onto a fabric."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import get_args

import click

from vividc import arch, dfg
from vividc.arch import Fabric
from vividc.cli import options
from vividc.cli.files import check_apart, check_output
from vividc.cli.reports.report import percent, plain, print_json, print_table
from vividc.cli.say import say
from vividc.dfg import DFG
from vividc.errors import MappingFailed, TimeLimit, printable
from vividc.host.files import write_whole
from vividc.host.plot import check_picture_path, encode
from vividc.host.progress import progress
from vividc.mapper import (
    OBJECTIVES,
    EffortLevel,
    MapInterrupted,
    MapResult,
    map_dfg,
    mapping_to_json,
    utilization,
)
from vividc.mapper.deadline import EFFORT_SHARE
from vividc.mapper.report.explain import binding, fullest

SCHEMA = "vividc.map/1"

_MOST_OF_THE_TIME = 0.8


@click.command("map")
@click.argument("graph", metavar="DFG", type=options.FILE)
@options.fabric
@options.mapper
@click.option("--ii", type=click.IntRange(min=1), metavar="N", help="Try this II only.")
@click.option(
    "--objective",
    type=click.Choice(tuple(OBJECTIVES)),
    help="Minimise this at the II found: registers used, links driven, or the schedule's length.",
)
@click.option(
    "--unknown-ops",
    type=click.Choice(get_args(dfg.UnknownOps)),
    default="generic",
    help="Operations that are not in the table: run them on any PE, with a warning, or refuse.",
)
@options.time_limit
@options.effort("prove")
@click.option(
    "-o", "--output", type=options.FILE, metavar="MAPPING.json", help="Write the mapping."
)
@click.option(
    "--plot",
    type=options.FILE,
    metavar="PICTURE",
    help="Draw the mapping: the array slot by slot (.svg or .png).",
)
@options.as_json
def command(
    graph: Path,
    fabric: str,
    mapper: str,
    ii: int | None,
    objective: str | None,
    unknown_ops: dfg.UnknownOps,
    time_limit_s: float,
    effort: EffortLevel,
    output: Path | None,
    plot: Path | None,
    as_json: bool,
) -> None:
    """Map a dataflow graph (JSON, DOT, Morpher XML or text form) and say what was proved.

    Exit code 3: proved infeasible. Exit code 4: no mapping within the time limit. Exit code 130:
    interrupted (Ctrl-C); the best mapping found so far is reported and written.
    """
    _check_outputs({"--output": output, "--plot": plot}, [graph, Path(fabric)])
    the_dfg = dfg.load(graph, unknown_ops=unknown_ops)
    the_fabric = arch.load_tile(fabric)
    stopped: MapInterrupted | None = None
    try:
        with progress(f"mapping {the_dfg.name}") as report:
            result = map_dfg(
                the_dfg,
                the_fabric,
                mapper,
                ii,
                time_limit_s,
                progress=report,
                effort=effort,
                objective=objective,
            )
    except MapInterrupted as stop:
        stopped, result = stop, stop.result
    document = mapping_to_json(result, the_dfg, the_fabric)
    _write(result, document, output)
    if as_json:
        shown = _as_object(result, the_dfg, the_fabric, document, output)
        print_json(SCHEMA, shown | {"interrupted": stopped is not None})
    else:
        _print(result, the_dfg, the_fabric, output)
    _draw(result, plot)  # last: a picture that cannot be made loses nothing else
    if plot is not None and result.mapping is not None and not as_json:
        say(f"written: {plot}")
    if stopped is not None:
        raise stopped
    _raise_unless_mapped(result, the_dfg, ii, time_limit_s)


def _write(result: MapResult, document: Mapping[str, object], output: Path | None) -> None:
    if result.mapping is not None and output is not None:
        text = json.dumps(plain(document), indent=1, allow_nan=False) + "\n"
        write_whole(output, text.encode())


def _draw(result: MapResult, plot: Path | None) -> None:
    if result.mapping is not None and plot is not None:
        write_whole(plot, encode(result.mapping.plot(), plot))


def _check_outputs(outputs: Mapping[str, Path | None], inputs: Sequence[Path]) -> None:
    """Refuse what cannot be written, or would replace an input, before anything is mapped."""
    wanted = {option: path for option, path in outputs.items() if path is not None}
    if "--plot" in wanted:
        check_picture_path(wanted["--plot"], "--plot")
    for option, path in wanted.items():
        check_output(path, option)
    check_apart(wanted, inputs)


def _as_object(
    result: MapResult,
    graph: DFG,
    fabric: Fabric,
    document: Mapping[str, object],
    output: Path | None,
) -> dict[str, object]:
    return {
        "dfg": graph.name,
        "fabric": fabric.name,
        "mapper": result.mapper,
        "operations": len(graph.operations),
        "pes": len(fabric.pes),
        "status": result.status,
        "ii": result.ii,
        "lower_bound": result.lower_bound,
        "bounds": [
            {"name": bound.name, "ii": bound.ii, "reason": bound.reason, "nodes": bound.nodes}
            for bound in result.bounds
        ],
        "binding": binding(result),
        "fullest": fullest(result),
        "refuted": [{"ii": item.ii, "by": item.by} for item in result.refuted],
        "objective": None if result.objective is None else asdict(result.objective),
        "utilization": _utilization(result, graph, fabric),
        "wall_s": result.wall_s,
        "stopped_by_clock": result.hurried,
        "mapping": document["mapping"],
        "output": None if result.mapping is None or output is None else str(output),
    }


def _utilization(result: MapResult, graph: DFG, fabric: Fabric) -> float | None:
    return None if result.mapping is None else utilization(graph, fabric, result.mapping)


def _print(result: MapResult, graph: DFG, fabric: Fabric, output: Path | None) -> None:
    used = _utilization(result, graph, fabric)
    use = None if used is None else percent(used)
    columns = ("operations", "PEs", "II", "lower bound", "status", "use", "seconds", "mapper")
    sizes = (len(graph.operations), len(fabric.pes))
    row = (*sizes, result.ii, result.lower_bound, result.claim, use)
    timed = (*row, f"{result.wall_s:.1f}", result.mapper)
    print_table(f"{graph.name} on {fabric.name}", columns, [timed])
    say(result.explain())
    if output is not None and result.mapping is not None:
        say(f"written: {output}")


def _raise_unless_mapped(
    result: MapResult, graph: DFG, ii: int | None, time_limit_s: float
) -> None:
    wanted = "" if ii is None else f" at II {ii}"
    if result.status == "infeasible":
        why = result.bounds[0].reason if result.bounds else "the search was exhausted"
        if result.refuted:
            why = f"refuted by {result.refuted[-1].by}"
        raise MappingFailed(f"proved infeasible{wanted}: {why}", loc=printable(graph.name))
    if result.status == "timeout":
        raise _nothing_found(result, graph, wanted, time_limit_s)


def _nothing_found(result: MapResult, graph: DFG, wanted: str, time_limit_s: float) -> TimeLimit:
    """In time, or before: many mappers have no more to try at some point."""
    loc, known = printable(graph.name), f"the II is at least {result.lower_bound}"
    effort_s = result.stats.get("effort_s", result.wall_s)
    enough_s = _MOST_OF_THE_TIME * EFFORT_SHARE * time_limit_s
    if not result.hurried and effort_s < enough_s:
        another = "" if result.mapper == "auto" else "another mapper (--mapper auto), or "
        hint = f"try {another}a fabric with more room (--fabric)"
        reason = f"mapper {result.mapper!r} gave up after {result.wall_s:.1f} s without a mapping"
        return TimeLimit(f"{reason}{wanted}; {known}", loc=loc, hint=hint)
    hint = "give more time (--time-limit), or a fabric with more room (--fabric)"
    return TimeLimit(f"no mapping{wanted} within the time limit; {known}", loc=loc, hint=hint)
