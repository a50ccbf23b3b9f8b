"""The fabric that a program runs on, and accelerators of several tiles.

In order: `fabric` (PEs, links, register files, latencies), `topology`, `accelerator` (tiles, DRAM,
NoC, DMA); `draw/`, `yaml/` (where they are read from), `cost/` (energy and area). Shipped ones are
data.
"""

from vividc.arch.accelerator import (
    DMA,
    DRAM,
    Accelerator,
    Configuration,
    NoC,
    Orientation,
    TileGroup,
)
from vividc.arch.draw.picture import attach
from vividc.arch.fabric import PE, Controller, Fabric, Link, Routing, Scratchpad
from vividc.arch.yaml.layers import family_names, preset_names
from vividc.arch.yaml.load import load as load_tile
from vividc.arch.yaml.load import load_text
from vividc.arch.yaml.load_machine import (
    accelerator_names,
    load,
    load_accelerator,
    load_accelerator_text,
)
from vividc.arch.yaml.reflect import is_isomorphism, reflected, reflection

__all__ = [
    "DMA",
    "DRAM",
    "PE",
    "Accelerator",
    "Configuration",
    "Controller",
    "Fabric",
    "Link",
    "NoC",
    "Orientation",
    "Routing",
    "Scratchpad",
    "TileGroup",
    "accelerator_names",
    "family_names",
    "is_isomorphism",
    "load",
    "load_accelerator",
    "load_accelerator_text",
    "load_text",
    "load_tile",
    "preset_names",
    "reflected",
    "reflection",
]

attach()
