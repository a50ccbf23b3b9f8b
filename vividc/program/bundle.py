"""The `.vivid` file: a zip of one JSON manifest and plain arrays, versioned, reproducible, bounded.

Members are stored, not compressed, so a file can never unpack to more than its own size, and carry
no time of day, so the same program gives the same bytes.
"""

from __future__ import annotations

import io
import json
import struct
import zipfile
import zlib
from collections.abc import Mapping as ReadOnly
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Annotated, Final, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import FailFast, TypeAdapter, ValidationError

from vividc.errors import BundleError, quoted
from vividc.host.files import write_whole
from vividc.host.inputs import BUNDLE_BYTES, demand_few_values, read_bytes
from vividc.machine.parallel import Order, Parallel
from vividc.machine.params import DType, LocalArray, Param
from vividc.machine.product import Products
from vividc.program.tables import (
    DebugRow,
    Home,
    LaunchRow,
    LoopReport,
    Provenance,
    RegionReport,
    RegionRow,
)
from vividc.ssa.results import Results

Scalar = TypeVar("Scalar", bound=np.generic)
T = TypeVar("T")
Rows = Annotated[tuple[T, ...], FailFast()]
"""Read up to the first that is wrong: what pydantic says of a million would fill the memory."""

SCHEMA: Final = "vividc.program/2"
SIZED: Final = "vividc.program/3"
"""Of a program that serves only the sizes that its parameters say: a reader of before would not
check them.
"""
NESTED: Final = "vividc.program/4"
"""Of a program that has the nests of its kernel as well: a reader of before would not know them."""
RETURNING: Final = "vividc.program/5"
"""Of a program that returns arrays or tuples: a reader of before would ask for them."""
DRAINING: Final = "vividc.program/6"
"""Of a program with regions that begin while loops end: a reader of before would run neither."""
FILLING: Final = "vividc.program/7"
"""Of a program with loops that begin while regions end: a reader of before would run neither."""
RELOADING: Final = "vividc.program/8"
"""Of a program longer than the configuration memory: a reader of before would run none of it."""
SAYING: Final = "vividc.program/9"
"""Of a program that returns lists, or that raises: the texts of exceptions may say numbers."""
_SCHEMAS: Final = (SCHEMA, SIZED, NESTED, RETURNING, DRAINING, FILLING, RELOADING, SAYING)
_MANIFEST: Final = "program.json"
_ARRAYS: Final = ("words", "images", "images_set")
_EPOCH: Final = (1980, 1, 1, 0, 0, 0)
_MANY: Final = 1000
_DAMAGE: Final = (
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
    EOFError,
    KeyError,
    IndexError,
    ValueError,
    OverflowError,
    RuntimeError,
    OSError,
)
"""What zipfile, json and numpy raise for a file that is not what it claims to be."""


@dataclass(frozen=True, slots=True)
class Manifest:
    """`program.json`: every part of a program but its arrays. `fabric` is YAML text."""

    schema: str
    opcodes: Rows[str]
    name: str
    params: Rows[Param]
    returns: DType | None
    fabric_name: str
    fabric: str
    contexts: int
    table: Rows[RegionRow]
    launch: Rows[LaunchRow]
    return_home: Home | None
    return_high: Home | None
    banks: dict[str, int]
    debug: Rows[DebugRow]
    regions: Rows[RegionReport]
    provenance: Provenance
    warnings: Rows[str]
    locals: Rows[LocalArray] = ()
    loops: Rows[LoopReport] = ()
    parallel: Parallel | None = None
    products: Products | None = None
    pitches: dict[str, int] = field(default_factory=dict)
    nests: int = 0
    order: Order | None = None
    accelerator: str = ""
    results: Results | None = None


_ADAPTER: Final = TypeAdapter(Manifest)


def write_bundle(
    path: Path,
    manifest: Manifest,
    arrays: ReadOnly[str, NDArray[np.generic]],
    nests: Sequence[bytes] = (),
) -> None:
    """Write `path` so that it is complete or untouched (`write_whole`).

    Raises
    ------
    BundleError
        The file cannot be written.
    """
    write_whole(path, bundle_bytes(manifest, arrays, nests), BundleError)


