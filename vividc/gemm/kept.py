"""Programs of products in the user's cache of machine code: building one takes ten times as long as
reading it.

What is kept is known by a hash of all that it is made from, this package's code included, and is
read only where machine code would be (`sim.native.cache`).
"""

from __future__ import annotations

import tempfile
import zlib
from functools import cache
from hashlib import sha256
from pathlib import Path

from vividc.arch.fabric import Fabric
from vividc.errors import BundleError
from vividc.program import Program, load
from vividc.sim.native import cache as files

_MADE_BY = ("arch", "dfg", "gemm", "mapper", "program")
"""Folders of the package whose code makes programs."""


def key_of(fabric: Fabric, *form: object) -> str:
    """What a program of this form on a fabric is known by."""
    return sha256(f"product|{_code()}|{fabric.source}|{form!r}".encode()).hexdigest()


def read_program(key: str) -> Program | None:
    """The program of this key, if there is one to trust."""
    kept = files.read(key)
    if kept is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "product.vivid"
        try:
            path.write_bytes(zlib.decompress(kept))
            return load(path)
        except (BundleError, OSError, zlib.error):
            return None


def write_program(key: str, program: Program) -> None:
    """Keep a program; silently not, if that is not possible."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "product.vivid"
        try:
            program.save(path)
            content = path.read_bytes()
        except (BundleError, OSError):
            return
        files.write(key, zlib.compress(content, 1))


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
