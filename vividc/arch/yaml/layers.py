"""Fabric YAML in layers: presets, `extends`, and the merge of one text onto the one it extends."""

from __future__ import annotations

import os
import re
from importlib import resources
from pathlib import Path
from typing import Final

from vividc.arch.yaml.problems import did_you_mean, validated
from vividc.arch.yaml.schema import LATENCY_GROUPS, MAX_SIDE, Layer
from vividc.arch.yaml.tree import Path as TreePath
from vividc.arch.yaml.tree import Plain, Tree, parse
from vividc.errors import ArchError
from vividc.host.inputs import YAML_BYTES, read_text, resolved

_SUFFIXES = (".yaml", ".yml")
_FAMILIES: Final = {
    "mesh": None,
    "torus": None,
    "king": None,
    "openedge": "_openedge",
    "hycube": "_hycube",
    "adres": "_adres",
}
"""Arrays that a name such as `mesh-4x4` makes: the shipped layer over the uniform array, or None
for the topology of that name.
"""

_PARAMETRISED = re.compile(rf"({'|'.join(_FAMILIES)})-(\d{{1,3}})x(\d{{1,3}})")
_APPENDED: frozenset[TreePath] = frozenset(
    {("overrides",), ("links", "extra"), ("links", "removed")}
)
"""Lists to which a layer adds; all other values replace what they override."""

_UNIFORM_BANKS = 8

_MOST_LAYERS = 8


def preset_names() -> tuple[str, ...]:
    """Names of the shipped fabrics; besides them, those of `family_names()` exist up to 32x32."""
    return tuple(name for name in shipped("presets") if not name.startswith("_"))


def family_names() -> tuple[str, ...]:
    """Fabrics of any size, as `mesh-RxC`: R rows and C columns."""
    return tuple(f"{family}-RxC" for family in _FAMILIES)


def family_base(name: str) -> str:
    """The shipped layer of one of `family_names()`."""
    return _FAMILIES[name.removesuffix("-RxC")] or "_uniform"


def is_path(name: str) -> bool:
    """Whether `name` is meant as a file and not as a preset."""
    return name.endswith(_SUFFIXES) or "/" in name or "\\" in name


def preset_tree(name: str) -> Tree:
    """Layers of the preset `name`, merged.

    Raises
    ------
    ArchError
        No such preset; the message lists the known ones.
    """
    match = _PARAMETRISED.fullmatch(name)
    if match is not None:
        return _parametrised(name, match[1], int(match[2]), int(match[3]))
    if name not in preset_names():
        raise _unknown(name)
    return _shipped_tree(name)


def file_tree(path: Path, opened: tuple[Path, ...] = (), named_at: str | None = None) -> Tree:
    """Layers of a YAML file, merged; `named_at` is the `file:line` that names it, if one does."""
    try:
        opened = entered(path, opened)
        text = _text_of(path)
    except ArchError as error:
        if named_at is None:
            raise
        reason = f"`{path}`: {error.reason}"
        raise ArchError(reason, loc=named_at, hint=error.hint) from error
    return text_tree(text, str(path), opened)


def entered(path: Path, opened: tuple[Path, ...]) -> tuple[Path, ...]:
    """The files on the way through `extends` to and with this one.

    Raises
    ------
    ArchError
        It is among them already, or they are too many.
    """
    this = resolved(path, ArchError)
    if this in opened:
        chain = " -> ".join(item.name for item in (*opened, this))
        raise ArchError(f"`extends` runs in a circle: {chain}", loc=str(path))
    if len(opened) == _MOST_LAYERS:
        raise ArchError(f"`extends` runs through more than {_MOST_LAYERS} files", loc=str(path))
    return (*opened, this)


def text_tree(text: str, file: str, opened: tuple[Path, ...] = ()) -> Tree:
    """Layers of a YAML text, merged; `file` names it in messages and anchors a relative `extends`.

    What a fabric that extends nothing leaves out, beside its size and topology, is as in
    `mesh-RxC`: for mapping graphs only, little else matters.

    Raises
    ------
    ArchError
        Broken YAML, or values that the schema refuses, with the lines of all of them.
    """
    base_name, layer = _one_layer(text, file)
    if base_name is None:
        rows, cols = layer.data.get("rows"), layer.data.get("cols")
        whole = isinstance(rows, int) and isinstance(cols, int) and "topology" in layer.data
        return merge(_defaults(rows, cols), layer) if whole else layer  # type: ignore[arg-type]
    return merge(_base_tree(base_name, layer, file, opened), layer)


def _one_layer(text: str, file: str) -> tuple[str | None, Tree]:
    """What a text extends, and all else that it says."""
    layer = _expand_latency_groups(_checked(parse(text, file)))
    base_name = layer.data.get("extends")
    data = {key: value for key, value in layer.data.items() if key != "extends"}
    data.setdefault("name", _stem(file))
    return base_name if isinstance(base_name, str) else None, Tree(data, layer.places)


def merge(base: Tree, layer: Tree) -> Tree:
    """`layer` over `base`: mappings key by key, overrides and links appended, the rest replaced."""
    places: dict[TreePath, str] = {(): layer.places[()]}
    data = _merged(base, layer, (), places)
    assert isinstance(data, dict)
    return Tree(data, places)


def _base_tree(name: str, layer: Tree, file: str, opened: tuple[Path, ...]) -> Tree:
    if is_path(name):
        return file_tree(Path(file).parent / name, opened, layer.place(("extends",)))
    try:
        return preset_tree(name)
    except ArchError as error:
        raise ArchError(error.reason, loc=layer.place(("extends",)), hint=error.hint) from error


def _text_of(path: Path) -> str:
    if os.path.isdir(path):
        raise a_folder(str(path))
    return read_text(path, YAML_BYTES, ArchError, f"a file's path, or one of {_known()}")


