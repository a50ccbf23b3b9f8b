"""`load` and `load_text`: a `Fabric` from a name, a file or a text."""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path

from vividc.arch.fabric import Fabric
from vividc.arch.yaml.build import build
from vividc.arch.yaml.layers import (
    a_folder,
    file_tree,
    is_path,
    preset_names,
    preset_tree,
    text_tree,
)
from vividc.arch.yaml.tree import Tree
from vividc.errors import ArchError, demand_type


def load(name_or_path: str | os.PathLike[str]) -> Fabric:
    """Load a fabric by preset name or from a YAML file.

    Parameters
    ----------
    name_or_path
        One of `preset_names()`, one of `family_names()` with a size, as in `mesh-4x4` (1x1 to
        32x32), or the path of a YAML file (it ends in `.yaml` or `.yml`, contains a slash, or is a
        path object).

    Raises
    ------
    ArchError
        Unknown name, unreadable file, or a faulty description: all its faults, with `file:line`.
    """
    hint = "give a preset's name or the path of a YAML file"
    demand_type(name_or_path, (str, os.PathLike), "the fabric", hint)
    if isinstance(name_or_path, str) and not is_path(name_or_path):
        if name_or_path in preset_names():
            return _shipped(name_or_path)
        return build(_named_tree(name_or_path))
    return build(file_tree(Path(name_or_path)))


def load_text(text: str, file: str = "fabric.yaml") -> Fabric:
    """Build a fabric from YAML text; `load_text(fabric.source, fabric.name)` is equal to `fabric`.

    Parameters
    ----------
    text
        The YAML, which may `extends` a preset, or a file relative to the folder of `file`.
    file
        Name for error messages; also names the fabric if the text does not.

    Raises
    ------
    ArchError
        The description is faulty; every fault is listed with `file:line`.
    """
    return build(text_tree(text, file))


@cache
def _shipped(name: str) -> Fabric:
    """The file does not change, and a `Fabric` cannot be."""
    return build(preset_tree(name))


def _named_tree(name: str) -> Tree:
    """The preset `name`; a file or folder of an unknown name is told."""
    try:
        return preset_tree(name)
    except ArchError as error:
        if os.path.isdir(name):
            raise a_folder(name) from error
        if os.path.isfile(name):
            raise ArchError(
                error.reason, hint=f"for the file of that name write ./{name}"
            ) from error
        raise
