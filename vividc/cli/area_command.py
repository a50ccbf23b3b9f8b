"""`vividc area`: what a fabric takes in silicon."""

from __future__ import annotations

import click

from vividc import arch
from vividc.arch.costs import DEFAULT_TABLE, load_costs
from vividc.cli import options
from vividc.cli.energy_report import print_area
from vividc.cli.report import print_json
from vividc.sim.costs import area

SCHEMA = "vividc.area/1"


@click.command("area")
@click.argument("fabric", metavar="FABRIC")
@click.option(
    "--tiles",
    type=click.IntRange(1, 4096),
    default=1,
    show_default=True,
    metavar="N",
    help="Tiles.",
)
@click.option(
    "--costs",
    default=DEFAULT_TABLE,
    show_default=True,
    metavar="TABLE",
    help="Cost table, by name or YAML file.",
)
@click.option(
    "--node",
    type=float,
    callback=options.node,
    metavar="NM",
    help="Node to scale to, 7 to 45. [default: the table's]",
)
@options.as_json
def command(fabric: str, tiles: int, costs: str, node: float | None, as_json: bool) -> None:
    """Print the area of so many tiles of a fabric, with the kind of each figure."""
    report = area(arch.load_tile(fabric), load_costs(costs), tiles=tiles, node_nm=node)
    if as_json:
        print_json(SCHEMA, report)
    else:
        print_area(report)
