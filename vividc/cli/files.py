"""Checks of output paths, before any work is done for them."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path

from vividc.errors import VividcError, printable
from vividc.host.files import is_written_through


def check_output(path: Path, option: str) -> None:
    """Refuse an output path that cannot be written, before any work is done for it.

    Raises
    ------
    VividcError
        The folder is missing or not writable, or the path is a folder, or a device and the like
        that is not writable.
    """
    try:
        os.stat(path)
    except FileNotFoundError:
        pass
    except OSError as error:
        reason = f"`{printable(str(path))}` cannot be written: {error.strerror}"
        raise VividcError(reason, loc=option) from error
    if path.is_dir():
        raise VividcError(f"`{path}` is a folder", loc=option, hint="name a file in it")
    if is_written_through(path):
        if not os.access(path, os.W_OK):
            raise VividcError(f"`{path}` is not writable", loc=option)
        return
    folder = Path(os.path.realpath(path)).parent if path.is_symlink() else path.parent
    if not folder.is_dir():
        raise VividcError(f"the folder `{folder}` does not exist", loc=option)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise VividcError(f"the folder `{folder}` is not writable", loc=option)


def make_folder(path: Path, option: str) -> None:
    """Create an output folder if it does not exist; its parent must.

    Raises
    ------
    VividcError
        It cannot be made, or not written to.
    """
    try:
        path.mkdir(exist_ok=True)
    except OSError as error:
        reason = f"`{printable(str(path))}` cannot be made: {error.strerror}"
        raise VividcError(reason, loc=option) from error
    if not os.access(path, os.W_OK | os.X_OK):
        raise VividcError(f"the folder `{path}` is not writable", loc=option)


def check_apart(outputs: Mapping[str, Path], inputs: Iterable[Path]) -> None:
    """Refuse outputs that would replace an input or one another; a device takes several.

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
        if is_written_through(path):
            continue
        place = os.path.realpath(path)
        if place in sources:
            reason = f"`{path}` is an input, which would be lost"
            raise VividcError(reason, loc=option, hint="name another file")
        if place in taken:
            reason = f"`{path}` is also what {taken[place]} writes"
            raise VividcError(reason, loc=option, hint="name another file")
        taken[place] = option
