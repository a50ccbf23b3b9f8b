"""Output files that appear whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import IO

from vividc.errors import VividcError


def check_output(path: Path, option: str) -> None:
    """Refuse an output path that cannot be written, before any work is done for it.

    Raises
    ------
    VividcError
        The folder is missing or not writable, or the path is a folder.
    """
    folder = path.parent
    if path.is_dir():
        raise VividcError(f"`{path}` is a folder", loc=option, hint="name a file in it")
    if not folder.is_dir():
        raise VividcError(f"the folder `{folder}` does not exist", loc=option)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise VividcError(f"the folder `{folder}` is not writable", loc=option)


def check_apart(outputs: Mapping[str, Path], inputs: Iterable[Path]) -> None:
    """Refuse outputs that would replace an input or one another.

    Parameters
    ----------
    outputs
        Paths to write, by option.
    inputs
        Files that the command reads.

    Raises
    ------
    VividcError
        Two of the paths are one file.
    """
    sources = {os.path.realpath(path) for path in inputs}
    taken: dict[str, str] = {}
    for option, path in outputs.items():
        place = os.path.realpath(path)
        if place in sources:
            reason = f"`{path}` is an input, which would be lost"
            raise VividcError(reason, loc=option, hint="name another file")
        if place in taken:
            reason = f"`{path}` is also what {taken[place]} writes"
            raise VividcError(reason, loc=option, hint="name another file")
        taken[place] = option


def write_whole(path: Path, write: Callable[[IO[bytes]], object]) -> None:
    """Create or replace `path` with what `write` writes; if that fails, `path` stays as it was.

    The text goes to a temporary file in the same folder, which then takes the name in one step.

    Raises
    ------
    VividcError
        The file cannot be written.
    """
    try:
        descriptor, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
        try:
            with os.fdopen(descriptor, "wb") as file:
                write(file)
                file.flush()
                os.fsync(file.fileno())
            os.chmod(name, _mode(path))
            os.replace(name, path)
        except BaseException:
            os.unlink(name)
            raise
    except OSError as error:
        raise VividcError(f"cannot be written: {error.strerror}", loc=str(path)) from error


def _mode(path: Path) -> int:
    """Permissions of the file that is replaced, or those of a new file."""
    try:
        return path.stat().st_mode & 0o777
    except FileNotFoundError:
        umask = os.umask(0)
        os.umask(umask)
        return 0o666 & ~umask