def a_folder(name: str) -> ArchError:
    """Return the error for the path of a folder."""
    return ArchError("a folder is not a fabric", loc=name, hint="name a YAML file in it")


def _merged(base: Tree, layer: Tree, path: TreePath, places: dict[TreePath, str]) -> Plain:
    below, above = _at(base.data, path), _at(layer.data, path)
    if isinstance(below, dict) and isinstance(above, dict):
        places[path] = layer.places.get(path, base.places[path])
        result: dict[str, Plain] = {}
        for key in dict.fromkeys((*below, *above)):
            inner = (*path, key)
            if key in below and key in above:
                result[key] = _merged(base, layer, inner, places)
            else:
                _copy_places(base if key in below else layer, inner, inner, places)
                result[key] = below[key] if key in below else above[key]
        return result
    if path in _APPENDED and isinstance(below, list) and isinstance(above, list):
        _copy_places(base, path, path, places)
        for index in range(len(above)):
            _copy_places(layer, (*path, index), (*path, len(below) + index), places)
        return [*below, *above]
    _copy_places(layer, path, path, places)
    return above


def _at(data: Plain, path: TreePath) -> Plain:
    for part in path:
        assert isinstance(data, dict)
        data = data[str(part)]
    return data


def _copy_places(tree: Tree, source: TreePath, to: TreePath, places: dict[TreePath, str]) -> None:
    for path, place in tree.places.items():
        if path[: len(source)] == source:
            places[(*to, *path[len(source) :])] = place


def _checked(tree: Tree) -> Tree:
    validated(tree, Layer)
    return _without_nulls(tree)


def _without_nulls(tree: Tree) -> Tree:
    """`key:` without a value means that the key is not set."""

    def clean(value: Plain) -> Plain:
        if isinstance(value, dict):
            return {key: clean(inner) for key, inner in value.items() if inner is not None}
        return [clean(item) for item in value] if isinstance(value, list) else value

    data = clean(tree.data)
    assert isinstance(data, dict)
    return Tree(data, tree.places)


def _expand_latency_groups(tree: Tree) -> Tree:
    given = tree.data.get("latencies")
    if not isinstance(given, dict):
        return tree
    cycles: dict[str, Plain] = {}
    places = dict(tree.places)
    for group, classes in LATENCY_GROUPS.items():
        if group in given:
            cycles |= {lat.value: given[group] for lat in classes}
            place = tree.place(("latencies", group))
            places |= {("latencies", lat.value): place for lat in classes}
    named = {key: value for key, value in given.items() if key not in LATENCY_GROUPS}
    places |= {("latencies", key): tree.place(("latencies", key)) for key in named}
    return Tree({**tree.data, "latencies": {**cycles, **named}}, places)


def _stem(file: str) -> str:
    stem = re.sub(r"[^A-Za-z0-9._-]", "-", Path(file).stem).lstrip("._-")
    return stem[:64] or "fabric"


def shipped(folder: str) -> tuple[str, ...]:
    """Names of the YAML files of one of the package's folders."""
    names = (entry.name for entry in (resources.files("vividc.arch") / folder).iterdir())
    return tuple(sorted(name.removesuffix(".yaml") for name in names if name.endswith(".yaml")))


def shipped_text(folder: str, name: str) -> str:
    """One of these files."""
    file = resources.files("vividc.arch") / folder / f"{name}.yaml"
    return file.read_text(encoding="utf-8")


def _shipped_tree(name: str) -> Tree:
    text, file = shipped_text("presets", name), f"{name}.yaml"
    base_name, layer = _one_layer(text, file)
    return layer if base_name is None else merge(_base_tree(base_name, layer, file, ()), layer)


def _defaults(rows: int, cols: int) -> Tree:
    """What a whole fabric may leave out; of `dot` it is said elsewhere: as `fma` then."""
    base = _uniform(rows, cols)
    latencies = base.data["latencies"]
    assert isinstance(latencies, dict)
    given = {name: cycles for name, cycles in latencies.items() if name != "dot"}
    return Tree({**base.data, "latencies": given}, base.places)


def _uniform(rows: int, cols: int) -> Tree:
    """What arrays of this size have that say nothing else; one bank a PE: that the scratchpad binds
    is a question for fabrics which state their own.
    """
    banks = max(_UNIFORM_BANKS, 1 << (rows * cols - 1).bit_length())
    text = f"rows: {rows}\ncols: {cols}\nscratchpad: {{banks: {banks}}}\n"
    return merge(_shipped_tree("_uniform"), _one_layer(text, "mesh-RxC")[1])


def _parametrised(name: str, family: str, rows: int, cols: int) -> Tree:
    if not (1 <= rows <= MAX_SIDE and 1 <= cols <= MAX_SIDE):
        raise ArchError(f"`{name}` is not from 1x1 to {MAX_SIDE}x{MAX_SIDE}")
    base, published = _uniform(rows, cols), _FAMILIES[family]
    text = f"name: {family}-{rows}x{cols}\n"
    if published is None:
        text += f"topology: {family}\n"
    else:
        size = _one_layer(f"rows: {rows}\ncols: {cols}\n", f"{name}.yaml")[1]
        base = merge(merge(base, _shipped_tree(published)), size)
    return merge(base, _one_layer(text, f"{name}.yaml")[1])


def _known() -> str:
    return ", ".join((*preset_names(), *family_names(), "FILE.yaml"))


def _unknown(name: str) -> ArchError:
    guess = did_you_mean(name, (*preset_names(), *(f"{family}-4x4" for family in _FAMILIES)))
    known = f"known fabrics: {_known()}"
    return ArchError(f"unknown fabric `{name}`", hint=f"{guess} {known}" if guess else known)
