"""`load`: from a name or a file to a `Fabric` or, where it describes tiles, an `Accelerator`."""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path
from typing import Literal, overload

import yaml

from vividc.arch.accelerator import DMA, DRAM, Accelerator, Configuration, NoC, Orientation
from vividc.arch.fabric import Fabric
from vividc.arch.yaml.accelerator_schema import AcceleratorLayer, AcceleratorSpec
from vividc.arch.yaml.build import build
from vividc.arch.yaml.layers import entered, file_tree, is_path, merge, shipped, shipped_text
from vividc.arch.yaml.load import load as load_tile
from vividc.arch.yaml.problems import Problem, raise_all, validated
from vividc.arch.yaml.reflect import reflected
from vividc.arch.yaml.tree import Tree, parse
from vividc.errors import ArchError, demand_type
from vividc.host.inputs import YAML_BYTES, read_text

ShippedAccelerator = Literal["vivid", "vivid-unit"]
ShippedTile = Literal[
    "vivid-16x16",
    "vivid-8x8",
    "vivid-tile",
    "vivid-tile-ne",
    "vivid-tile-nw",
    "vivid-tile-se",
    "vivid-tile-sw",
    "vivid-tile-unit",
]


def accelerator_names() -> tuple[str, ...]:
    """Names of the shipped accelerators."""
    return shipped("accelerators")


@overload
def load(name_or_path: ShippedAccelerator) -> Accelerator: ...


@overload
def load(name_or_path: ShippedTile) -> Fabric: ...


@overload
def load(name_or_path: str | os.PathLike[str]) -> Fabric | Accelerator: ...


def load(name_or_path: str | os.PathLike[str]) -> Fabric | Accelerator:
    """Load a fabric or an accelerator by preset name or from a YAML file.

    Parameters
    ----------
    name_or_path
        One of `accelerator_names()` or `preset_names()`, `mesh-RxC` or `torus-RxC`, or the path of
        a YAML file; one with the key `tiles`, or that extends an accelerator, describes an
        accelerator. Type checkers know which it is of shipped names only: of others `load_tile` and
        `load_accelerator` say so.

    Raises
    ------
    ArchError
        Unknown name, unreadable file, or a faulty description: all its faults, with `file:line`.
    """
    hint = "give a preset's name or the path of a YAML file"
    demand_type(name_or_path, (str, os.PathLike), "the fabric", hint)
    if isinstance(name_or_path, str) and not is_path(name_or_path):
        if name_or_path in accelerator_names():
            return _shipped(name_or_path)
        return load_tile(name_or_path)
    path = Path(name_or_path)
    tree = _accelerator_tree(path, ())
    return load_tile(path) if tree is None else _build(tree, path.parent)


def load_accelerator(name_or_path: str | os.PathLike[str]) -> Accelerator:
    """As `load`, but only an accelerator will do.

    Raises
    ------
    ArchError
        As for `load`, or it is a single tile.
    """
    machine = load(name_or_path)
    if isinstance(machine, Accelerator):
        return machine
    raise ArchError(
        f"`{name_or_path}` is a single tile",
        hint=f"accelerators: {', '.join(accelerator_names())}, or a YAML file with `tiles`",
    )


def load_accelerator_text(text: str, file: str = "accelerator.yaml") -> Accelerator:
    """Build an accelerator from YAML text, which may `extends` a preset.

    Raises
    ------
    ArchError
        The description is faulty; every fault is listed with `file:line`.
    """
    tree = _layered(parse(text, file), Path(file), ())
    return _build(tree, Path(file).parent)


def _accelerator_tree(path: Path, opened: tuple[Path, ...]) -> Tree | None:
    """The merged layers of a file, None if it describes a tile (or cannot be read as anything)."""
    opened = entered(path, opened)
    if not os.path.exists(path) or os.path.isdir(path):
        return None  # whoever reads it as a tile says so
    tree = parse(read_text(path, YAML_BYTES, ArchError), str(path))
    base = tree.data.get("extends")
    extends = isinstance(base, str) and _extends_accelerator(base, path, opened)
    if "tiles" not in tree.data and not extends:
        return None
    return _layered(tree, path, opened)


def _extends_accelerator(base: str, path: Path, opened: tuple[Path, ...]) -> bool:
    if is_path(base):
        return _accelerator_tree(path.parent / base, opened) is not None
    return base in accelerator_names()


def _layered(tree: Tree, path: Path, opened: tuple[Path, ...]) -> Tree:
    validated(tree, AcceleratorLayer)
    base = tree.data.get("extends")
    data = {key: value for key, value in tree.data.items() if key != "extends"}
    data.setdefault("name", path.stem)
    layer = Tree(data, tree.places)
    if not isinstance(base, str):
        return layer
    below = (
        _accelerator_tree(path.parent / base, opened)
        if is_path(base)
        else (_preset_tree(base) if base in accelerator_names() else None)
    )
    if below is None:
        raise ArchError(
            f"`{base}` is not an accelerator",
            loc=tree.place(("extends",)),
            hint=f"accelerators: {', '.join(accelerator_names())}, or a YAML file with `tiles`",
        )
    return merge(below, layer)


@cache
def _shipped(name: str) -> Accelerator:
    """The file does not change, and an `Accelerator` cannot be."""
    return _build(_preset_tree(name), None)


def _preset_tree(name: str) -> Tree:
    tree = parse(shipped_text("accelerators", name), f"{name}.yaml")
    return _layered(tree, Path(name), ())


def _build(tree: Tree, folder: Path | None) -> Accelerator:
    spec = validated(tree, AcceleratorSpec)
    raise_all(list(_problems(spec, tree)))
    fabric = _tile(spec.tiles.fabric, tree, folder)
    corners: dict[Orientation, Fabric] = {}
    tiles = []
    for row in range(spec.tiles.rows):
        for col in range(spec.tiles.cols):
            corner = _corner(row, col)
            if corner not in corners:
                corners[corner] = reflected(fabric, corner)
            tiles.append(corners[corner])
    return Accelerator(
        name=spec.name,
        rows=spec.tiles.rows,
        cols=spec.tiles.cols,
        tiles=tuple(tiles),
        dram=DRAM(**spec.dram.model_dump()),
        noc=NoC(**spec.noc.model_dump()),
        dma=DMA(**spec.dma.model_dump()),
        configuration=Configuration(**spec.configuration.model_dump()),
        source=yaml.safe_dump(spec.model_dump(mode="json"), sort_keys=False),
    )


def _corner(row: int, col: int) -> Orientation:
    if row % 2 == 0:
        return "nw" if col % 2 == 0 else "ne"
    return "sw" if col % 2 == 0 else "se"


def _problems(spec: AcceleratorSpec, tree: Tree) -> list[Problem]:
    granule, burst = spec.dram.granule_bytes, spec.dma.burst_bytes
    problems = []
    if granule & (granule - 1):
        place = tree.place(("dram", "granule_bytes"))
        problems.append(Problem(place, f"{granule} bytes: not a power of two"))
    if burst % granule:
        place = tree.place(("dma", "burst_bytes"))
        problems.append(
            Problem(place, f"a burst of {burst} bytes is not a multiple of {granule}, the granule")
        )
    return problems


def _tile(name: str, tree: Tree, folder: Path | None) -> Fabric:
    place = tree.place(("tiles", "fabric"))
    if is_path(name):
        return build(file_tree((folder or Path()) / name, named_at=place))
    try:
        return load_tile(name)
    except ArchError as error:
        raise ArchError(error.reason, loc=place, hint=error.hint) from error
