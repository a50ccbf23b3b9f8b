"""Which functions can be compiled, and the module of some of them."""

from __future__ import annotations

import ast
import functools
import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from types import FunctionType
from typing import Final, TypeVar, cast, get_type_hints

from vividc.host.machine_code.body import OUTSIDE, Body
from vividc.host.machine_code.statements import Statements
from vividc.host.machine_code.types import TRUTH, Record, Type, parts, type_of, words

_Function = TypeVar("_Function", bound=Callable[..., object])

_DECLARATIONS: Final = """declare double @llvm.log.f64(double)
declare double @llvm.exp.f64(double)
declare i64 @llvm.abs.i64(i64, i1)
declare i64 @llvm.ctlz.i64(i64, i1)
!0 = !{}
"""
_OUTSIDE: Final = f"@{OUTSIDE} = global i64 0"
_file_of: Final[dict[FunctionType, _File]] = {}
"""The file of each function that can be compiled, as it was when the function was made."""


def inlined(function: _Function) -> _Function:
    """Have compiled functions call this one, in their machine code; called by Python it is Python.

    LLVM decides which calls it puts the function's code in place of.
    """
    note(cast(FunctionType, function))
    return function


def note(function: FunctionType) -> None:
    """Remember that a function can be compiled, and how its file reads now."""
    name = function.__code__.co_filename
    status = os.stat(name)
    _file_of[function] = _read(name, status.st_mtime_ns, status.st_size)


def compiled_by(value: object) -> FunctionType | None:
    """The function that compiled ones call by this value, or None."""
    for one in (value, getattr(value, "py_func", None)):
        if isinstance(one, FunctionType) and one in _file_of:
            return one
    return None


class _File:
    """The functions of a file by their first lines, decorators among them."""

    def __init__(self, text: str) -> None:
        self._text = text

    @functools.cached_property
    def functions(self) -> dict[int, ast.FunctionDef]:
        """See the class."""
        nodes = (n for n in ast.walk(ast.parse(self._text)) if isinstance(n, ast.FunctionDef))
        return {min(n.lineno, *(d.lineno for d in n.decorator_list), n.lineno): n for n in nodes}


@functools.cache
def _read(name: str, _changed_ns: int, _size: int) -> _File:
    return _File(Path(name).read_text(encoding="utf-8"))


@dataclass(frozen=True, slots=True)
class Signature:
    """A function's name in its module, its parameters, and what it returns."""

    symbol: str
    parameters: dict[str, Type]
    result: Type

    @property
    def door(self) -> str:
        """The name of the function that Python calls: it gets the address of all words of the
        arguments, and of the word that the result goes to.
        """
        return f"door {self.symbol}"


@functools.cache
def signature(function: FunctionType) -> Signature:
    """What the annotations say.

    Raises
    ------
    TypeError
        They say nothing that is compiled.
    """
    hints = get_type_hints(function, include_extras=True)
    result = type_of(hints.pop("return"))
    parameters = {name: type_of(hint) for name, hint in hints.items()}
    return Signature(f"{function.__module__}.{function.__qualname__}", parameters, result)


def module_text(entries: Iterable[FunctionType], *, checked: bool = False) -> str:
    """LLVM IR of functions that Python calls, and of all that these call; `checked`: with the
    variable `OUTSIDE`, which tells whether an index was out of bounds.

    Raises
    ------
    TypeError
        Something in them is not compiled; the text says where.
    """
    waiting = list(entries)
    doors = [_door(signature(entry)) for entry in waiting]
    seen, texts = set(waiting), []

    def callee(function: FunctionType) -> Signature | None:
        if function not in _file_of:
            return None
        if function not in seen:
            seen.add(function)
            waiting.append(function)
        return signature(function)

    while waiting:
        texts.append(_function(waiting.pop(), callee, checked))
    return "\n".join((_DECLARATIONS, *[_OUTSIDE] * checked, *texts, *doors))


def _function(
    function: FunctionType, callee: Callable[[FunctionType], Signature | None], checked: bool
) -> str:
    code, called = function.__code__, signature(function)
    given = [
        f"{llvm} %{name}.{place}"
        for name, kind in called.parameters.items()
        for place, llvm in enumerate(parts(kind))
    ]
    statements = Statements(function, callee, Body(checked))
    try:
        node = _file_of[function].functions[code.co_firstlineno]
        statements.write(called.parameters, called.result, node.body)
    except TypeError as fault:
        raise TypeError(f"{code.co_filename}, {code.co_name}, {fault}") from fault
    head = f'define internal {returned(called.result)} @"{called.symbol}"({", ".join(given)}) {{'
    return "\n".join((head, *statements.lines(), "}"))


def returned(result: Type) -> str:
    """The LLVM type of a result."""
    llvm = parts(result)
    if len(llvm) == 1:
        return llvm[0]
    return f"{{ {', '.join(llvm)} }}" if llvm else "void"


def _door(called: Signature) -> str:
    body, given, first = Body(), [], 0
    for kind in called.parameters.values():
        value = body.loaded(kind, body.at("%words", first))
        given += [f"{llvm} {part}" for llvm, part in zip(parts(kind), value.parts, strict=True)]
        first += words(kind)
    call = f'call {returned(called.result)} @"{called.symbol}"({", ".join(given)})'
    if isinstance(called.result, Record):  # nothing: see `door`
        body.do(call)
    else:
        (llvm,) = parts(called.result)
        found = body.new(call)
        if called.result == TRUTH:
            found, llvm = body.new(f"zext i1 {found} to i64"), "i64"
        body.do(f"store {llvm} {found}, ptr %result")
    body.end("ret void")
    head = f'define void @"{called.door}"(ptr %words, ptr %result) {{'
    return "\n".join((head, "entry:", *body.lines, "}"))
