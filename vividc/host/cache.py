"""The one cache: machine code and compiled programs, in `$VIVIDC_CACHE_DIR` or the user's cache
home (`docs/security.md`).

What is kept is known by all that it was made from: a key is that, in full or as a hash (versions
are added here), and equal keys cannot mean different content. Without a folder that can be used,
everything is made anew.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from threading import RLock
from typing import Final

from vividc.errors import warn
from vividc.host.store import Store

VARIABLE: Final = "VIVIDC_CACHE_DIR"
SIZE_VARIABLE: Final = "VIVIDC_CACHE_MB"
DEFAULT_MB: Final = 256
_ENTRIES: Final = "entries"
_PACKAGES: Final = ("vividc", "islpy", "llvmlite", "networkx", "numba", "numpy", "ortools")


def folder() -> Path | None:
    """Where entries are kept; None: the user has no home, or wants no cache."""
    chosen = os.environ.get(VARIABLE)
    if chosen == "":
        return None
    if chosen is not None and os.path.isabs(chosen):
        return Path(chosen) / _ENTRIES
    if chosen is not None:
        complain(f"{VARIABLE} is {chosen!r}, which is no absolute path: it is ignored")
    home = user_folder("XDG_CACHE_HOME", ".cache")
    return None if home is None else home / _ENTRIES


def read(kind: str, key: str) -> bytes | None:
    """What was kept of this kind under this key, if there is something to trust."""
    store = _store()
    return None if store is None else store.read(kind, _full(key))


def write(kind: str, key: str, content: bytes) -> bool:
    """Keep something; whether that was possible. It never fails: a full disk keeps nothing."""
    store = _store()
    return store is not None and store.write(kind, _full(key), content)


@contextmanager
def alone(kind: str) -> Iterator[None]:
    """At most one process at a time is inside, for each kind: what takes long is made once. One
    that waited looks again for what it was about to make; one that is inside may come in again.
    """
    store = _store()
    with _turns:
        if store is None or kind in _held:
            yield
            return
        _held.add(kind)
        try:
            with store.alone(kind):
                yield
        finally:
            _held.discard(kind)


_turns = RLock()
_held: set[str] = set()


def discard(kind: str, key: str, reason: str) -> None:
    """Throw away what was kept, as it is of no use; a warning says so, once a process."""
    store = _store()
    if store is not None:
        store.discard(kind, _full(key), reason)


def _full(key: str) -> str:
    return f"{_versions()}\n{key}"


@cache
def _versions() -> str:
    """What any entry depends on."""
    return " ".join(["Python", sys.version, *(f"{of} {_version(of)}" for of in _PACKAGES)])


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "unknown"


def user_folder(variable: str, default: str) -> Path | None:
    """vividc's folder in one of the user's (XDG base directories): `variable`, else `default` in
    the home. None: neither is an absolute path, or the home is another user's, as under `sudo`.
    """
    base = os.environ.get(variable, "")
    if os.path.isabs(base):
        return Path(base) / "vividc"
    home = os.path.expanduser("~")
    if not os.path.isabs(home) or not _is_own(home):
        return None
    return Path(home) / default / "vividc"


def _is_own(home: str) -> bool:
    try:
        return not hasattr(os, "geteuid") or os.stat(home).st_uid == os.geteuid()
    except OSError:
        return False


def _store() -> Store | None:
    place = folder()
    return None if place is None else _store_of(place, _limit_bytes())


@cache
def _store_of(place: Path, limit: int) -> Store:
    return Store(place, limit)


def _limit_bytes() -> int:
    text = os.environ.get(SIZE_VARIABLE, "")
    if text.isascii() and text.isdigit():
        return int(text[:12]) << 20
    if text:
        complain(f"{SIZE_VARIABLE} is {text!r}, which is not a number of MiB: using {DEFAULT_MB}")
    return DEFAULT_MB << 20


@cache
def complain(what: str) -> None:
    """Once a process."""
    warn(what)
