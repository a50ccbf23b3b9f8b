"""The energy of a run: counts of activity times the figures of a cost table, and what every cycle
costs.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, TypedDict

from vividc.arch import Fabric
from vividc.arch.cost.node_scaling import energy_factor
from vividc.arch.cost.tables import Cost, CostTable
from vividc.machine.kinds import kind_of
from vividc.machine.opcodes import Opcode
from vividc.sim.cost.area import array_um2
from vividc.sim.cost.calibration import calibrate
from vividc.sim.cost.report import ON_CHIP, Item, by_part, item
from vividc.sim.engine import Activity
from vividc.sim.stats import Stats

_NOTES: Final = (
    "standing energy is the rest of the published total at full use, not a measurement",
    "of configuration memory beyond the calibration's no energy is counted: not published",
)


@dataclass(frozen=True, slots=True)
class Work:
    """What was done, on one tile or many.

    Attributes
    ----------
    cycles
        From the first to the last.
    tiles
        Tiles that were on meanwhile, busy or not.
    operations
        Issues by opcode name.
    dram_bytes
        Bytes that crossed the pins.
    """

    cycles: int
    operations: Mapping[str, int]
    activity: Activity
    tiles: int = 1
    dram_bytes: int = 0


class EnergyReport(TypedDict):
    """`parts_pj` add up to `total_pj`; all but "dram" to `chip_pj`, whose average is `power_w`.

    `items` are in pJ; those whose name begins with "standing" are spent in every cycle.
    """

    table: str
    fabric: str
    node_nm: float
    clock_ghz: float
    total_pj: float
    chip_pj: float
    power_w: float
    parts_pj: dict[str, float]
    operations_pj: dict[str, float]
    items: list[Item]
    notes: list[str]


def work_of(stats: Stats) -> Work:
    """The work of a run on one tile."""
    return Work(stats["cycles"], stats["operations"], Activity(**stats["activity"]))


def energy(
    work: Work, fabric: Fabric, table: CostTable, *, node_nm: float | None = None
) -> EnergyReport:
    """Energy of what was done, with every figure's source.

    Parameters
    ----------
    node_nm
        Node to scale to, at the same clock; None: the table's. DRAM stays as it is.

    Raises
    ------
    ArchError
        The node or a bank lies outside the table, or the table contradicts its calibration.
    """
    factor = 1.0 if node_nm is None else energy_factor(node_nm)
    items = [
        *_operations(work, table, factor),
        *_moves(work, table, factor),
        *_scratchpad(work, fabric, table, factor),
        *_standing(work, fabric, table, factor),
        item("dram", "bytes", work.dram_bytes, table.dram_pj_per_byte),
    ]
    items = [one for one in items if one["count"]]
    parts = by_part(items)
    chip = sum(total for part, total in parts.items() if part in ON_CHIP)
    seconds = work.cycles / (fabric.clock_ghz * 1e9)
    return EnergyReport(
        table=table.name,
        fabric=fabric.name,
        node_nm=table.node_nm if node_nm is None else node_nm,
        clock_ghz=fabric.clock_ghz,
        total_pj=sum(parts.values()),
        chip_pj=chip,
        power_w=chip * 1e-12 / seconds if seconds else 0.0,
        parts_pj=parts,
        operations_pj={
            one["name"]: one["total"] for one in items if one["name"] in table.operations_pj
        },
        items=items,
        notes=list(_NOTES),
    )


def _operations(work: Work, table: CostTable, factor: float) -> list[Item]:
    counts: Counter[str] = Counter()
    for opcode, count in work.operations.items():
        counts[".".join(kind_of(Opcode(opcode)))] += count
    return [
        item("pe_array", kind, counts[kind], table.operations_pj[kind], factor)
        for kind in sorted(counts)
    ]


def _moves(work: Work, table: CostTable, factor: float) -> list[Item]:
    return [
        item("pe_array", name, getattr(work.activity, name), cost, factor)
        for name, cost in table.moves_pj.items()
    ]


def _scratchpad(work: Work, fabric: Fabric, table: CostTable, factor: float) -> list[Item]:
    pad = fabric.scratchpad
    bank = table.bank(pad.size_bytes // pad.banks)
    reads, writes = work.activity.scratchpad_reads, work.activity.scratchpad_writes
    return [
        item("sram", "scratchpad_reads", reads, Cost(bank.read_pj, bank.kind, bank.source), factor),
        item(
            "sram", "scratchpad_writes", writes, Cost(bank.write_pj, bank.kind, bank.source), factor
        ),
    ]


def _standing(work: Work, fabric: Fabric, table: CostTable, factor: float) -> list[Item]:
    """What every tile costs in every cycle: that of the array grows with its area, that of the
    scratchpad with its leakage.
    """
    rest = calibrate(table)
    cycles = work.cycles * work.tiles
    grown = array_um2(fabric, table) / array_um2(rest.fabric, table)
    leaks = _leakage(fabric, table) / _leakage(rest.fabric, table)
    array, sram, control = rest.pe_array_pj, rest.sram_pj, rest.control_pj
    return [
        item("pe_array", "standing, tile-cycles", cycles, array, factor * grown),
        item("sram", "standing, tile-cycles", cycles, sram, factor * leaks),
        item("control", "standing, tile-cycles", cycles, control, factor),
    ]


def _leakage(fabric: Fabric, table: CostTable) -> float:
    pad = fabric.scratchpad
    return pad.banks * table.bank(pad.size_bytes // pad.banks).leakage_mw
