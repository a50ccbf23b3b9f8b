"""Cost tables: energy and area of a fabric's parts, each figure with its source, read from YAML."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from vividc.arch.cost.schema import CostSpec, Kind, TableSpec
from vividc.arch.yaml.layers import is_path, shipped, shipped_text
from vividc.arch.yaml.problems import did_you_mean, validated
from vividc.arch.yaml.tree import parse
from vividc.errors import ArchError, demand_type
from vividc.host.inputs import YAML_BYTES, read_text

DEFAULT_TABLE: Final = "vivid-45nm"


@dataclass(frozen=True, slots=True)
class Cost:
    """One figure, its source, and what it is worth."""

    value: float
    kind: Kind
    source: str


@dataclass(frozen=True, slots=True)
class Bank:
    """A scratchpad bank: energy of an access of a word, leakage, area."""

    size_bytes: int
    read_pj: float
    write_pj: float
    leakage_mw: float
    area_mm2: float
    kind: Kind
    source: str


@dataclass(frozen=True, slots=True)
class PartShares:
    """A published total, in W or mm2, and the parts' shares of it."""

    total: float
    pe_array: float
    sram: float
    control: float


@dataclass(frozen=True, slots=True)
class CalibrationPoint:
    """Published totals of a chip, and the activity at which they are taken to hold.

    Attributes
    ----------
    fabric, tiles, clock_ghz
        The chip: so many tiles of a shipped fabric.
    operations, moves
        Issues by kind, and words moved, of each PE in each cycle.
    reads, writes
        Accesses of each PE with a load/store unit in each cycle.
    """

    source: str
    activity_source: str
    fabric: str
    tiles: int
    clock_ghz: float
    power_w: PartShares
    area_mm2: PartShares
    operations: Mapping[str, float]
    moves: Mapping[str, float]
    reads: float
    writes: float


@dataclass(frozen=True)
class CostTable:
    """Energy in pJ and area in um2, at one node.

    Attributes
    ----------
    operations_pj
        Of an issue, by kind ("fma.f32").
    moves_pj
        Of a word, by name of its count in a run's activity.
    banks
        By ascending size.
    area_um2
        Of a PE's parts; "float" is a float unit made of slices, "fp32" one that is not.
    place
        File and line, for messages.
    """

    name: str
    node_nm: float
    operations_pj: Mapping[str, Cost]
    moves_pj: Mapping[str, Cost]
    dram_pj_per_byte: Cost
    banks: tuple[Bank, ...]
    area_um2: Mapping[str, Cost]
    calibration: CalibrationPoint
    place: str

    def bank(self, size_bytes: int) -> Bank:
        """A bank of this size, between those of the table by linear interpolation. A smaller one
        costs the energy of the smallest, and area and leakage by its share of the bytes.

        Raises
        ------
        ArchError
            It is larger than all in the table.
        """
        first, last = self.banks[0], self.banks[-1]
        if size_bytes > last.size_bytes:
            raise ArchError(
                f"a bank of {size_bytes} bytes is larger than those of the cost table",
                loc=self.place,
                hint=f"more banks, or a table with banks of more than {last.size_bytes} bytes",
            )
        if size_bytes < first.size_bytes:
            share = size_bytes / first.size_bytes
            leakage, area = share * first.leakage_mw, share * first.area_mm2
            return replace(first, size_bytes=size_bytes, leakage_mw=leakage, area_mm2=area)
        above = next(bank for bank in self.banks if bank.size_bytes >= size_bytes)
        if above.size_bytes == size_bytes:
            return above
        return _between(self.banks[self.banks.index(above) - 1], above, size_bytes)


def load_costs(name_or_path: str | os.PathLike[str] = DEFAULT_TABLE) -> CostTable:
    """Load a cost table by the name of a shipped one, or from a YAML file.

    Raises
    ------
    ArchError
        Unknown name, unreadable file, or a faulty table: all its faults, with `file:line`.
    """
    hint = "give a cost table's name or the path of a YAML file"
    demand_type(name_or_path, (str, os.PathLike), "the cost table", hint)
    if isinstance(name_or_path, str) and not is_path(name_or_path):
        return _shipped(name_or_path)
    path = Path(name_or_path)
    text = read_text(path, YAML_BYTES, ArchError, hint)
    return costs_from_text(text, str(path))


def costs_from_text(text: str, file: str = "costs.yaml") -> CostTable:
    """Build a cost table from YAML text; `file` names it in messages.

    Raises
    ------
    ArchError
        The table is faulty; every fault is listed with `file:line`.
    """
    tree = parse(text, file, "cost table")
    spec = validated(tree, TableSpec, inherits=False)
    return _table(spec, tree.place(("calibration",)))


def cost_table_names() -> tuple[str, ...]:
    """Names of the shipped cost tables."""
    return shipped("cost_tables")


def _shipped(name: str) -> CostTable:
    names = cost_table_names()
    if name not in names:
        known = f"known tables: {', '.join((*names, 'FILE.yaml'))}"
        guess = did_you_mean(name, names)
        hint = known if guess is None else f"{guess} {known}"
        raise ArchError(f"unknown cost table `{name}`", hint=hint)
    return costs_from_text(shipped_text("cost_tables", name), f"{name}.yaml")


def _between(below: Bank, above: Bank, size_bytes: int) -> Bank:
    share = (size_bytes - below.size_bytes) / (above.size_bytes - below.size_bytes)

    def mixed(low: float, high: float) -> float:
        return low + share * (high - low)

    return Bank(
        size_bytes=size_bytes,
        read_pj=mixed(below.read_pj, above.read_pj),
        write_pj=mixed(below.write_pj, above.write_pj),
        leakage_mw=mixed(below.leakage_mw, above.leakage_mw),
        area_mm2=mixed(below.area_mm2, above.area_mm2),
        kind="derived",
        source=f"between {below.size_bytes} and {above.size_bytes} bytes; {above.source}",
    )


def _costs(specs: Mapping[str, CostSpec]) -> dict[str, Cost]:
    return {name: _cost(spec) for name, spec in specs.items()}


def _cost(spec: CostSpec) -> Cost:
    return Cost(spec.value, spec.kind, spec.source)


def _table(spec: TableSpec, place: str) -> CostTable:
    point = spec.calibration
    areas = {name: getattr(spec.area_um2, name) for name in type(spec.area_um2).model_fields}
    areas["fp32"] = areas["fp32"] or areas["float"]
    return CostTable(
        name=spec.name,
        node_nm=spec.node_nm,
        operations_pj=_costs(spec.operations_pj),
        moves_pj=_costs(spec.moves_pj),
        dram_pj_per_byte=_cost(spec.dram_pj_per_byte),
        banks=tuple(Bank(**bank.model_dump()) for bank in spec.banks),
        area_um2=_costs(areas),
        calibration=CalibrationPoint(
            source=point.source,
            activity_source=point.activity.source,
            fabric=point.fabric,
            tiles=point.tiles,
            clock_ghz=point.clock_ghz,
            power_w=PartShares(**point.power_w.model_dump()),
            area_mm2=PartShares(**point.area_mm2.model_dump()),
            operations=point.activity.per_pe.operations,
            moves=point.activity.per_pe.moves,
            reads=point.activity.per_memory_pe.reads,
            writes=point.activity.per_memory_pe.writes,
        ),
        place=place,
    )
