"""What a function in a `.ll` file may not contain, found in its text before anything is optimised:
one message each, with its line.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Protocol

import networkx as nx

from vividc.errors import KernelError, SourceLoc
from vividc.frontend.c.source import Body, without_strings
from vividc.frontend.llvm.layout import offsets
from vividc.frontend.llvm.tokens import Cursor, Structs, bare
from vividc.ssa.ir import Int


class Locate(Protocol):
    """Source lines: of an instruction's text, and of a function's `define` line."""

    def __call__(self, line: str) -> SourceLoc | None: ...

    def definition(self, header: str) -> SourceLoc | None: ...


_NAMES = re.compile(r'[%@](?:"[^"]*"|[-\w$.]+)')
_CALLEE = re.compile(r'([%@](?:"[^"]*"|[-\w$.]+))\(')
_REFERENCE = re.compile(r'@(?:"[^"]*"|[-\w$.]+)')
_WIDTH = re.compile(r"\bi(\d+)\b")
_WIDTHS = frozenset({"1", "8", "16", "32", "64"})
_WORDS = "use int32_t, uint32_t and float"
_GLOBAL = re.compile(r'^(?:(?:define|declare) .*?)?(@(?:"[^"]*"|[-\w$.]+))(?:\(| =)', re.MULTILINE)
_FAR = 1 << 31
_BY_VALUE = re.compile(r"\b(?:byval|sret|inalloca)\b")


@dataclass(frozen=True, slots=True)
class _Rule:
    pattern: re.Pattern[str]
    reason: str
    hint: str


def _rule(pattern: str, reason: str, hint: str) -> _Rule:
    return _Rule(re.compile(pattern), reason, hint)


_RULES = (
    _rule(
        r"<(?:vscale x )?\d+ x ",
        "vectors, which the array has not",
        "compile with -O1, or with -fno-vectorize -fno-slp-vectorize",
    ),
    _rule(
        r"\b(?:cmpxchg|atomicrmw|fence)\b|\b(?:load|store) atomic\b",
        "an atomic operation",
        "a kernel runs alone: use plain loads and stores",
    ),
    _rule(
        r"\balloca\b.*, i(?:32|64)\s*(?:,|$)",
        "a local array of variable size",
        "give it a constant size, or pass the array as a parameter",
    ),
    _rule(r"\baddrspace\b", "a pointer to another address space", "use plain pointers"),
    _rule(r"\bva_arg\b", "variable arguments", "pass an array and its length"),
    _rule(r"\basm\b", "inline assembly", "write the operation in C"),
    _rule(
        r"\b(?:invoke|landingpad|resume|catchswitch|cleanuppad)\b",
        "C++ exceptions",
        "compile with -fno-exceptions",
    ),
    _rule(r"\b(?:indirectbr|callbr)\b", "a computed goto", "use a switch"),
    _rule(r"\b(?:x86_fp80|fp128|ppc_fp128)\b", "long double arithmetic", "use float"),
    _rule(r"\b(?:half|bfloat)\b", "arithmetic on 16-bit floats", "use float"),
)


def reachable(body: Body, all_bodies: Mapping[str, Body]) -> tuple[Body, ...]:
    """`body` and the functions of the file that it calls, directly or not."""
    reached = {body.name: body}
    pending = [body]
    while pending:
        for line in pending.pop().lines[1:]:
            for callee in _referenced(line):
                if callee in all_bodies and callee not in reached:
                    reached[callee] = all_bodies[callee]
                    pending.append(all_bodies[callee])
    return tuple(reached.values())


def _referenced(line: str) -> Iterator[str]:
    for match in _REFERENCE.finditer(without_strings(line)):
        yield bare(match[0])


def check_body(body: Body, structs: Structs, locate: Locate) -> None:
    """Refuse what the array cannot run.

    Parameters
    ----------
    structs
        The module's.
    locate
        Source line of an instruction's text.

    Raises
    ------
    KernelError
        With the line of the first such instruction.
    """
    header, *lines = body.lines
    place = locate.definition(header)
    if "..." in without_strings(header):
        raise KernelError("variable arguments", loc=place, hint="pass an array and its length")
    if "addrspace" in _NAMES.sub("", without_strings(header)):
        raise KernelError(
            "a pointer to another address space", loc=place, hint="use plain pointers"
        )
    if _BY_VALUE.search(_NAMES.sub("", without_strings(header))):
        hint = "pass a pointer to an array, or its members"
        raise KernelError("a structure passed or returned by value", loc=place, hint=hint)
    for line in lines:
        _check_line(line, locate)
        if "getelementptr" in line and _is_far(line, structs):
            hint = "an array lies in the machine's 32-bit memory"
            raise _refused("an address 2 GiB or more away from its array", hint, line, locate)


def _is_far(line: str, structs: Structs) -> bool:
    """Whether a constant offset is cut where addresses have 32 bits."""
    cursor = Cursor(without_strings(line), structs)
    while cursor.peek:
        if cursor.take() == "getelementptr":
            cursor.skip_flags()
            cursor.accept("(")
            element, args = cursor.address()
            indices, strides = offsets(element, args[1:], structs) or ((), ())
            constants = [
                index.value * stride if isinstance(index, Int) else stride
                for index, stride in zip(indices, strides, strict=True)
            ]
            if any(abs(number) >= _FAR for number in (sum(constants), *constants)):
                return True
    return False


def _check_line(line: str, locate: Locate) -> None:
    code = without_strings(line)
    if not code.strip() or code.rstrip().endswith(":"):
        return
    plain = _NAMES.sub("", code)
    for rule in _RULES:
        if rule.pattern.search(plain):
            raise _refused(rule.reason, rule.hint, line, locate)
    for width in _WIDTH.findall(plain):
        if width not in _WIDTHS:
            raise _refused(*_odd_integer(int(width)), line, locate)
    if re.search(r"\bcall\b", plain):
        _check_call(code, line, locate)


def _odd_integer(width: int) -> tuple[str, str]:
    if width > 64:  # noqa: PLR2004 - the widest integer that narrowing knows
        return f"integers of {width} bits", _WORDS
    return (
        f"integers of {width} bits, by which clang computes a sum without its loop",
        "compile with -mllvm -replexitval=never",
    )


_CALLS = (
    (
        ("setjmp", "_setjmp", "sigsetjmp", "__sigsetjmp", "longjmp", "_longjmp", "siglongjmp"),
        "a call of `{}`, which leaves functions without a return",
        "leave loops by conditions, and return",
    ),
    (
        ("llvm.threadlocal",),
        "a thread-local variable",
        "pass it as a parameter",
    ),
)
"""Beginnings of callees that are told as something else than a function that is missing."""


def _check_call(code: str, line: str, locate: Locate) -> None:
    callee = _CALLEE.search(code[code.index("call") :])
    if callee is None or callee[1][0] == "%":
        hint = "call functions of the same file by their names"
        raise _refused("a call through a pointer", hint, line, locate)
    name = bare(callee[1])
    for names, reason, hint in _CALLS:
        if name.startswith(names):
            raise _refused(reason.format(name), hint, line, locate)
    if "..." in code[: code.index(callee[0])]:
        hint = "a kernel stores its results into arrays"
        raise _refused(f"a call of `{name}`, which takes variable arguments", hint, line, locate)


def refuse_recursion(bodies: tuple[Body, ...], locate: Locate) -> None:
    """Refuse functions that call themselves, directly or not.

    Raises
    ------
    KernelError
        With the line of a call that leads back to its function.
    """
    known = {body.name for body in bodies}
    calls = [
        (body.name, callee, line)
        for body in bodies
        for line in body.lines[1:]
        for callee in _referenced(line)
        if callee in known
    ]
    graph = nx.DiGraph((caller, callee) for caller, callee, _ in calls)
    cycle_of = {
        name: number
        for number, names in enumerate(nx.strongly_connected_components(graph))
        for name in names
    }
    for caller, callee, line in calls:
        if cycle_of[caller] == cycle_of[callee]:
            hint = "write it as a loop, with a stack in an array if it needs one"
            raise _refused(f"recursion through `{callee}`", hint, line, locate)


def refuse_own_names(text: str, file: str) -> None:
    """Refuse a module with names of the compiler's own.

    Raises
    ------
    KernelError
        A global's name begins with "vividc.".
    """
    for match in _GLOBAL.finditer(text):
        name = bare(match[1])
        if name.startswith("vividc."):
            reason = f"the name `{name}`: names that begin with `vividc.` are the compiler's"
            raise KernelError(reason, loc=file, hint="give it another name")


def _refused(reason: str, hint: str, line: str, locate: Locate) -> KernelError:
    return KernelError(reason, loc=locate(line), hint=hint)
