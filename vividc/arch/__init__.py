"""The fabric a program runs on: data read from YAML, with the shipped fabrics as presets."""

from vividc.arch.accelerator import (
    DMA,
    DRAM,
    Accelerator,
    Configuration,
    NoC,
    Orientation,
    TileGroup,
)
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
