"""Compiled programs in the user's cache."""

from __future__ import annotations

import zlib
from functools import cache as once
from hashlib import sha256
from pathlib import Path

from vividc.errors import BundleError
from vividc.host import cache
from vividc.program import Program, from_bytes


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
