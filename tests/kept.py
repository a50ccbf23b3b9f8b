"""What numba makes of kernels, kept from one run of the tests to the next.

Numba takes a second for a kernel: half of it for its types and code on our target, half for the
code that the tests compare with. Both follow from the kernel, its arguments and the files that
teach numba our types alone. So the LLVM IR of the former and the results of the latter are kept in
pytest's cache, under hashes of all that: a change of the frontend makes all of them anew, and so
does `pytest --cache-clear`. Tests of the frontend take results only (`tests/frontend/conftest.py`).
"""

from __future__ import annotations

import functools
import json
import os
import time
import warnings
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any, ClassVar

import numba
import numpy as np
import pytest
from llvmlite import binding
from numba.core import types

import vividc.frontend.lower
from tests.made_of import made_of
from vividc.frontend import KernelFunction
from vividc.frontend.numba.raises.convention import model_of
from vividc.frontend.numba.target import NumbaModule, numba_module

_PACKAGE = Path(vividc.__file__).parent
_TEACH = ("errors.py", "formats.py", "frontend", "host", "lang", "machine")
"""What there is of numba's target and of our types, with all that these import."""
_UNUSED_S = 14 * 24 * 3600
"""Entries that nobody asked for as long are thrown away."""
_HOME = "<the folder of a kernel that a test wrote>"


_INTEGERS = [getattr(types, f"{sign}int{bits}") for sign in ("", "u") for bits in (8, 16, 32, 64)]
_WORDS = {str(t): t for t in (types.none, types.boolean, types.float32, *_INTEGERS)}
"""Types of what a kernel returns as a word, by numba's name."""


class Kept:
    """The entries, a file each. `scratch`: where tests write kernels, elsewhere in each run."""

    takes_modules: ClassVar = True

    def __init__(self, folder: Path, scratch: Path) -> None:
        self.folder, self.scratch = folder, str(scratch)
        for entry in folder.iterdir():
            if time.time() - entry.stat().st_mtime > _UNUSED_S:
                entry.unlink(missing_ok=True)

    def read(self, key: str) -> bytes | None:
        """What was kept."""
        entry = self.folder / key
        try:
            content = zlib.decompress(entry.read_bytes())
            os.utime(entry)
        except (OSError, zlib.error):
            return None
        return content

    def write(self, key: str, content: bytes) -> None:
        """Keep it, as a whole: other processes read at the same time."""
        unfinished = self.folder / f".{os.getpid()}-{key}"
        unfinished.write_bytes(zlib.compress(content, 1))
        unfinished.replace(self.folder / key)

    def module(
        self, py_func: Callable[..., object], args: tuple[Any, ...], return_type: Any
    ) -> NumbaModule:
        """As `numba_module`."""
        if not self.takes_modules:
            return numba_module(py_func, args, return_type)
        home = os.path.dirname(os.path.abspath(py_func.__code__.co_filename))
        place = _HOME if home.startswith(self.scratch) else home
        lines = repr((place, _lines(py_func))).replace(home, place)
        key = self._key(
            "module", py_func, lines, tuple(map(repr, args)), repr(return_type), model_of(None)
        )
        kept = self.read(key) if key else None
        if kept is not None:
            facts = json.loads(kept)
            texts = tuple(text.replace(place, home) for text in facts["texts"])
            return NumbaModule(texts, facts["symbol"], _WORDS[facts["return"]])
        with warnings.catch_warnings(record=True) as told:
            made = numba_module(py_func, args, return_type)
        _tell(told)
        if key and not told and str(made.returned) in _WORDS:
            texts = [text.replace(home, place) for text in made.texts]
            facts = {"texts": texts, "symbol": made.symbol, "return": str(made.returned)}
            self.write(key, json.dumps(facts).encode())
        return made

    def result(
        self, kernel: KernelFunction, run: Callable[..., object], args: tuple[object, ...]
    ) -> object:
        """Run a kernel on this computer, or do to its arrays what it did."""
        described = _described(args)
        asked = str(kernel.signature), described, kernel.error_model
        key = self._key("result", kernel.py_func, *asked) if described is not None else None
        kept = self.read(key) if key else None
        arrays = [arg for arg in args if isinstance(arg, np.ndarray)]
        if kept is not None:
            facts, _, rest = kept.partition(b"\n")
            for array in arrays:
                if array.flags.writeable:
                    content = np.frombuffer(rest[: array.nbytes], array.dtype)
                    array[...] = content.reshape(array.shape)
                rest = rest[array.nbytes :]
            return _value(json.loads(facts))
        with warnings.catch_warnings(record=True) as told:
            value = run(kernel, *args)
        _tell(told)
        facts = _facts(value)
        if key and facts is not None and not told:
            content = b"".join(array.tobytes() for array in arrays)
            self.write(key, json.dumps(facts).encode() + b"\n" + content)
        return value

    def _key(self, kind: str, function: Callable[..., object], *how: object) -> str | None:
        if not isinstance(function, FunctionType):
            return None
        parts = (kind, _surroundings(), made_of(function), *how)
        return sha256(repr(parts).encode("utf-8", "surrogatepass")).hexdigest()


