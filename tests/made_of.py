"""What a function's machine code is made from, as one hash: two functions of equal hashes are the
same code over the same constants, whatever files they are in.

Taken from the functions in memory and not from their files, which may have been edited since.
"""

from __future__ import annotations

import enum
from collections.abc import Iterator, Sequence
from hashlib import sha256
from types import CodeType, FunctionType, ModuleType

import numpy as np


def made_of(function: FunctionType) -> str:
    """A hash of a function, of all functions that it calls, and of the constants that they read."""
    text = sha256()
    waiting, seen = [function], {id(function)}
    while waiting:
        made = waiting.pop()
        given = (made.__defaults__, *sorted((made.__kwdefaults__ or {}).items()))
        text.update(f"{made.__module__}.{made.__qualname__}{_written(given)}\n".encode())
        for part in _code(made.__code__):
            text.update(part.encode("utf-8", "surrogatepass") + b"\n")
        for name, value in _reads(made):
            called = _python_function(value)
            text.update(f"{name}={_written(value) if called is None else '()'}\n".encode())
            for inner in _functions_in(value):
                if id(inner) not in seen:
                    seen.add(id(inner))
                    waiting.append(inner)
    return text.hexdigest()


def _code(code: CodeType) -> Iterator[str]:
    yield code.co_code.hex()
    yield repr((code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars))
    yield repr((code.co_argcount, code.co_kwonlyargcount, code.co_flags, code.co_exceptiontable))
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _code(constant)
        else:
            yield _written(constant)


def _reads(function: FunctionType) -> Iterator[tuple[str, object]]:
    """Names of other places that a function uses, with what they are."""
    closure = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    for name, cell in closure:
        yield name, _content(cell)
    names = sorted(_names(function.__code__))
    for name in names:
        value = function.__globals__.get(name)
        yield name, value
        if isinstance(value, ModuleType):
            yield from _of_module(name, value, names, {value})


def _of_module(
    name: str, module: ModuleType, names: Sequence[str], seen: set[ModuleType]
) -> Iterator[tuple[str, object]]:
    """What the names may mean in a module, and in the modules in it."""
    for of in names:
        value = vars(module).get(of)
        yield f"{name}.{of}", value
        if isinstance(value, ModuleType) and value not in seen:
            seen.add(value)
            yield from _of_module(f"{name}.{of}", value, names, seen)


def _content(cell: object) -> object:
    try:
        return cell.cell_contents  # type: ignore[attr-defined]
    except ValueError:  # not yet
        return None


def _names(code: CodeType) -> set[str]:
    inner = (_names(constant) for constant in code.co_consts if isinstance(constant, CodeType))
    return {*code.co_names}.union(*inner)


def _python_function(value: object) -> FunctionType | None:
    """The function itself, or that of numba's dispatcher; numba's and numpy's have versions."""
    function = getattr(value, "py_func", value)
    if not isinstance(function, FunctionType):
        return None
    return None if function.__module__.split(".")[0] in ("numba", "numpy") else function


def _functions_in(value: object) -> Iterator[FunctionType]:
    """The function that a value is, or those of a tuple."""
    if isinstance(value, tuple | list):
        for item in value:
            yield from _functions_in(item)
    elif (function := _python_function(value)) is not None:
        yield function


def _written(value: object) -> str:
    """A value such that others are written otherwise. An address in it makes it like no other."""
    kind = type(value).__name__
    if isinstance(value, frozenset):
        return f"{kind}{sorted(map(_written, value))}"
    if isinstance(value, tuple | list):
        return f"{kind}({', '.join(map(_written, value))})"
    if isinstance(value, np.ndarray):
        digest = sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
        return f"{value.dtype.descr!r}{value.shape}{value.strides}{digest}"
    return _named(value) or f"{kind} {value!r}"


def _named(value: object) -> str | None:
    """Modules, classes and functions by name, and what numba takes from a class."""
    if isinstance(value, ModuleType):
        return value.__name__
    if isinstance(value, type):
        inner = [f"{m.name}={m.value!r}" for m in value] if issubclass(value, enum.Enum) else []
        fields = getattr(value, "_fields", ())
        return f"{value.__module__}.{value.__qualname__}{fields!r}{inner!r}"
    if callable(value):
        return f"{getattr(value, '__module__', '')}.{getattr(value, '__qualname__', repr(value))}"
    return None
