"""The keys of an accelerator's YAML, as pydantic models; `docs/accelerator.md` documents them."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from vividc.arch.yaml.schema import StrictModel

_Count = Annotated[int, Field(ge=1, le=64)]
_Bandwidth = Annotated[int, Field(ge=1, le=65536)]
_Cycles = Annotated[int, Field(ge=0, le=1_000_000)]
_Bytes = Annotated[int, Field(ge=4, le=65536)]
_Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$")]


class TilesLayer(StrictModel):
    """The array of tiles, as far as one layer sets it."""

    rows: _Count | None = None
    cols: _Count | None = None
    fabric: str | None = None


class DRAMLayer(StrictModel):
    """The main memory, as far as one layer sets it."""

    bytes_per_cycle: _Bandwidth | None = None
    latency: _Cycles | None = None
    granule_bytes: _Bytes | None = None


class NoCLayer(StrictModel):
    """The network, as far as one layer sets it."""

    bytes_per_cycle: _Bandwidth | None = None
    latency: _Cycles | None = None


class DMALayer(StrictModel):
    """The DMA engines, as far as one layer sets them."""

    engines: _Count | None = None
    setup_cycles: _Cycles | None = None
    burst_bytes: _Bytes | None = None


class ConfigurationLayer(StrictModel):
    """The configuration stream, as far as one layer sets it."""

    entries_per_cycle: _Bandwidth | None = None
    double_buffered: bool | None = None


class AcceleratorLayer(StrictModel):
    """One YAML text."""

    name: _Name | None = None
    extends: str | None = None
    tiles: TilesLayer | None = None
    dram: DRAMLayer | None = None
    noc: NoCLayer | None = None
    dma: DMALayer | None = None
    configuration: ConfigurationLayer | None = None


class TilesSpec(StrictModel):
    """Rows and columns of tiles, and the fabric of the north-west one."""

    rows: int
    cols: int
    fabric: str


class DRAMSpec(StrictModel):
    """Bandwidth, latency and smallest access."""

    bytes_per_cycle: int
    latency: int
    granule_bytes: int


class NoCSpec(StrictModel):
    """Bandwidth and latency."""

    bytes_per_cycle: int
    latency: int


class DMASpec(StrictModel):
    """Engines, their setup time and burst length."""

    engines: int
    setup_cycles: int
    burst_bytes: int


class ConfigurationSpec(StrictModel):
    """Bandwidth of the stream, and whether memories are double-buffered."""

    entries_per_cycle: int
    double_buffered: bool


class AcceleratorSpec(StrictModel):
    """A whole accelerator after `extends` was resolved."""

    name: str
    tiles: TilesSpec
    dram: DRAMSpec
    noc: NoCSpec
    dma: DMASpec
    configuration: ConfigurationSpec
