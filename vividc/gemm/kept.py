"""Programs of products in the user's cache: building one takes ten times as long as reading it.

What is kept is known by a hash of all that it is made from, this package's code included.
"""

from __future__ import annotations

from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Final

from vividc import kept
from vividc.arch.fabric import Fabric
from vividc.program import Program

_KIND: Final = "product"
_MADE_BY = ("arch", "dfg", "gemm", "mapper", "program")
"""Folders of the package whose code makes programs."""


def key_of(fabric: Fabric, *form: object) -> str:
    """What a program of this form on a fabric is known by."""
    return sha256(f"product|{_code()}|{fabric.source}|{form!r}".encode()).hexdigest()


def read_program(key: str) -> Program | None:
    """The program of this key, if there is one to trust."""
    return kept.read_program(_KIND, key)


def write_program(key: str, program: Program) -> None:
    """Keep a program; silently not, if that is not possible."""
    kept.write_program(_KIND, key, program)


@cache
def _code() -> str:
    """A hash of the code that makes programs."""
    package = Path(__file__).resolve().parents[1]
    digest = sha256()
    for room in _MADE_BY:
        for file in sorted((package / room).rglob("*.py")):
            digest.update(str(file.relative_to(package)).encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()
