"""Compiled programs in the user's cache, and those that are shipped with the package."""

from __future__ import annotations

import os
import zlib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from functools import cache as once
from hashlib import sha256
from pathlib import Path
from typing import Any, Final

from vividc.arch import Fabric
from vividc.errors import BundleError, warn
from vividc.host import cache
from vividc.host.files import write_whole
from vividc.program import Program, from_bytes

COMPILER: Final = (
    "arch",
    "dfg",
    "frontend",
    "gemm",
    "host",
    "lang",
    "machine",
    "mapper",
    "compiler",
    "program",
    "ssa",
)
"""Rooms whose code decides what a kernel becomes."""
_SHIPPED: Final = ".vivid.z"


def read_program(kind: str, key: str) -> Program | None:
    """Return the program under this key, if there is an intact one."""
    content = cache.read(kind, key)
    if content is None:
        return None
    try:
        return from_bytes(zlib.decompress(content))
    except (BundleError, zlib.error) as fault:
        cache.discard(kind, key, f"holds no program ({fault})")
        return None


def write_program(kind: str, key: str, program: Program) -> None:
    """Store a program; failures to do so are ignored."""
    if program.fabric.source:
        cache.write(kind, key, zlib.compress(program.to_bytes(), 1))


def read_shipped(folder: Path, key: str) -> Program | None:
    """Return the program under this key in a folder, if there is an intact one."""
    file = folder / f"{key}{_SHIPPED}"
    try:
        return from_bytes(zlib.decompress(file.read_bytes()))
    except FileNotFoundError:
        return None
    except (OSError, BundleError, zlib.error) as fault:
        reason = fault.reason if isinstance(fault, BundleError) else fault
        warn(f"{file} holds no program ({reason}): it is made anew")
        return None


def write_shipped(folder: Path, key: str, program: Program, root: Path) -> None:
    """Store a program for machines on which no `root` is: files below it are named from there.

    Raises
    ------
    VividcError
        It cannot be written.
    """
    moved: Program = _below(program, f"{root}{os.sep}")
    write_whole(folder / f"{key}{_SHIPPED}", zlib.compress(moved.to_bytes(), 9))


def _below(value: Any, root: str) -> Any:
    """A value in which the names of files begin behind `root`."""
    if isinstance(value, str):
        return value.removeprefix(root)
    if isinstance(value, tuple):
        return tuple(_below(item, root) for item in value)
    if isinstance(value, Fabric) or not is_dataclass(value) or isinstance(value, type):
        return value
    named = {field.name: getattr(value, field.name) for field in fields(value) if field.init}
    moved = {name: _below(one, root) for name, one in named.items()}
    changed = {name: one for name, one in moved.items() if one is not named[name]}
    return replace(value, **changed) if changed else value


@once
def source_digest(*rooms: str) -> str:
    """A hash of the source in these folders of the package, and of the modules above them: part of
    the key of what they make.
    """
    package = Path(__file__).resolve().parents[1]
    files = [*package.glob("*.py")]
    for room in rooms:
        files += (package / room).rglob("*.py")
    digest = sha256()
    for file in sorted(files):
        digest.update(file.relative_to(package).as_posix().encode())
        digest.update(file.read_bytes())
    return digest.hexdigest()


def text_of(value: object) -> str:
    """A value as text, the same in each process, and another one for another value: of dataclasses
    every field, and sets, which have no order of their own, sorted.
    """
    if is_dataclass(value) and not isinstance(value, type):
        inner = (f"{f.name}={text_of(getattr(value, f.name))}" for f in fields(value))
        return f"{type(value).__name__}({', '.join(inner)})"
    if isinstance(value, Mapping):
        items = sorted(f"{text_of(k)}: {text_of(v)}" for k, v in value.items())
        return f"{{{', '.join(items)}}}"
    if isinstance(value, frozenset | set):
        return f"{{{', '.join(sorted(map(text_of, value)))}}}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(text_of, value))}]"
    return repr(value)
