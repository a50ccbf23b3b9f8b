"""What the machine code of some functions follows from, without making it: a key for the cache."""

from __future__ import annotations

import functools
import re
import sys
from collections.abc import Iterable
from hashlib import sha256
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any, Final

from vividc.host.machine_code.unit import compiled_by

_NAMES: Final = re.compile(r"[A-Za-z_]\w*")


def origin(entries: Iterable[FunctionType]) -> str:
    """A hash of functions that Python calls and of all that these call: their bytecode, what their
    names mean, and this folder, which makes LLVM IR of them. It takes a twentieth of the time that
    the IR takes.
    """
    found = _Found()
    for entry in entries:
        found.add_function(entry)
    return sha256("\n".join((sys.version, _folder(), *found.lines)).encode()).hexdigest()


@functools.cache
def _folder() -> str:
    files = sorted(Path(__file__).parent.glob("*.py"))
    return sha256(b"\n".join(file.read_bytes() for file in files)).hexdigest()


class _Found:
    """What was met so far, each function and each named tuple once."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self._seen: set[object] = set()

    def add_function(self, function: FunctionType) -> None:
        """A function, and what it calls."""
        if function in self._seen:
            return
        self._seen.add(function)
        code: CodeType = function.__code__
        parts = (code.co_code, code.co_consts, code.co_names, code.co_varnames)
        self.lines.append(f"{function.__module__}.{function.__qualname__} {parts}")
        for name, annotation in function.__annotations__.items():
            self._add_annotation(name, annotation, function.__globals__)
        for name in code.co_names:
            self._add_name(name, function.__globals__.get(name), code.co_names)

    def _add_name(self, name: str, value: Any, names: Iterable[str]) -> None:
        """What a name of a function means that is no variable; of a module's names, those that the
        function has as well.
        """
        called = compiled_by(value)
        if called is not None:
            self.lines.append(f"{name} calls {called.__module__}.{called.__qualname__}")
            self.add_function(called)
        elif isinstance(value, ModuleType):
            for attribute in names:
                self._add_number(f"{name}.{attribute}", getattr(value, attribute, None))
        elif isinstance(value, type) and hasattr(value, "_fields"):
            self.lines.append(f"{name} is {value.__module__}.{value.__qualname__}")
            self._add_tuple(value)
        else:
            self._add_number(name, value)

    def _add_number(self, name: str, value: Any) -> None:
        if isinstance(value, (int, float)):
            self.lines.append(f"{name} = {value!r}")

    def _add_annotation(self, name: str, annotation: Any, names: dict[str, Any]) -> None:
        text = getattr(annotation, "__forward_arg__", annotation)
        self.lines.append(f"{name}: {text}")
        for part in _NAMES.findall(text) if isinstance(text, str) else ():
            meant = names.get(part)
            if isinstance(meant, type) and hasattr(meant, "_fields"):
                self._add_tuple(meant)
            elif meant is not None:
                self.lines.append(f"{part} is {meant}")

    def _add_tuple(self, cls: type) -> None:
        if cls in self._seen:
            return
        self._seen.add(cls)
        names = getattr(sys.modules.get(cls.__module__), "__dict__", {})
        self.lines.append(f"{cls.__module__}.{cls.__qualname__}")
        for name, annotation in cls.__annotations__.items():
            self._add_annotation(name, annotation, names)
