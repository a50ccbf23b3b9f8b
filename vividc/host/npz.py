"""Arrays of an `.npz` file: every header is checked against what is there before data is unpacked.

numpy's own reader believes headers, so that some hundred bytes ask for any amount of memory, and
raises whatever its parsers do; nothing in a file is unpickled here either.
"""

from __future__ import annotations

import ast
import io
import math
import os
import stat
import struct
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Final

import numpy as np
from numpy.typing import NDArray

from vividc.errors import VividcError, quoted
from vividc.host.inputs import limit, read_bytes, size_text, too_large

Array = NDArray[Any]

_ZIP_MAGIC: Final = b"PK"
_NPY_MAGIC: Final = b"\x93NUMPY"
_SUFFIX: Final = ".npy"
_KEYS: Final = {"descr", "fortran_order", "shape"}
_LENGTHS: Final = {1: "<H", 2: "<I", 3: "<I"}
"""Form of the length of the header, by version of the format."""
_HEADER_BYTES: Final = 1 << 14
_DIRECTORY_BYTES: Final = 4 << 20
"""zipfile makes some hundred bytes of each entry of a directory."""
_PIECE: Final = 1 << 20
_KINDS: Final = "biufcSU"
_METHODS: Final = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
"""Those of `numpy.savez` and `savez_compressed`; others are unpacked without a bound."""
_ENCRYPTED: Final = 1
_DAMAGE: Final = (
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
    EOFError,
    IndexError,
    KeyError,
    NotImplementedError,
    OverflowError,
    RuntimeError,
    ValueError,
)
"""What zipfile and numpy raise for a file that is not what it claims to be."""
_NO_LITERAL: Final = (SyntaxError, ValueError, TypeError, MemoryError, RecursionError)


@dataclass(frozen=True, slots=True)
class Header:
    """What a member says of its array; `offset` is where its data begins."""

    dtype: np.dtype[Any]
    shape: tuple[int, ...]
    fortran: bool
    offset: int

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return len(self.shape)

    @property
    def size_bytes(self) -> int:
        """Bytes of the elements."""
        return math.prod(self.shape) * self.dtype.itemsize


class Npz:
    """An open file: the headers of its arrays by name, and the arrays when asked for."""

    def __init__(self, path: Path, archive: zipfile.ZipFile, most: int) -> None:
        self._archive = archive
        self._members = _members(archive)
        self.headers: Mapping[str, Header] = {
            name: self._header(name, info) for name, info in self._members.items()
        }
        self._path, self._most = path, most

    def demand_room(self, error: type[VividcError]) -> None:
        """Refuse arrays that are more than the limit together.

        Raises
        ------
        VividcError
            They are; `error` says of which class.
        """
        total = sum(header.size_bytes for header in self.headers.values())
        if total > self._most:
            what = f"its arrays take {size_text(total)} unpacked"
            raise too_large(self._path, what, self._most, error)

    def arrays(self) -> dict[str, Array]:
        """Return all arrays."""
        return {name: self._array(name) for name in self.headers}

    def _header(self, name: str, info: zipfile.ZipInfo) -> Header:
        with self._archive.open(info) as member:
            header = _read_header(member)
        if header.offset + header.size_bytes != info.file_size:
            raise ValueError(
                f"the header of `{name}` promises {size_text(header.size_bytes)}, and there are "
                f"{size_text(max(0, info.file_size - header.offset))}"
            )
        return header

    def _array(self, name: str) -> Array:
        header = self.headers[name]
        flat = np.empty(math.prod(header.shape), header.dtype)
        target = flat.view(np.uint8) if flat.size else np.empty(0, np.uint8)
        with self._archive.open(self._members[name]) as member:
            _exactly(member, header.offset)
            at = 0
            while at < len(target):
                piece = _exactly(member, min(_PIECE, len(target) - at))
                target[at : at + len(piece)] = np.frombuffer(piece, np.uint8)
                at += len(piece)
            member.read(1)  # the end, where zipfile compares the checksum
        shape = header.shape
        return flat.reshape(shape[::-1]).transpose() if header.fortran else flat.reshape(shape)


@contextmanager
def opened_npz(
    path: Path, most: int, error: type[VividcError], hint: str | None = None
) -> Iterator[Npz]:
    """Open an npz file whose arrays take at most `most` bytes, in the file and unpacked.

    Raises
    ------
    VividcError
        The file cannot be read, is no npz file of plain arrays, is damaged, or too large; `error`
        says of which class, and `hint` what is expected.
    """
    with _opened(path, most, error, hint) as file:
        try:
            with zipfile.ZipFile(_Bounded(file)) as archive:
                npz = Npz(path, archive, limit(most))
                npz.demand_room(error)
                yield npz
        except _DAMAGE as fault:
            text = str(fault).partition("\n")[0] or type(fault).__name__
            reason = f"not a usable npz file: {quoted(text, 200)[1:-1]}"
            raise error(reason, loc=str(path), hint=hint) from fault
        except OSError as fault:
            reason = f"cannot be read: {fault.strerror or fault}"
            raise error(reason, loc=str(path), hint=hint) from fault