class BundleReader:
    """An open `.vivid` file, or the bytes of one; damage in its `with` block is a `BundleError`."""

    def __init__(self, path: Path, data: bytes | None = None) -> None:
        self.path = path
        self._given = data

    def __enter__(self) -> BundleReader:
        if self._given is not None:
            self._data = self._given
            return self
        hint = "`vividc compile FILE.py -o OUT.vivid` writes such a file"
        self._data = read_bytes(self.path, BUNDLE_BYTES, BundleError, hint)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if isinstance(error, BundleError) and error.loc is None:
            raise BundleError(error.reason, loc=str(self.path), hint=error.hint) from error
        if isinstance(error, _DAMAGE):
            raise BundleError(
                f"not a complete .vivid file ({_short(error)})",
                loc=str(self.path),
                hint="give a file of `vividc compile`; if it is one, compile the kernel again",
            ) from error

    def manifest(self) -> Manifest:
        """The JSON part, checked for its schema first."""
        text = self._member(_MANIFEST)
        demand_few_values(text, BUNDLE_BYTES, self.path, BundleError)
        schema = _schema(text)
        if schema not in _SCHEMAS:
            raise BundleError(
                f"schema {quoted(schema)}, and this version reads {SCHEMA!r} to {SAYING!r}",
                hint="compile the kernel again with this version",
            )
        return _ADAPTER.validate_json(text, strict=True)

    def array(self, name: str, dtype: np.dtype[Scalar], shape: tuple[int, ...]) -> NDArray[Scalar]:
        """An array member, refused before any allocation unless it has this dtype and shape."""
        data = self._member(f"{name}.npy")
        header = _npy_header(shape, dtype)
        size = dtype.itemsize * int(np.prod(shape))
        if data[: len(header)] != header or len(data) != len(header) + size:
            raise BundleError(f"array {name} is not {dtype.name} of shape {shape}")
        array: NDArray[Scalar] = np.load(io.BytesIO(data), allow_pickle=False)
        return array

    def nests(self, count: int) -> tuple[bytes, ...]:
        """The programs of the kernel's nests."""
        with zipfile.ZipFile(io.BytesIO(self._data)) as archive:
            if len(archive.namelist()) != len(_members()) + count:
                raise BundleError("it does not hold as many nests as it says")
        return tuple(self._member(_nest_name(number)) for number in range(count))

    def _member(self, name: str) -> bytes:
        with zipfile.ZipFile(io.BytesIO(self._data)) as archive:
            names = archive.namelist()
            more = len(names) - len(_members())
            if sorted(names) != sorted((*_members(), *map(_nest_name, range(more)))):
                raise BundleError("its members are not those of a .vivid file")
            info = archive.getinfo(name)
            if info.compress_type != zipfile.ZIP_STORED or info.file_size > len(self._data):
                raise BundleError(f"member {name} is not stored plainly")
            return archive.read(info)


def _schema(text: bytes) -> object:
    raw = json.loads(text)
    return raw.get("schema") if isinstance(raw, dict) else None


def _nest_name(number: int) -> str:
    return f"nest{number}.vivid"


def _members() -> tuple[str, ...]:
    return (_MANIFEST, *(f"{name}.npy" for name in _ARRAYS))


def bundle_bytes(
    manifest: Manifest,
    arrays: ReadOnly[str, NDArray[np.generic]],
    nests: Sequence[bytes] = (),
) -> bytes:
    """What the file holds; equal programs, equal bytes."""
    tree = _ADAPTER.dump_python(manifest, mode="json")
    for report in tree["regions"]:
        report["wall_s"] = None  # a measured time would make every file differ
        report["fabric_yaml"] = ""  # the file has it once
    members = {_MANIFEST: (json.dumps(tree, indent=1, sort_keys=True) + "\n").encode()}
    for name in _ARRAYS:
        array = np.ascontiguousarray(arrays[name])
        members[f"{name}.npy"] = _npy_header(array.shape, array.dtype) + array.tobytes()
    members |= {_nest_name(number): data for number, data in enumerate(nests)}
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as archive:
        for name, data in members.items():
            info = zipfile.ZipInfo(name, _EPOCH)
            info.external_attr = 0o644 << 16
            info.create_system = 3  # the same bytes on every system
            archive.writestr(info, data)
    return buffer.getvalue()


def _npy_header(shape: tuple[int, ...], dtype: np.dtype[np.generic]) -> bytes:
    buffer = io.BytesIO()
    descr = np.lib.format.dtype_to_descr(dtype.newbyteorder("<"))
    header = {"descr": descr, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(buffer, header)
    return buffer.getvalue()


def _short(error: BaseException) -> str:
    if isinstance(error, ValidationError):
        if error.error_count() > _MANY:
            return f"{error.error_count():,} values are not what they should be"
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        return f"{where} {first['msg'].removeprefix('Input ')}"
    return str(error).splitlines()[0] if str(error) else type(error).__name__
