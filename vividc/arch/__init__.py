"""The fabric a program runs on: data read from YAML, with the shipped fabrics as presets."""

from vividc.arch.fabric import PE, Controller, Fabric, Link, Scratchpad
from vividc.arch.layers import preset_names
from vividc.arch.load import load, load_text

__all__ = [
    "PE",
    "Controller",
    "Fabric",
    "Link",
    "Scratchpad",
    "load",
    "load_text",
    "preset_names",
]