def _tell(told: list[warnings.WarningMessage]) -> None:
    """Warn of what was told: there is more to it than is kept."""
    for one in told:
        warnings.warn_explicit(one.message, one.category, one.filename, one.lineno)


@functools.cache
def _surroundings() -> str:
    """Versions, the processor, and the files that numba learns our types from."""
    text = sha256(repr((numba.__version__, np.__version__, binding.llvm_version_info)).encode())
    text.update(binding.get_host_cpu_name().encode())
    for name in _TEACH:
        path = _PACKAGE / name
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
            text.update(file.read_bytes())
    text.update(Path(__file__).read_bytes())
    return text.hexdigest()


def _lines(function: Callable[..., object]) -> list[tuple[object, ...]]:
    """Files and lines of a function and of those that it names: the IR tells them."""
    waiting, seen = [function], set()
    found: list[tuple[object, ...]] = []
    while waiting:
        made = waiting.pop()
        if not isinstance(made, FunctionType) or made in seen:
            continue
        seen.add(made)
        found += _lines_of(made.__code__)
        cells = [cell.cell_contents for cell in made.__closure__ or () if _is_filled(cell)]
        for value in (*map(made.__globals__.get, _names(made.__code__)), *cells):
            waiting.append(getattr(value, "py_func", value))
    return found


def _lines_of(code: CodeType) -> Iterator[tuple[object, ...]]:
    yield code.co_filename, code.co_name, code.co_firstlineno, code.co_linetable
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _lines_of(constant)


def _names(code: CodeType) -> list[str]:
    inner = (_names(constant) for constant in code.co_consts if isinstance(constant, CodeType))
    return sorted({*code.co_names}.union(*inner))


def _is_filled(cell: Any) -> bool:
    try:
        return cell.cell_contents is not None
    except ValueError:  # not yet
        return False


def _described(args: tuple[object, ...]) -> str | None:
    """Arguments such that others are described otherwise; None: they are more than numbers."""
    parts: list[object] = []
    for arg in args:
        if isinstance(arg, np.ndarray) and not arg.dtype.hasobject:
            content = sha256(arg.tobytes()).hexdigest()
            flags = arg.flags.writeable, arg.flags.aligned
            parts.append((str(arg.dtype.descr), arg.shape, arg.strides, flags, content))
        elif type(arg) in (bool, int):
            parts.append(arg)
        elif isinstance(arg, float | np.generic):
            parts.append((type(arg).__name__, np.asarray(arg).tobytes().hex()))
        else:
            return None
    arrays = [arg for arg in args if isinstance(arg, np.ndarray)]
    if any(np.may_share_memory(a, b) for n, a in enumerate(arrays) for b in arrays[:n]):
        return None
    return repr(parts)


def _facts(value: object) -> list[object] | None:
    """A returned value as JSON has it; None if it is none of numba's plain ones."""
    if value is None or type(value) in (bool, int):
        return [type(value).__name__, value]
    return ["float", value.hex()] if type(value) is float else None


def _value(facts: list[Any]) -> object:
    kind, value = facts
    return float.fromhex(value) if kind == "float" else value


def take_from_cache(config: pytest.Config, patch: pytest.MonkeyPatch, scratch: Path) -> None:
    """Take what there is from pytest's cache, if there is one, until the patch is undone; kernels
    in a folder of `scratch` are the same in another one.
    """
    cache = getattr(config, "cache", None)
    if cache is None:
        return
    kept = Kept(cache.mkdir("numba"), scratch)
    run = KernelFunction.__call__

    def called(kernel: KernelFunction, *args: object, **named: object) -> object:
        return run(kernel, *args, **named) if named else kept.result(kernel, run, args)

    patch.setattr(KernelFunction, "__call__", called)
    patch.setattr(vividc.frontend.lower, "numba_module", kept.module)


@contextmanager
def modules_made_anew() -> Iterator[None]:
    """No IR is taken or kept here."""
    Kept.takes_modules = False
    try:
        yield
    finally:
        Kept.takes_modules = True
