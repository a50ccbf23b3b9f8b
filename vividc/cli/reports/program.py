"""A compiled program as tables: what each region maps to, what binds it, and whether that is
proved.
"""

from __future__ import annotations

from collections.abc import Iterator

import click

from vividc.cli.reports.report import percent, print_table
from vividc.program import CUT_SHORT, Program
from vividc.program.tables import RegionReport

_PROOF = {
    "optimal": "II proved minimal",
    "feasible": "smaller II not refuted",
}


def _proof(region: RegionReport) -> str:
    proof = _PROOF.get(region.status, region.status)
    return f"{proof}, memory order assumed" if region.rests_on_assumed else proof


def print_regions(program: Program) -> None:
    """Print the regions with II and proof, then every bound of the loops with what binds it."""
    columns = ("region", "kind", "line", "operations", "II", "bound", "proof", "FU use", "seconds")
    rows = (
        (
            region.name,
            region.kind,
            None if region.loc is None else region.loc.line,
            region.operations,
            region.ii,
            region.lower_bound,
            _proof(region),
            percent(region.utilization),
            None if region.wall_s is None else f"{region.wall_s:.1f}",
        )
        for region in program.regions
    )
    title = f"{program.name} on {program.fabric_name}"
    print_table(
        title, columns, rows, numeric=("line", "operations", "II", "bound", "FU use", "seconds")
    )
    print_table(
        "What binds the loops",
        ("region", "bound", "II", "because"),
        _bounds(program),
        numeric=("II",),
    )
    if program.hurried:
        click.echo(f"compiling {CUT_SHORT}")


def _bounds(program: Program) -> Iterator[tuple[object, ...]]:
    for region in program.regions:
        if region.kind != "loop":
            continue
        for bound in region.bounds:
            yield region.name, bound.name, bound.ii, bound.reason
        for refutation in region.refuted:
            yield region.name, "refuted", refutation.ii, refutation.by
