"""The area of a number of tiles of a fabric."""

from __future__ import annotations

from typing import TypedDict

from vividc.arch import Fabric
from vividc.arch.cost.node_scaling import area_factor
from vividc.arch.cost.tables import Cost, CostTable
from vividc.sim.cost.calibration import calibrate
from vividc.sim.cost.components import configuration_bits, logic, storage_bits
from vividc.sim.cost.report import Item, Part, by_part, item

_MM2: float = 1e-6


class AreaReport(TypedDict):
    """`parts_mm2` add up to `total_mm2`; `items` are in um2."""

    table: str
    fabric: str
    tiles: int
    node_nm: float
    total_mm2: float
    parts_mm2: dict[str, float]
    items: list[Item]


def area(
    fabric: Fabric, table: CostTable, *, tiles: int = 1, node_nm: float | None = None
) -> AreaReport:
    """Area of `tiles` tiles of a fabric.

    The calibration point comes out as published. Configuration memory beyond what the published
    area has room for is a part of its own.

    Parameters
    ----------
    node_nm
        Node to scale to; None: the table's.

    Raises
    ------
    ArchError
        The node or a bank lies outside the table, or the table contradicts its calibration.
    """
    factor = 1.0 if node_nm is None else area_factor(node_nm)
    items = [
        item(part, name, tiles * count, cost, factor)
        for part, name, count, cost in _tile_items(fabric, table)
        if count
    ]
    parts = {part: _MM2 * total for part, total in by_part(items).items()}
    return AreaReport(
        table=table.name,
        fabric=fabric.name,
        tiles=tiles,
        node_nm=table.node_nm if node_nm is None else node_nm,
        total_mm2=sum(parts.values()),
        parts_mm2=parts,
        items=items,
    )


def array_um2(fabric: Fabric, table: CostTable) -> float:
    """Area of a tile's PEs."""
    items = (
        count * cost.value
        for part, _, count, cost in _tile_items(fabric, table)
        if part == "pe_array"
    )
    return sum(items)


def _tile_items(fabric: Fabric, table: CostTable) -> list[tuple[Part, str, float, Cost]]:
    """(part, name, count, cost) of one tile."""
    rest = calibrate(table)
    pad = fabric.scratchpad
    bank = table.bank(pad.size_bytes // pad.banks)
    room = len(fabric.pes) * rest.configuration_bits
    bits = configuration_bits(fabric)
    bank_cost = Cost(bank.area_mm2 / _MM2, bank.kind, bank.source)
    rows: list[tuple[Part, str, float, Cost]] = [
        ("pe_array", name, count, table.area_um2[name]) for name, count in logic(fabric).items()
    ]
    rows += [
        ("pe_array", "registers and constants, bits", storage_bits(fabric), rest.storage_um2),
        ("sram", f"bank of {bank.size_bytes} bytes", pad.banks, bank_cost),
        ("sram", "configuration, bits", room, rest.configuration_um2),
        ("control", "controller", 1, rest.control_um2),
        ("configuration", "bits beyond these", max(0, bits - room), rest.configuration_um2),
    ]
    return rows
