"""The keys of an accelerator's YAML, as pydantic models; `docs/accelerator.md` documents them."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from vividc.arch.yaml.schema import Name, StrictModel, layer_of

_Count = Annotated[int, Field(ge=1, le=64)]
_Bandwidth = Annotated[int, Field(ge=1, le=65536)]
_Cycles = Annotated[int, Field(ge=0, le=1_000_000)]
_Bytes = Annotated[int, Field(ge=4, le=65536)]


class TilesSpec(StrictModel):
    """Rows and columns of tiles, and the fabric of the north-west one."""

    rows: _Count
    cols: _Count
    fabric: str


class DRAMSpec(StrictModel):
    """Bandwidth, latency and smallest access."""

    bytes_per_cycle: _Bandwidth
    latency: _Cycles
    granule_bytes: _Bytes


class NoCSpec(StrictModel):
    """Bandwidth and latency."""

    bytes_per_cycle: _Bandwidth
    latency: _Cycles


class DMASpec(StrictModel):
    """Engines, their setup time and burst length."""

    engines: _Count
    setup_cycles: _Cycles
    burst_bytes: _Bytes


class ConfigurationSpec(StrictModel):
    """Bandwidth of the stream, and whether memories are double-buffered."""

    entries_per_cycle: _Bandwidth
    double_buffered: bool


class AcceleratorSpec(StrictModel):
    """A whole accelerator after `extends` was resolved."""

    name: str  # a file's, if it gives none
    tiles: TilesSpec
    dram: DRAMSpec
    noc: NoCSpec
    dma: DMASpec
    configuration: ConfigurationSpec


AcceleratorLayer: Final = layer_of(AcceleratorSpec, name=Name, extends=str)
"""One YAML text."""
