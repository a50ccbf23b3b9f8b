"""Tables of energy and area."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import click

from vividc.cli.reports.report import print_table
from vividc.sim.cost import AreaReport, EnergyReport, Item

_PJ_IN_NJ = 1e3
_UM2_IN_MM2 = 1e6


def print_energy(report: EnergyReport) -> None:
    """Print what a run took, item by item, and what the figures are worth."""
    title = f"energy by {report['table']}{_node(report['node_nm'])}"
    rows = _rows(report["items"], _PJ_IN_NJ)
    columns = ("part", "item", "count", "pJ each", "nJ", "figure")
    print_table(title, columns, rows, numeric=columns[2:5])
    click.echo(f"energy: {report['total_pj'] / _PJ_IN_NJ:,.1f} nJ{_parts(report['parts_pj'])}")
    click.echo(f"average power: {1e3 * report['power_w']:.1f} mW at {report['clock_ghz']:g} GHz")
    for note in report["notes"]:
        click.echo(f"note: {note}")


def print_area(report: AreaReport) -> None:
    """Print what a fabric takes, item by item."""
    tiles = "" if report["tiles"] == 1 else f"{report['tiles']} tiles of "
    title = f"area of {tiles}{report['fabric']} by {report['table']}{_node(report['node_nm'])}"
    rows = _rows(report["items"], _UM2_IN_MM2)
    columns = ("part", "item", "count", "um2 each", "mm2", "figure")
    print_table(title, columns, rows, numeric=columns[2:5])
    click.echo(f"area: {report['total_mm2']:.3f} mm2{_parts(report['parts_mm2'])}")
    if report["parts_mm2"].get("configuration"):
        click.echo("note: the published area has no room for the part `configuration`")


def _rows(items: Iterable[Item], unit: float) -> list[tuple[str, ...]]:
    return [
        (
            one["part"],
            one["name"],
            f"{one['count']:,.0f}",
            f"{one['each']:.4g}",
            f"{one['total'] / unit:,.3f}",
            one["kind"],
        )
        for one in items
    ]


def _node(node_nm: float) -> str:
    return f", {node_nm:g} nm"


def _parts(parts: Mapping[str, float]) -> str:
    whole = sum(parts.values())
    if not whole:
        return ""
    return " (" + ", ".join(f"{part} {100 * n / whole:.1f} %" for part, n in parts.items()) + ")"
