"""What published totals include beyond the figures of a cost table.

Figures of single accesses and blocks stay as they are published. What they leave of a chip's power
at the calibration point is spent in every cycle, and what they leave of its area is storage of the
PEs and configuration memory. By construction the calibration point meets its totals exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

from vividc.arch import Fabric, load_tile
from vividc.arch.cost.tables import Cost, CostTable, PartShares
from vividc.errors import ArchError
from vividc.sim.cost.components import logic, storage_bits

_UM2: float = 1e6
"""Square micrometres of a square millimetre."""


@dataclass(frozen=True, slots=True)
class Calibration:
    """Costs that follow from the published totals.

    Attributes
    ----------
    fabric
        The tile of the calibration point.
    storage_um2
        Of a bit of a register file or constant store, with what else a PE has.
    control_um2
        Of a tile's controller.
    configuration_um2, configuration_bits
        Of a bit of configuration memory; bits of a PE that the published area has room for.
    pe_array_pj, sram_pj, control_pj
        Of a tile in a cycle, whatever it does.
    """

    fabric: Fabric
    storage_um2: Cost
    control_um2: Cost
    configuration_um2: Cost
    configuration_bits: int
    pe_array_pj: Cost
    sram_pj: Cost
    control_pj: Cost


def calibrate(table: CostTable) -> Calibration:
    """The rest that the table's calibration point leaves.

    Raises
    ------
    ArchError
        The table's figures exceed a published total, or its fabric is unknown.
    """
    point = table.calibration
    try:
        fabric = load_tile(point.fabric)
    except ArchError as error:
        raise ArchError(error.reason, loc=table.place, hint=error.hint) from error
    bank = table.bank(fabric.scratchpad.size_bytes // fabric.scratchpad.banks)
    smallest = table.banks[0]
    bit_um2 = smallest.area_mm2 * _UM2 / (8 * smallest.size_bytes)
    sram_um2 = _of_tile(point.area_mm2, "sram", point.tiles) * _UM2
    configuration = sram_um2 - fabric.scratchpad.banks * bank.area_mm2 * _UM2
    spent = _spent_pj(table, fabric)
    known_um2 = sum(count * table.area_um2[name].value for name, count in logic(fabric).items())
    storage = _of_tile(point.area_mm2, "pe_array", point.tiles) * _UM2 - known_um2

    def rest(value: float, what: str) -> Cost:
        if value < 0:
            raise ArchError(f"{what} of the table exceed the published total", loc=table.place)
        return Cost(value, "calibrated", f"{what}: the rest of {point.source}")

    def standing(part: str, known_pj: float) -> Cost:
        total = _of_tile(point.power_w, part, point.tiles) * 1e3 / point.clock_ghz
        return rest(total - known_pj, f"energies of the {part.replace('_', ' ')}")

    return Calibration(
        fabric=fabric,
        storage_um2=rest(storage / storage_bits(fabric), "areas of a PE's logic"),
        control_um2=rest(
            _of_tile(point.area_mm2, "control", point.tiles) * _UM2, "areas of the control"
        ),
        configuration_um2=Cost(bit_um2, "derived", f"per bit; {smallest.source}"),
        configuration_bits=int(
            rest(configuration, "areas of the banks").value / bit_um2 / len(fabric.pes)
        ),
        pe_array_pj=standing("pe_array", spent["pe_array"]),
        sram_pj=standing("sram", spent["sram"]),
        control_pj=standing("control", 0.0),
    )


def _of_tile(totals: PartShares, part: str, tiles: int) -> float:
    share: float = getattr(totals, part)
    return totals.total * share / tiles


def _spent_pj(table: CostTable, fabric: Fabric) -> dict[str, float]:
    """What a tile spends in a cycle of the calibration point by the table's figures."""
    point = table.calibration
    operations = sum(n * table.operations_pj[kind].value for kind, n in point.operations.items())
    moves = sum(n * table.moves_pj[name].value for name, n in point.moves.items())
    bank = table.bank(fabric.scratchpad.size_bytes // fabric.scratchpad.banks)
    accesses = point.reads * bank.read_pj + point.writes * bank.write_pj
    return {
        "pe_array": len(fabric.pes) * (operations + moves),
        "sram": sum(pe.has_memory for pe in fabric.pes) * accesses,
    }
