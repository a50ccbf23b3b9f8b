"""Writes files for a user: completely or not at all, and through anything that is not a regular
file.
"""

from __future__ import annotations

import os
import stat
import sys
import tempfile
from pathlib import Path
from typing import Final

from vividc.errors import VividcError

_STREAMS: Final = (1, 2)
"""Descriptors of standard output and standard error."""


def write_whole(path: Path, data: bytes, error: type[VividcError] = VividcError) -> None:
    """Create or replace the file `path`; if that fails, what was there stays as it was.

    The data goes to a temporary file in the same folder, which then takes the name in one step and
    the permissions of what it replaces. A link is followed. What is no regular file (a device, a
    FIFO, the terminal) and the process's own output (`/dev/stdout`) are written to.

    Raises
    ------
    VividcError
        The file cannot be written; `error` says of which class.
    """
    try:
        target = Path(os.path.realpath(path))
        status = _status(path)
        if status is not None and is_written_through(path):
            _write_through(path, status, data)
        else:
            _replace(target, status, data)
    except OSError as fault:
        raise error(f"cannot be written: {fault.strerror or fault}", loc=str(path)) from fault
    except ValueError as fault:  # a NUL or half a character in the path
        raise error(f"cannot be written: {fault}", loc=repr(str(path))) from fault


def is_written_through(path: Path) -> bool:
    """Whether `path` is there and takes data as it comes, instead of being replaced."""
    status = _status(path)
    return status is not None and (
        not stat.S_ISREG(status.st_mode) or _stream_of(status) is not None
    )


def _replace(target: Path, status: os.stat_result | None, data: bytes) -> None:
    descriptor, name = tempfile.mkstemp(prefix=f".{target.name[:16]}.", dir=target.parent)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(name, _mode_of_new_file() if status is None else stat.S_IMODE(status.st_mode))
        os.replace(name, target)
    except BaseException:
        os.unlink(name)
        raise


def _write_through(path: Path, status: os.stat_result, data: bytes) -> None:
    stream = _stream_of(status)
    if stream is None:
        path.write_bytes(data)
        return
    # A second opening of a redirected file would have a place of its own, and overwrite.
    for text in (sys.stdout, sys.stderr):
        if text is not None:
            text.flush()
    with os.fdopen(os.dup(stream), "wb") as file:
        file.write(data)


def _stream_of(status: os.stat_result) -> int | None:
    """Standard output or error, if that is the file."""
    for descriptor in _STREAMS:
        try:
            own = os.fstat(descriptor)
        except OSError:  # closed
            continue
        if os.path.samestat(own, status):
            return descriptor
    return None


def _status(path: Path) -> os.stat_result | None:
    try:
        return path.stat()
    except (OSError, ValueError):  # the writing says why
        return None


def _mode_of_new_file() -> int:
    umask = os.umask(0)
    os.umask(umask)
    return 0o666 & ~umask
