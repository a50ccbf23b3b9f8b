"""Where Python calls compiled functions."""

from __future__ import annotations

import ctypes
import functools
import os
import struct
import time
from collections.abc import Callable, Sequence
from hashlib import sha256
from itertools import count
from threading import Lock
from types import FunctionType
from typing import Any, Final, TypeVar, cast

from vividc.host import cache
from vividc.host.machine_code import shipped
from vividc.host.machine_code.assembler import host, linked, optimised, quickly
from vividc.host.machine_code.body import OUTSIDE
from vividc.host.machine_code.origin import origin
from vividc.host.machine_code.types import FLOAT, NOTHING, TRUTH, Array, Number, Record, Type
from vividc.host.machine_code.unit import Signature, module_text, note, signature

_Function = TypeVar("_Function", bound=Callable[..., object])

CHECKED: Final = bool(os.environ.get("VIVIDC_CHECK_INDICES"))
"""Whether machine code checks its indices, which takes half its time again: for tests of it."""
_KIND: Final = "loops"
_WORD: Final = 8
"""Bytes."""
_PROTOTYPE: Final = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)
_memory_of: Final = (ctypes.c_char * 0).from_buffer
"""Refuses what is not contiguous or cannot be written; an array's own `ctypes` takes three times
as long.
"""
_address_of: Final = ctypes.addressof
_names = count()
units: Final[list[Compiler]] = []
"""All of this process, by when they were made."""
WORTH_S: Final = 2.0
"""Seconds in functions of a unit that was compiled quickly, after which they are optimised."""


class Compiler:
    """A decorator: functions that have it are compiled together, at the first call of one, and kept
    in the user's cache under a hash of what they are made from, unless their machine code came with
    the installation (`shipped`). Their arguments are positional.

    Parameters
    ----------
    in_vectors
        Whether loops gain by computing vectors: compiling takes half the time again.
    soon
        Whether they are compiled quickly, and optimised once that is worth it: what they compute is
        the same. Most users of the mapper's functions are in them for less time than optimising
        them takes.
    """

    def __init__(self, *, in_vectors: bool = False, soon: bool = False) -> None:
        self.entries: list[Entry] = []
        self.is_quick = False
        """Whether functions have machine code that was made quickly."""
        self.in_vectors, self._soon = in_vectors, soon
        self._lock = Lock()
        self._alive: list[object] = []
        self._spent_s = 0.0
        units.append(self)

    def __call__(self, function: _Function, /) -> _Function:
        """Have a function compiled; it keeps its type."""
        return cast(_Function, Entry(cast(FunctionType, function), self))

    def prepare(self) -> None:
        """Compile, or find, what has no machine code yet."""
        with self._lock:
            entries = [entry for entry in self.entries if entry.native is None]
            code = self._at_hand(entries)
            self.is_quick = self._soon and code is None
            self._link(entries, code or self._kept(entries, quick=self.is_quick))

    def portable(self) -> dict[str, bytes]:
        """Machine code of all functions for any processor of this architecture, which an
        installation brings along, by what it is found by: what the functions follow from, or, where
        another Python looks for it, the text of their module.
        """
        text = self._text(self.entries)
        code = optimised(text, in_vectors=self.in_vectors, portable=True)
        return dict.fromkeys((self._about(self.entries), text), code)

    def spent(self, seconds: float) -> None:
        """Functions made quickly ran for so long: optimise them, if that is worth it by now. Other
        threads go on with what there is.
        """
        self._spent_s += seconds
        if self._spent_s < WORTH_S or not self._lock.acquire(blocking=False):
            return
        try:
            if self.is_quick:
                self._link(self.entries, self._kept(self.entries))
                self.is_quick = False
        finally:
            self._lock.release()

    def _link(self, entries: Sequence[Entry], code: bytes) -> None:
        """Have entries call the functions of an object file."""
        called = [signature(entry.py_func) for entry in entries]
        symbols = [*(one.door for one in called), *[OUTSIDE] * CHECKED]
        alive, addresses = linked(code, f"vividc.loops.{next(_names)}", symbols)
        self._alive.append(alive)
        outside = ctypes.c_int64.from_address(addresses[-1]) if CHECKED else ctypes.c_int64()
        for entry, one, address in zip(entries, called, addresses, strict=False):
            entry.native = _Native(one, address, outside)

    def _key(self, entries: Sequence[Entry], *, quick: bool = False) -> str:
        about = f"{host()}\n{self._about(entries, quick=quick)}"
        return sha256(about.encode()).hexdigest()

    def _about(self, entries: Sequence[Entry], *, quick: bool = False) -> str:
        how = f"{'quickly' if quick else self.in_vectors} {CHECKED}"
        return f"{how}\n{origin(entry.py_func for entry in entries)}"

    def _kept(self, entries: Sequence[Entry], *, quick: bool = False) -> bytes:
        """Machine code; processes that need the same wait for the first."""
        key = self._key(entries, quick=quick)
        code = cache.read(_KIND, key)
        if code is None:
            with cache.alone(_KIND):
                code = cache.read(_KIND, key)
                if code is None:
                    code = self._made(entries, quick=quick)
                    cache.write(_KIND, key, code)
        return code

    def _at_hand(self, entries: Sequence[Entry]) -> bytes | None:
        """Optimised machine code that was kept, or came with the installation, which is kept then:
        the text that it may be known by takes 0.1 s to write.
        """
        key = self._key(entries)
        code = cache.read(_KIND, key)
        if code is None and shipped.FOLDER.is_dir():
            code = shipped.read(self._about(entries)) or shipped.read(self._text(entries))
            if code is not None:
                cache.write(_KIND, key, code)
        return code

    def _made(self, entries: Sequence[Entry], *, quick: bool) -> bytes:
        text = self._text(entries)
        return quickly(text) if quick else optimised(text, in_vectors=self.in_vectors)

    def _text(self, entries: Sequence[Entry]) -> str:
        return module_text([entry.py_func for entry in entries], checked=CHECKED)


