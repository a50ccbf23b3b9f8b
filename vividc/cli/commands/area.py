"""`vividc area`: the silicon area of a fabric."""

from __future__ import annotations

import click

from vividc import arch
from vividc.arch import Accelerator, Fabric
from vividc.arch.cost.tables import DEFAULT_TABLE, load_costs
from vividc.cli import completion, options
from vividc.cli.reports.energy import print_area
from vividc.cli.reports.report import print_json
from vividc.sim.cost import area

SCHEMA = "vividc.area/1"


@click.command("area")
@click.argument("fabric", metavar="FABRIC", shell_complete=completion.fabric)
@click.option(
    "--tiles",
    type=click.IntRange(1, 4096),
    metavar="N",
    help="Tiles. [default: the accelerator's, or 1]",
)
@click.option(
    "--costs",
    default=DEFAULT_TABLE,
    metavar="TABLE",
    help="Cost table, by name or YAML file.",
    shell_complete=completion.costs,
)
@click.option(
    "--node",
    type=float,
    callback=options.node,
    metavar="NM",
    help="Node to scale to, 7 to 45. [default: the table's]",
)
@options.as_json
def command(fabric: str, tiles: int | None, costs: str, node: float | None, as_json: bool) -> None:
    """Print the area of a tile, or of an accelerator's tiles, with the kind of each figure."""
    machine = arch.load(fabric)
    tile, count = (machine, 1) if isinstance(machine, Fabric) else _tiles(machine)
    report = area(tile, load_costs(costs), tiles=tiles or count, node_nm=node)
    if as_json:
        print_json(SCHEMA, report)
    else:
        print_area(report)


def _tiles(accelerator: Accelerator) -> tuple[Fabric, int]:
    """A tile of an accelerator, of which the others are mirror images, and how many there are."""
    return accelerator.fabric, len(accelerator.tiles)
