"""Machine code in files of the user's own: `$VIVIDC_CACHE_DIR`, or `vividc` in `$XDG_CACHE_HOME`.

A file is loaded only if it and its folder belong to the user and nobody else may write them; it
carries a hash of its content, so that a damaged one is not loaded either. Nothing is ever read from
beside a program's file. Without a folder that can be used, everything is compiled anew.
"""

from __future__ import annotations

import os
import stat
import tempfile
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import Final

VARIABLE: Final = "VIVIDC_CACHE_DIR"
KEPT: Final = 4_000
"""Files kept, of some ten KB each (programs of products, which lie here too, some hundred); the
ones used longest ago go first."""
_HASH_BYTES: Final = 32


def folder() -> Path | None:
    """Where machine code is kept; None: the user has no home, or wants no cache."""
    chosen = os.environ.get(VARIABLE)
    if chosen is not None:
        return Path(chosen) / "native" if chosen else None
    base = os.environ.get("XDG_CACHE_HOME", "")
    if os.path.isabs(base):
        return Path(base) / "vividc" / "native"
    home = os.path.expanduser("~")
    return Path(home) / ".cache" / "vividc" / "native" if os.path.isabs(home) else None


def read(key: str) -> bytes | None:
    """The machine code of this key, if there is some to trust."""
    place = folder()
    if place is None or not _is_private(place, stat.S_ISDIR):
        return None
    file = place / f"{key}.o"
    try:
        descriptor = os.open(file, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0))
    except OSError:
        return None
    with os.fdopen(descriptor, "rb") as opened:
        if not _is_ours(os.fstat(descriptor), stat.S_ISREG):
            return None
        content = opened.read()
    code = content[_HASH_BYTES:]
    if sha256(code).digest() != content[:_HASH_BYTES]:
        return None
    with suppress(OSError):
        os.utime(file)
    return code


def write(key: str, code: bytes) -> None:
    """Keep machine code; silently not, if that is not possible."""
    place = folder()
    if place is None:
        return
    with suppress(OSError):
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not _is_private(place, stat.S_ISDIR):
            return
        # A file of another name first: a reader sees all of it or nothing.
        descriptor, name = tempfile.mkstemp(dir=place, prefix=key[:16])
        try:
            with os.fdopen(descriptor, "wb") as opened:
                opened.write(sha256(code).digest() + code)
            os.replace(name, place / f"{key}.o")
        except OSError:
            os.unlink(name)
            raise
        _trim(place)


def _trim(place: Path) -> None:
    files = [file for file in place.iterdir() if file.suffix == ".o"]
    if len(files) > KEPT:
        files.sort(key=lambda file: file.stat().st_mtime)
        for file in files[: len(files) - KEPT * 3 // 4]:
            file.unlink(missing_ok=True)


def _is_private(path: Path, kind: object) -> bool:
    try:
        return _is_ours(os.lstat(path), kind)
    except OSError:
        return False


def _is_ours(status: os.stat_result, kind: object) -> bool:
    assert callable(kind)
    if not kind(status.st_mode):
        return False
    if not hasattr(os, "getuid"):  # no owners to compare on this system
        return True
    others = stat.S_IWGRP | stat.S_IWOTH
    return status.st_uid == os.getuid() and not status.st_mode & others