class Entry:
    """A compiled function; `py_func`: what it was made from."""

    def __init__(self, function: FunctionType, unit: Compiler) -> None:
        functools.update_wrapper(self, function)
        note(function)
        self.py_func = function
        self.native: _Native | None = None
        self._unit = unit
        unit.entries.append(self)

    def __call__(self, *given: object) -> object:
        """Run it.

        Raises
        ------
        TypeError
            An argument is not what the annotations say.
        """
        if self.native is None:
            self._unit.prepare()
        assert self.native is not None
        if not self._unit.is_quick:
            return self.native(given)
        began = time.perf_counter()
        result = self.native(given)
        self._unit.spent(time.perf_counter() - began)
        return result


class _Native:
    """Machine code; it holds no lock of Python's."""

    def __init__(self, called: Signature, address: int, outside: ctypes.c_int64) -> None:
        self._run, self._outside = _PROTOTYPE(address), outside
        self._kinds = tuple(called.parameters.values())
        self._words = struct.Struct("".join(map(_format, self._kinds)))
        result = called.result
        if result != NOTHING and not isinstance(result, Number):
            raise TypeError(f"{called.symbol} returns {result}, which only compiled ones may")
        self._result = result

    def __call__(self, given: tuple[object, ...]) -> object:
        words: list[Any] = []
        for kind, value in zip(self._kinds, given, strict=True):
            _pack(kind, value, words)
        size = self._words.size
        memory = ctypes.create_string_buffer(size + _WORD)
        self._words.pack_into(memory, 0, *words)
        address = ctypes.addressof(memory)
        self._run(address, address + size)
        if self._outside.value:
            raise IndexError("an index of a compiled function is out of bounds")
        if self._result == NOTHING:
            return None
        (found,) = struct.unpack_from("d" if self._result == FLOAT else "q", memory, size)
        return bool(found) if self._result == TRUTH else found


def _format(kind: Type) -> str:
    """The words of a value, as `struct` has them."""
    if isinstance(kind, Record):
        return "".join(map(_format, kind.fields))
    if isinstance(kind, Array):
        return "q" * (1 + kind.rank)
    return "d" if kind == FLOAT else "q"


def _pack(kind: Type, value: Any, words: list[Any]) -> None:
    """Append the words of a value."""
    if isinstance(kind, Array):
        if value.dtype != kind.numpy or value.ndim != kind.rank:
            raise TypeError(f"{value.dtype} {value.shape} is no {kind}")
        words.append(_address_of(_memory_of(value)))
        words += value.shape
    elif isinstance(kind, Record):
        for part, inner in zip(kind.fields, value, strict=True):
            _pack(part, inner, words)
    else:
        words.append(value)
