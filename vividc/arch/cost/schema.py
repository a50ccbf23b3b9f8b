"""The keys of a cost table's YAML, as pydantic models; `docs/energy.md` documents each of them."""

from __future__ import annotations

from typing import Annotated, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from vividc.arch.yaml.schema import Name
from vividc.machine.kinds import KINDS

Kind = Literal["published", "measured", "derived", "assumed", "calibrated"]
"""What a figure is worth; "calibrated" ones are computed, never read."""

MOVES: Final = (
    "link_words",
    "register_reads",
    "register_writes",
    "constant_reads",
    "constant_writes",
)
_Given = Literal["published", "measured", "derived", "assumed"]
_Amount = Annotated[float, Field(ge=0, le=1e12, allow_inf_nan=False)]
_Positive = Annotated[float, Field(gt=0, le=1e12, allow_inf_nan=False)]
_Source = Annotated[str, Field(min_length=1)]
_SHARES_MAY_MISS: Final = 0.005


def _known(keys: dict[str, object], known: tuple[str, ...], whole: bool) -> None:
    unknown = [key for key in keys if key not in known]
    missing = [key for key in known if key not in keys] if whole else []
    if unknown:
        raise ValueError(f"names `{unknown[0]}`; known: {', '.join(known)}")
    if missing:
        raise ValueError(f"lacks {', '.join(missing)}")


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class CostSpec(_Model):
    """One figure and where it comes from."""

    value: _Amount
    kind: _Given
    source: _Source


class BankSpec(_Model):
    """A scratchpad bank of one size."""

    size_bytes: Annotated[int, Field(ge=4, le=2**30)]
    read_pj: _Positive
    write_pj: _Positive
    leakage_mw: _Positive
    area_mm2: _Positive
    kind: _Given
    source: _Source


class AreaSpec(_Model):
    """Area of a PE's parts, um2."""

    integer: CostSpec
    multiplier: CostSpec
    float: CostSpec
    fp32: CostSpec | None = None  # without slices; as `float` if a table does not say
    address: CostSpec
    crosspoint: CostSpec


class TotalSpec(_Model):
    """A published total and its parts' shares."""

    total: _Positive
    pe_array: _Amount
    sram: _Amount
    control: _Amount

    @model_validator(mode="after")
    def _is_whole(self) -> TotalSpec:
        if abs(self.pe_array + self.sram + self.control - 1) > _SHARES_MAY_MISS:
            raise ValueError("has shares that do not add up to 1")
        return self


class PEActivitySpec(_Model):
    """What a PE does in a cycle."""

    operations: dict[str, _Amount]
    moves: dict[str, _Amount] = {}

    @field_validator("operations")
    @classmethod
    def _operations(cls, value: dict[str, float]) -> dict[str, float]:
        _known(dict(value), KINDS, whole=False)
        return value

    @field_validator("moves")
    @classmethod
    def _moves(cls, value: dict[str, float]) -> dict[str, float]:
        _known(dict(value), MOVES, whole=False)
        return value


class MemoryActivitySpec(_Model):
    """Accesses of a PE with a load/store unit in a cycle."""

    reads: _Amount
    writes: _Amount


class ActivitySpec(_Model):
    """The activity at which the published power holds."""

    source: _Source
    per_pe: PEActivitySpec
    per_memory_pe: MemoryActivitySpec


class CalibrationSpec(_Model):
    """Published totals that the table is made to meet."""

    source: _Source
    fabric: str
    tiles: Annotated[int, Field(ge=1, le=4096)]
    clock_ghz: _Positive
    power_w: TotalSpec
    area_mm2: TotalSpec
    activity: ActivitySpec


class TableSpec(_Model):
    """A whole cost table."""

    name: Name
    node_nm: Literal[45]
    operations_pj: dict[str, CostSpec]
    moves_pj: dict[str, CostSpec]
    dram_pj_per_byte: CostSpec
    banks: Annotated[list[BankSpec], Field(min_length=1)]
    area_um2: AreaSpec
    calibration: CalibrationSpec

    @field_validator("operations_pj")
    @classmethod
    def _operations(cls, value: dict[str, CostSpec]) -> dict[str, CostSpec]:
        _known(dict(value), KINDS, whole=True)
        return value

    @field_validator("moves_pj")
    @classmethod
    def _moves(cls, value: dict[str, CostSpec]) -> dict[str, CostSpec]:
        _known(dict(value), MOVES, whole=True)
        return value

    @field_validator("banks")
    @classmethod
    def _ascending(cls, value: list[BankSpec]) -> list[BankSpec]:
        sizes = [bank.size_bytes for bank in value]
        if sizes != sorted(set(sizes)):
            raise ValueError("should be banks of ascending size")
        return value
