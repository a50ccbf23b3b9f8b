"""The fabric a program runs on: data read from YAML, with the shipped fabrics as presets."""

from vividc.arch.fabric import PE, Controller, Fabric, Link, Routing, Scratchpad
from vividc.arch.layers import family_names, preset_names
from vividc.arch.load import load, load_text

__all__ = [
    "PE",
    "Controller",
    "Fabric",
    "Link",
    "Routing",
    "Scratchpad",
    "family_names",
    "load",
    "load_text",
    "preset_names",
]
