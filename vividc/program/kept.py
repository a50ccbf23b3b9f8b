"""Compiled programs in the user's cache."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import cache as once
from hashlib import sha256
from pathlib import Path
from typing import Final

from vividc.errors import BundleError
from vividc.host import cache
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
