"""`vividc verify`: the certificate of a mapping file, checked without a solver."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import click

from vividc import arch, dfg
from vividc.cli import completion, options
from vividc.cli.reports.report import print_json
from vividc.cli.say import say
from vividc.errors import VividcError, printable, quoted
from vividc.host.inputs import GRAPH_BYTES, demand_few_values, read_text
from vividc.mapper import (
    Finding,
    MapResult,
    Subject,
    check_certificate,
    mapping_from_json,
    read_result,
)

SCHEMA: Final = "vividc.verify/1"
MISMATCH: Final = 5


@click.command("verify")
@click.argument("mapping", metavar="MAPPING.json", type=options.FILE)
@click.option(
    "--dfg", "graph", type=options.FILE, metavar="DFG", help="Check against this graph instead."
)
@click.option(
    "--fabric",
    metavar="F",
    help="Check against this fabric instead.",
    shell_complete=completion.fabric,
)
@options.as_json
def command(mapping: Path, graph: Path | None, fabric: str | None, as_json: bool) -> None:
    """Check a file that `vividc map -o` wrote: mapping, bounds and what they prove.

    Graph and fabric are those in the file, unless given. Nothing is solved: what a solver
    refuted is listed as taken on trust. Exit code 5: something in the file is wrong.
    """
    result = _read_named(mapping, graph, fabric)
    assert result.subject is not None
    findings = check_certificate(result, result.subject)
    wrong = any(finding.verdict == "wrong" for finding in findings)
    if as_json:
        print_json(SCHEMA, _as_object(result, findings, wrong=wrong))
    else:
        _print(result, findings, wrong=wrong)
    if wrong:
        raise click.exceptions.Exit(MISMATCH)


def _read_named(mapping: Path, graph: Path | None, fabric: str | None) -> MapResult:
    """As `_read`, with the file's name in errors."""
    try:
        return _read(mapping, graph, fabric)
    except VividcError as error:
        head, colon, place = str(error.loc).partition(": ")
        if head != "mapping file" or not colon:
            raise
        raise VividcError(error.reason, loc=f"{mapping}: {place}", hint=error.hint) from error


def _read(mapping: Path, graph: Path | None, fabric: str | None) -> MapResult:
    data = read_json(mapping)
    if graph is None and fabric is None:
        return read_result(data, str(mapping))
    the_dfg = dfg.load(graph) if graph is not None else _of(read_result(data).subject).dfg
    own = read_result(data).subject if fabric is None else None
    the_fabric = arch.load_tile(fabric) if fabric is not None else _of(own).fabric
    return mapping_from_json(data, the_dfg, the_fabric)


def _of(subject: Subject | None) -> Subject:
    assert subject is not None  # read_result has filled it in
    return subject


def read_json(path: Path) -> object:
    text = read_text(path, GRAPH_BYTES)
    demand_few_values(text, GRAPH_BYTES, path)
    try:
        return json.loads(text, object_pairs_hook=lambda pairs: _once(path, pairs))
    except json.JSONDecodeError as error:
        raise VividcError(f"not JSON: {error.msg}", loc=f"{path}:{error.lineno}") from error
    except (ValueError, RecursionError) as error:
        hint = "name a file that `vividc map -o` wrote"
        raise VividcError("not a mapping file", loc=str(path), hint=hint) from error


def _once(path: Path, pairs: list[tuple[str, object]]) -> dict[str, object]:
    """An object whose keys are unique: of two equal ones json keeps the last without a word."""
    unique = dict(pairs)
    if len(unique) < len(pairs):
        keys = [key for key, _ in pairs]
        twice = next(key for key in keys if keys.count(key) > 1)
        hint = "name a file that `vividc map -o` wrote"
        raise VividcError(f"the key {quoted(twice)} is there twice", loc=str(path), hint=hint)
    return unique


def _as_object(
    result: MapResult, findings: tuple[Finding, ...], *, wrong: bool
) -> dict[str, object]:
    return {
        "dfg": _of(result.subject).dfg.name,
        "fabric": _of(result.subject).fabric.name,
        "status": result.status,
        "constrained": result.constrained,
        "ii": result.ii,
        "lower_bound": result.lower_bound,
        "valid": not wrong,
        "findings": [{"verdict": found.verdict, "what": found.what} for found in findings],
    }


def _given(about: Subject) -> Iterator[str]:
    """What was fixed before mapping, on which all claims rest."""
    if about.allowed:
        yield f"(nodes whose PEs were given: {len(about.allowed)})"
    if about.resident:
        yield f"(PEs with resident constants: {len(about.resident)})"


def _print(result: MapResult, findings: tuple[Finding, ...], *, wrong: bool) -> None:
    about = _of(result.subject)
    end = "" if result.ii is None else f" at II {result.ii}"
    given = "".join(f" {part}" for part in _given(about))
    say(f"{printable(about.dfg.name)} on {about.fabric.name}: {result.claim}{end}{given}")
    for finding in findings:
        say(f"  {printable(str(finding))}")
    say("the file is wrong" if wrong else "nothing in the file is wrong")
