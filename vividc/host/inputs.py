"""Reads users' files: checks the size before the data, and reads no more than the kind of file may
have.

Every limit is one of those below; `VIVIDC_INPUT_LIMIT` raises them all (docs/security.md).
"""

from __future__ import annotations

import os
import re
import stat
from pathlib import Path
from typing import Final

from vividc.errors import VividcError

SOURCE_BYTES: Final = 16 << 20
"""A kernel's file, in Python or LLVM IR."""
GRAPH_BYTES: Final = 32 << 20
"""A DFG, a mapping, or the JSON of views."""
YAML_BYTES: Final = 256 << 10
"""Read with a node of some hundred bytes a value; the longest shipped fabric has 6 KiB."""
BUNDLE_BYTES: Final = 256 << 20
SCENE_BYTES: Final = 2 << 30
"""A scene or views: the file, and all its arrays unpacked."""
ARGUMENT_BYTES: Final = 1 << 30
"""Arguments of a launch: the file, and all its arrays unpacked."""
PICTURE_BYTES: Final = 256 << 20
STREAM_BYTES: Final = 64 << 20
"""Of what has no size of its own, such as a pipe or a device, whatever its kind."""

VARIABLE: Final = "VIVIDC_INPUT_LIMIT"
_SIZE: Final = re.compile(r"([0-9]{1,12}) ?(KiB|MiB|GiB|TiB)?")
_UNITS: Final = {None: 0, "KiB": 10, "MiB": 20, "GiB": 30, "TiB": 40}
_PIECE: Final = 1 << 20
_BYTES_A_VALUE: Final = 32
_BYTES_A_PART: Final = 64


def limit(most: int) -> int:
    """Return a limit in bytes, as the environment raises it.

    Raises
    ------
    VividcError
        `VIVIDC_INPUT_LIMIT` is no size.
    """
    text = os.environ.get(VARIABLE, "")
    if not text:
        return most
    match = _SIZE.fullmatch(text)
    if match is None:
        hint = "give bytes, or a number with KiB, MiB, GiB or TiB, as in 8GiB"
        raise VividcError(f"`{text}` is not a size", loc=VARIABLE, hint=hint)
    return max(most, int(match[1]) << _UNITS[match[2]])


def size_text(size: int) -> str:
    """Return a size as people write it."""
    for unit in ("TiB", "GiB", "MiB", "KiB"):
        if size >= 1 << _UNITS[unit]:
            return f"{size / (1 << _UNITS[unit]):.4g} {unit}"
    return f"{size} bytes"


def too_large(
    path: Path | str, what: str, most: int, error: type[VividcError] = VividcError
) -> VividcError:
    """Return the error that says that `what` of a file is over the limit, and what raises it."""
    reason = f"{what}: the limit is {size_text(most)}"
    hint = f"if the file is what it should be, set {VARIABLE}, as in {VARIABLE}=8GiB"
    return error(reason, loc=str(path), hint=hint)


def demand_few_values(
    text: str | bytes, most: int, path: Path | str, error: type[VividcError] = VividcError
) -> None:
    """Refuse JSON of more than one value for each 32 bytes of the limit `most`.

    Python takes up to 120 bytes for the shortest values, and what is made of them as much again.

    Raises
    ------
    VividcError
        It has more; `error` says of which class.
    """
    allowed = limit(most) // _BYTES_A_VALUE
    data = text.encode("utf-8", "surrogatepass") if isinstance(text, str) else text
    values = sum(data.count(mark) for mark in (b",", b"[", b"{"))
    if values > allowed:
        raise _too_many(allowed, "values of JSON", path, error)


def demand_few_parts(
    parts: int, what: str, path: Path | str, error: type[VividcError] = VividcError
) -> None:
    """Refuse a graph of more than one part, such as a tag or a line, for each 64 bytes of the limit
    `GRAPH_BYTES`: what a part becomes takes some hundred bytes.

    Raises
    ------
    VividcError
        It has more; `error` says of which class.
    """
    allowed = limit(GRAPH_BYTES) // _BYTES_A_PART
    if parts > allowed:
        raise _too_many(allowed, what, path, error)


def _too_many(allowed: int, what: str, path: Path | str, error: type[VividcError]) -> VividcError:
    hint = f"if the file is what it should be, set {VARIABLE}, as in {VARIABLE}=8GiB"
    return error(f"more than {allowed:,} {what}", loc=str(path), hint=hint)


def demand_utf8_path(path: Path | str, error: type[VividcError] = VividcError) -> None:
    """Refuse a kernel's file whose path is not UTF-8: numba, LLVM and the program that records the
    source take text, not the bytes of a name.

    Raises
    ------
    VividcError
        It is not; `error` says of which class.
    """
    whole = os.path.abspath(path)
    try:
        whole.encode()
    except UnicodeEncodeError:
        raise error(
            f"{whole}: the name of a kernel's file, and of the folders above it, must be UTF-8",
            hint="rename it, or copy the kernel to a file with another name",
        ) from None


def resolved(path: Path, error: type[VividcError] = VividcError) -> Path:
    """Return the absolute path without links.

    Raises
    ------
    VividcError
        No file can have this path; `error` says of which class.
    """
    try:
        return Path(os.path.realpath(path))
    except ValueError as fault:  # a NUL or half a character
        raise error(f"cannot be read: {fault}", loc=repr(str(path))) from fault


def read_bytes(
    path: Path, most: int, error: type[VividcError] = VividcError, hint: str | None = None
) -> bytes:
    """Read a file of at most `most` bytes; of a pipe or a device at most `STREAM_BYTES`.

    Parameters
    ----------
    most
        One of the limits of this module.
    error, hint
        The class of errors, and the way out for a file that cannot be read.

    Raises
    ------
    VividcError
        The file cannot be read or is larger; `error` says of which class.
    """
    try:
        with open(path, "rb", buffering=0) as file:
            status = os.fstat(file.fileno())
            regular = stat.S_ISREG(status.st_mode)
            allowed = limit(most if regular else min(most, STREAM_BYTES))
            if regular and status.st_size > allowed:
                what = f"a file of {size_text(status.st_size)}"
                raise too_large(path, what, allowed, error)
            pieces = [file.read(status.st_size) or b""] if regular else []
            size = sum(map(len, pieces))
            while piece := file.read(min(_PIECE, allowed + 1 - size)):
                pieces.append(piece)
                size += len(piece)
                if size > allowed:
                    raise too_large(path, "more data than expected", allowed, error)
    except OSError as fault:
        reason = f"cannot be read: {fault.strerror or fault}"
        raise error(reason, loc=str(path), hint=hint) from fault
    except ValueError as fault:  # a NUL in the path
        raise error(f"cannot be read: {fault}", loc=repr(str(path)), hint=hint) from fault
    return pieces[0] if len(pieces) == 1 else b"".join(pieces)


def read_text(
    path: Path, most: int, error: type[VividcError] = VividcError, hint: str | None = None
) -> str:
    """Read a file of text in UTF-8, with line ends as `\\n` and without a byte order mark.

    Raises
    ------
    VividcError
        As for `read_bytes`, or the file is no such text.
    """
    data = read_bytes(path, most, error, hint)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        raise error("not a text file in UTF-8", loc=str(path), hint=hint) from fault
    return text.replace("\r\n", "\n").replace("\r", "\n")
