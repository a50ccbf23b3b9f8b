"""Which files this user compiled on this machine, and has therefore run already: `simulate --check`
runs those without asking.

A record is an entry of a store in `$XDG_STATE_HOME/vividc`, `~/.local/state/vividc`, or where none
can be written `vividc-<user id>` in the folder of temporary files. It is no cache: it is there with
the cache off, too.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from vividc.host.cache import user_folder
from vividc.host.store import Store

_KIND: Final = "compiled"
_LIMIT_BYTES: Final = 8 << 20
"""Some fifty thousand records; those used longest ago go first."""


def note(file: str, sha256: str) -> None:
    """Record that a file of this content was compiled; silently not, if that is not possible."""
    if not sha256:
        return
    key = _key(file, sha256)
    for store in _stores():
        if store.read(_KIND, key) is not None or store.write(_KIND, key, b""):
            return


def is_noted(file: Path, sha256: str) -> bool:
    """Whether this user compiled the file, at this place and with this content."""
    key = _key(str(file), sha256)
    return any(store.read(_KIND, key) is not None for store in _stores())


def _key(file: str, sha256: str) -> str:
    return f"{sha256} {os.path.realpath(file)}"


def _stores() -> Iterator[Store]:
    state = user_folder("XDG_STATE_HOME", ".local/state")
    if state is not None:
        yield Store(state / "compiled", _LIMIT_BYTES)
    # Without any folder for temporary files Python takes the current one, which anyone may have
    # packed.
    temporary = tempfile.gettempdir()
    if hasattr(os, "geteuid") and temporary != os.getcwd():
        yield Store(Path(temporary) / f"vividc-{os.geteuid()}", _LIMIT_BYTES)