def read_npz(
    path: Path, most: int, error: type[VividcError], hint: str | None = None
) -> dict[str, Array]:
    """Read all arrays of an npz file (see `opened_npz`)."""
    with opened_npz(path, most, error, hint) as npz:
        return npz.arrays()


@contextmanager
def _opened(
    path: Path, most: int, error: type[VividcError], hint: str | None
) -> Iterator[IO[bytes]]:
    """A file that can be searched, which begins as a zip file does."""
    try:
        status = os.stat(path)
        regular = stat.S_ISREG(status.st_mode)
        file: IO[bytes] = (
            open(path, "rb") if regular else io.BytesIO(read_bytes(path, most, error, hint))  # noqa: SIM115
        )
    except OSError as fault:
        reason = f"cannot be read: {fault.strerror or fault}"
        raise error(reason, loc=str(path), hint=hint) from fault
    except ValueError as fault:  # a NUL or half a character in the path
        raise error(f"cannot be read: {fault}", loc=repr(str(path)), hint=hint) from fault
    with file:
        if status.st_size > limit(most):
            raise too_large(path, f"a file of {size_text(status.st_size)}", limit(most), error)
        begin = file.read(len(_NPY_MAGIC))
        if not begin.startswith(_ZIP_MAGIC):
            npy = begin == _NPY_MAGIC
            kind = "an npy file, not an npz" if npy else "not a usable npz file: no zip file"
            raise error(kind, loc=str(path), hint=hint)
        file.seek(0)
        yield file


class _Bounded(io.RawIOBase):
    """A file of which no more is read at once than the directory of a sane archive takes."""

    def __init__(self, file: IO[bytes]) -> None:
        super().__init__()
        self._file = file

    def seekable(self) -> bool:
        return True

    def readable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = 0) -> int:
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        return self._file.tell()

    def read(self, size: int | None = -1) -> bytes:
        data = self._file.read(_DIRECTORY_BYTES + 1 if size is None or size < 0 else size)
        if len(data) > _DIRECTORY_BYTES:
            raise zipfile.BadZipFile(f"its directory takes more than {size_text(_DIRECTORY_BYTES)}")
        return data


def _members(archive: zipfile.ZipFile) -> dict[str, zipfile.ZipInfo]:
    members: dict[str, zipfile.ZipInfo] = {}
    for info in archive.infolist():
        name = info.filename.removesuffix(_SUFFIX)
        if name == info.filename:
            raise ValueError(f"its member `{name}` is not an array (.npy)")
        if name in members:
            raise ValueError(f"the array `{name}` is there twice")
        if info.compress_type not in _METHODS or info.flag_bits & _ENCRYPTED:
            raise ValueError(f"the array `{name}` is packed in a way that numpy.savez has not")
        members[name] = info
    return members


def _read_header(member: IO[bytes]) -> Header:
    begin = _exactly(member, len(_NPY_MAGIC) + 2)
    form = _LENGTHS.get(begin[-2])
    if not begin.startswith(_NPY_MAGIC) or form is None:
        raise ValueError("a member is not an array: it does not begin as an npy file")
    length: int = struct.unpack(form, _exactly(member, struct.calcsize(form)))[0]
    if length > _HEADER_BYTES:
        raise ValueError(f"the header of an array takes {length} bytes")
    text = _exactly(member, length).decode("latin-1")
    try:
        fields = ast.literal_eval(text.strip())
    except _NO_LITERAL as fault:
        raise ValueError("the header of an array is malformed") from fault
    offset = len(begin) + struct.calcsize(form) + length
    return Header(*_understood(fields), offset)


def _understood(fields: object) -> tuple[np.dtype[Any], tuple[int, ...], bool]:
    if (
        not isinstance(fields, dict)
        or set(fields) != _KEYS
        or not isinstance(fields["shape"], tuple)
    ):
        raise ValueError("the header of an array is malformed")
    shape, fortran = fields["shape"], fields["fortran_order"]
    if not all(type(size) is int and size >= 0 for size in shape) or type(fortran) is not bool:
        raise ValueError("the header of an array has no usable shape")
    if not isinstance(fields["descr"], str):
        raise ValueError("an array has elements of several fields")
    try:
        dtype = np.dtype(fields["descr"])
    except (TypeError, ValueError, SyntaxError) as fault:
        raise ValueError("the header of an array has no usable dtype") from fault
    if dtype.kind not in _KINDS or not dtype.itemsize or dtype.subdtype is not None:
        raise ValueError(f"an array holds {quoted(fields['descr'], 20)}, not plain numbers or text")
    return dtype, shape, fortran


def _exactly(file: IO[bytes], size: int) -> bytes:
    data = file.read(size)
    if len(data) < size:
        raise EOFError("a member ends early")
    return data
