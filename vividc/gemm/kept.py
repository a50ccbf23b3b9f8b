"""Programs of products in the user's cache: building one takes ten times as long as reading it.

What is kept is known by a hash of all that it is made from, this package's code included.
"""

from __future__ import annotations

from hashlib import sha256
from typing import Final

from vividc.arch.fabric import Fabric
from vividc.program import Program, kept

_KIND: Final = "product"
_MADE_BY = ("arch", "dfg", "gemm", "machine", "mapper", "program", "ssa")
"""Folders of the package whose code makes programs."""


def key_of(fabric: Fabric, *form: object) -> str:
    """Return the cache key of a program of this form on a fabric."""
    return sha256(
        f"product|{kept.source_digest(*_MADE_BY)}|{fabric.source}|{form!r}".encode()
    ).hexdigest()


def read_program(key: str) -> Program | None:
    """Return the program under this key, if there is an intact one."""
    return kept.read_program(_KIND, key)


def write_program(key: str, program: Program) -> None:
    """Store a program; failures to do so are ignored."""
    kept.write_program(_KIND, key, program)
