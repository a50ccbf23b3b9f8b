"""What numba refuses, in the user's words: the construct, its line, and what to write instead.

Numba says which function it could not type; the source says which construct was meant. Asked only
after numba has refused, so that nothing that compiles is ever refused here.
"""

from __future__ import annotations

import ast
import builtins
import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain

from vividc.errors import KernelError, SourceLoc
from vividc.frontend.refused.numpy import refused_calls, refused_on
from vividc.frontend.refused.refusals import Refusal, in_words
from vividc.frontend.refused.source import AnyFunction, KernelSource, source_of
from vividc.lang.formats import MISUSE
from vividc.lang.numba_words import lines_passed

_ESCAPE = re.compile(r"\x1b\[[0-9;]*m")
_PLACE = re.compile(r'File "(?P<file>[^"]+)", line (?P<line>\d+)')
_AT = re.compile(r" at (?P<file>/\S+) \((?P<line>\d+)\)")
_UNTYPED = re.compile(r"Untyped global name '(?P<name>\w+)'.*?(?:<class '(?P<kind>[\w.]+)'>|$)")
_UNDEFINED = re.compile(r"name '(?P<name>\w+)' is not defined")
_TRY = re.compile("exception_match|`try` cannot run")
_TYPED = re.compile(r">>> (?P<name>[\w.]+)\(")
_MISUSE = re.compile(rf"\b{MISUSE}(?P<what>.+)")

_ARRAY = "use an array, np.zeros(16, np.float32), or a tuple of constants"


@dataclass(frozen=True, slots=True)
class _Rule:
    what: str
    hint: str


_CONSTANT = "give it a constant text, and name no cause"
_NODES: dict[type[ast.AST], _Rule] = {
    ast.Dict: _Rule("a dict", "use an array, with the keys as indices"),
    ast.DictComp: _Rule("a dict", "use an array, with the keys as indices"),
    ast.Set: _Rule("a set", "use an array of flags, np.zeros(64, np.bool_), or a tuple"),
    ast.SetComp: _Rule("a set", "use an array of flags, np.zeros(64, np.bool_)"),
    ast.List: _Rule("a list", _ARRAY),
    ast.ListComp: _Rule(
        "a list comprehension", "fill an array, np.zeros(16, np.float32), in a loop"
    ),
    ast.GeneratorExp: _Rule("a generator expression", "write a loop"),
    ast.JoinedStr: _Rule("a string", "strings are for the host: use integers"),
    ast.Assert: _Rule("this `assert`", "give it a constant text"),
    ast.Try: _Rule("`try`", "the array has no exceptions: test the condition beforehand"),
    ast.Raise: _Rule("this `raise`", _CONSTANT),
    ast.With: _Rule("`with`", "resources are for the host: open and close them around the kernel"),
    ast.Delete: _Rule("`del`", "a variable needs no deletion, and an array keeps its length"),
    ast.Yield: _Rule("`yield`", "write results into an array"),
    ast.YieldFrom: _Rule("`yield`", "write results into an array"),
    ast.Await: _Rule("`await`", "a kernel runs by itself: wait on the host"),
    ast.ClassDef: _Rule("a class", "use scalars and arrays, one for each field"),
    ast.Global: _Rule("`global`", "return the value, or keep it in an array"),
    ast.Nonlocal: _Rule("`nonlocal`", "return the value, or keep it in an array"),
    ast.Import: _Rule("`import`", "import at the top of the file"),
    ast.ImportFrom: _Rule("`import`", "import at the top of the file"),
    ast.Match: _Rule("`match`", "use if and elif"),
    ast.NamedExpr: _Rule("`:=`", "assign in a statement of its own"),
    ast.Starred: _Rule("`*` in a list of values", "write the values one by one"),
}
_CALLS = {
    "print": _Rule("`print`", "store the values into an array, and print that on the host"),
    "input": _Rule("`input`", "pass the values as parameters"),
    "open": _Rule("`open`", "read the file on the host, and pass an array"),
    "reversed": _Rule("`reversed`", "count down: range(n - 1, -1, -1)"),
    "map": _Rule("`map`", "write a loop"),
    "filter": _Rule("`filter`", "write a loop with an if"),
    "sorted": _Rule("`sorted`", "write a sort, or sort on the host"),
    "isinstance": _Rule("`isinstance`", "the signature fixes all types"),
    "dict": _Rule("a dict", "use an array, with the keys as indices"),
    "set": _Rule("a set", "use an array of flags, np.zeros(64, np.bool_)"),
    "list": _Rule("a list", _ARRAY),
    **dict.fromkeys(
        ("str", "chr", "ord", "repr", "format"),
        _Rule("a string", "strings are for the host: use integers"),
    ),
    "complex": _Rule("a complex number", "use two floats"),
    **{
        name: _Rule(f"`{name}`", "names and code are for the host: write what it would compute")
        for name in ("eval", "exec", "globals", "locals", "vars", "super", "compile")
    },
    **{
        name: _Rule(f"`{name}`", "the signature fixes all types")
        for name in ("type", "callable", "issubclass")
    },
    **{
        name: _Rule(f"`{name}`", "objects are for the host: pass numbers and arrays")
        for name in ("id", "object", "memoryview", "iter", "next")
    },
    **dict.fromkeys(
        ("frozenset",), _Rule("a set", "use an array of flags, np.zeros(64, np.bool_)")
    ),
    "bytearray": _Rule("`bytearray`", "use an array: np.zeros(16, np.uint8)"),
    "any": _Rule("`any` of Python", "of an array, (x > 0).any(); else write the loop"),
    "all": _Rule("`all` of Python", "of an array, (x > 0).all(); else write the loop"),
}
_ENDLESS = (_CALLS["map"], _CALLS["filter"], _NODES[ast.Yield], _NODES[ast.GeneratorExp])
"""What numba makes loops of that seem to have no end."""
_LINEAR_ALGEBRA = _Rule("numba's linear algebra", "write the loops over rows and columns")
_COMPLEX = _Rule("a complex number", "use two floats")
_STRING = _Rule("a string", "strings are for the host: use integers")
_RECURSION = _Rule("a recursive call", "use a loop, with an array as its stack")


@dataclass(frozen=True, slots=True)
class _Finding:
    line: int
    rule: _Rule


def diagnose(error: Exception, loc: SourceLoc, name: str) -> KernelError:
    """The error that a user sees for one of numba's.

    Parameters
    ----------
    error
        What numba raised.
    loc
        Where the kernel is defined.
    name
        Name of the kernel's Python function.
    """
    text = _ESCAPE.sub("", str(error))
    source = source_of(loc, name)
    lines = _lines_named(error, text, loc, source)
    place = SourceLoc(loc.file, lines[-1]) if lines else loc
    named = _named(text, place, loc, source)
    if named is not None:
        return named
    findings = [f for f in _findings(source, lines) if not _is_beside(f, text, source)]
    findings.sort(key=lambda f: (f.line not in lines, f.line))
    precise = bool(lines) and source is not None and source.is_statement(lines[-1])
    if findings and (findings[0].line in lines or not precise):
        return _refusal(loc.file, findings[0])
    global_ = _UNTYPED.search(text)
    if global_ is not None:
        return _of_global(global_["name"], global_["kind"] or "", place)
    return in_words(Refusal(text, type(error).__name__, place.line, source), place)


def _named(
    text: str, place: SourceLoc, loc: SourceLoc, source: KernelSource | None
) -> KernelError | None:
    """The error where numba's words name what it is about."""
    global_ = _UNTYPED.search(text)
    if global_ is not None and not hasattr(builtins, global_["name"]):
        return _of_global(global_["name"], global_["kind"] or "", place)
    misuse = _MISUSE.search(text)
    if misuse is not None:
        calls = () if source is None else refused_calls(source.tree)
        for line, what, hint in calls:  # numpy's functions keep lists of their own
            if line == place.line:
                return _refusal(loc.file, _Finding(line, _Rule(what, hint)))
        reason, _, hint = misuse["what"].partition(": ")
        return KernelError(reason, loc=place, hint=hint or None)
    unknown = _UNDEFINED.search(text)
    if unknown is not None:
        return _of_undefined(unknown["name"], loc, source)
    trying = None if source is None or not _TRY.search(text) else source.trying(place.line)
    if trying is not None:
        return _refusal(loc.file, _Finding(trying.lineno, _NODES[ast.Try]))
    return None


def construct_at(loc: SourceLoc, name: str, line: int | None = None) -> KernelError | None:
    """The error about the first construct of the kernel that no array runs, on `line` if given.

    Parameters
    ----------
    loc, name
        As for `diagnose`.
    """
    everywhere = _findings(source_of(loc, name), [])
    findings = [f for f in everywhere if line is None or f.line == line]
    return _refusal(loc.file, min(findings, key=lambda f: f.line)) if findings else None


def returned_at(loc: SourceLoc, name: str) -> SourceLoc:
    """Where the kernel returns a value first; its own place if nowhere."""
    source = source_of(loc, name)
    nodes = () if source is None or source.kernel is None else ast.walk(source.kernel)
    lines = [n.lineno for n in nodes if isinstance(n, ast.Return) and n.value is not None]
    return SourceLoc(loc.file, min(lines)) if lines else loc


def behind(error: KernelError, loc: SourceLoc, name: str) -> KernelError | None:
    """The construct that led to an error about what numba made of it; None: the error says it.

    Parameters
    ----------
    error
        What was found in numba's code: a call of its runtime, an exception, an allocation.
    loc, name
        As for `diagnose`.
    """
    source = source_of(loc, name)
    if "never ends" in error.reason:
        endless = (f for f in _findings(source, []) if f.rule in _ENDLESS)
        named = next((_refusal(loc.file, finding) for finding in endless), None)
        return named or _endless_loop(error, loc, source)
    if source is None or not isinstance(error.loc, SourceLoc) or error.loc.file != loc.file:
        return None
    line = _line_of(error.loc, source)
    findings = [f for f in _findings(source, [line]) if f.line == line]
    calls = source.calls_on(line)
    if "call" in error.reason:
        return _refusal(loc.file, findings[0]) if findings else _of_call(error, calls)
    if not any(text in error.reason for text in _HIDDEN):
        return None
    called = {what for at, what, _ in refused_calls(source.tree) if at == line}
    findings = [f for f in findings if f.rule.what in called]
    findings += [_Finding(line, _Rule(what, hint)) for what, hint in refused_on(calls)]
    if findings:
        return _refusal(loc.file, findings[0])
    return _of_unpacking(error, source, line)


def _line_of(place: SourceLoc, source: KernelSource) -> int:
    """A place's line; of the head of a function, which numba names for code of its own, that of the
    first call of the kernel that no array runs.
    """
    if source.kernel is None or source.is_statement(place.line):
        return place.line
    return next((line for line, _, _ in refused_calls(source.kernel)), place.line)


def _endless_loop(
    error: KernelError, loc: SourceLoc, source: KernelSource | None
) -> KernelError | None:
    """The error with the line of the first loop over a constant, if there is one."""
    nodes = () if source is None or source.kernel is None else ast.walk(source.kernel)
    loops = (n for n in nodes if isinstance(n, ast.While) and isinstance(n.test, ast.Constant))
    lines = [loop.lineno for loop in loops if not any(_leaves(node) for node in ast.walk(loop))]
    if not lines:
        return None
    return KernelError(error.reason, loc=SourceLoc(loc.file, min(lines)), hint=error.hint)


def _leaves(node: ast.AST) -> bool:
    return isinstance(node, ast.Break | ast.Return)


_HIDDEN = ("can raise", "not known at launch", "kept for the next", "local array or tuple")
"""What is said of numba's code where a user wrote a call."""


def _of_call(error: KernelError, calls: list[ast.Call]) -> KernelError | None:
    """A call of numba's, by the name of the only call on its line that leads to one."""
    names = [
        ast.unparse(call.func)
        for call in calls
        if isinstance(call.func, ast.Attribute) and not call.func.attr.startswith(_CASTS)
    ]
    if len(names) != 1:
        return None
    return KernelError(f"`{names[0]}` cannot run on the array", loc=error.loc, hint=error.hint)


_CASTS = ("int", "uint", "float", "bool")


def _of_unpacking(error: KernelError, source: KernelSource, line: int) -> KernelError | None:
    """An array that is unpacked like a tuple."""
    statements = (n for n in source.on_line(line) if isinstance(n, ast.Assign))
    if not error.reason.endswith("can raise ValueError") or not any(
        isinstance(target, ast.Tuple | ast.List) for n in statements for target in n.targets
    ):
        return None
    hint = "take its elements by index: a = x[0]; b = x[1]"
    return KernelError("an array that is unpacked into variables", loc=error.loc, hint=hint)


def _refusal(file: str, finding: _Finding) -> KernelError:
    reason = f"{finding.rule.what} cannot run on the array"
    return KernelError(reason, loc=SourceLoc(file, finding.line), hint=finding.rule.hint)


def _of_undefined(unknown: str, loc: SourceLoc, source: KernelSource | None) -> KernelError:
    nodes = () if source is None else ast.walk(source.kernel or source.tree)
    lines = [n.lineno for n in nodes if isinstance(n, ast.Name) and n.id == unknown]
    place = SourceLoc(loc.file, min(lines)) if lines else loc
    return KernelError(f"`{unknown}` is not defined", loc=place, hint="define or import it")


def _lines_named(
    error: Exception, text: str, loc: SourceLoc, source: KernelSource | None
) -> list[int]:
    """Lines of the kernel's file that numba names, from the outer to the inner fault: its messages
    go so; if they name none, notes of what it was doing, or the code it was at, do.
    """
    shown = [
        int(match["line"])
        for match in _PLACE.finditer(text)
        if loc.file.endswith(match["file"].lstrip("./"))
    ]
    if shown and (source is None or source.is_statement(shown[-1])):
        return shown
    noted = [int(m["line"]) for m in _AT.finditer(text) if m["file"] == loc.file]
    passed = noted or lines_passed(error.__traceback__, loc.file)
    if source is not None:
        head = loc.line if source.kernel is None else source.kernel.lineno
        exact = [line for line in passed if source.is_statement(line)]
        passed = exact or [line for line in passed if not loc.line <= line <= head]
    return [*shown, *reversed(passed)] if passed else shown


def _is_beside(finding: _Finding, text: str, source: KernelSource | None) -> bool:
    """Whether numba fails on a call beside a string, which is an argument or stands elsewhere."""
    typed = _TYPED.search(text)
    if finding.rule is not _STRING or source is None:
        return False
    if typed is None:
        return "NumPy function" in text or "Unknown attribute" in text or "has no attr" in text
    name = typed["name"].rpartition(".")[2]
    return any(
        isinstance(call.func, ast.Attribute) and call.func.attr == name
        for call in source.calls_on(finding.line)
    )


def _findings(source: KernelSource | None, lines: list[int]) -> Iterator[_Finding]:
    """What the kernel, the functions it calls by name and those around `lines` have that no array
    runs.
    """
    for function in () if source is None else source.reached(lines):
        yield from _in_function(function)


def _in_function(function: AnyFunction) -> Iterator[_Finding]:
    if isinstance(function, ast.AsyncFunctionDef):
        yield _Finding(function.lineno, _NODES[ast.Await])
    body = function.body[1:] if ast.get_docstring(function) is not None else function.body
    for node in chain.from_iterable(ast.walk(statement) for statement in body):
        rule = _NODES.get(type(node)) or _of_expression(node, function.name)
        if rule is not None:
            yield _Finding(getattr(node, "lineno", function.lineno), rule)
    for line, what, hint in refused_calls(function):
        yield _Finding(line, _Rule(what, hint))


def _of_expression(node: ast.AST, function: str) -> _Rule | None:
    if isinstance(node, ast.Constant):
        if isinstance(node.value, str | bytes):
            return _STRING
        return _COMPLEX if isinstance(node.value, complex) else None
    if (isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult)) or (
        isinstance(node, ast.Attribute) and node.attr in ("dot", "vdot", "linalg")
    ):
        return _LINEAR_ALGEBRA
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
        return _RECURSION if node.func.id == function else _CALLS.get(node.func.id)
    return None


_PLAIN_FUNCTION = (
    "is a plain Python function",
    "decorate it with @numba.njit, or with @vividc.kernel and a signature",
)
_KINDS = {
    "function": _PLAIN_FUNCTION,
    "_lru_cache_wrapper": _PLAIN_FUNCTION,
    "": ("is not known here", "pass it as a parameter"),
    "JitClassType": ("is a class", "use scalars and arrays, one for each field"),
}


def _of_global(name: str, kind: str, place: SourceLoc) -> KernelError:
    what, hint = _KINDS.get(
        kind.rpartition(".")[2],
        (
            f"is a {kind.rpartition('.')[2]}",
            "pass arrays and scalars as parameters; constants may be numbers, "
            "tuples of them, and arrays",
        ),
    )
    if hasattr(builtins, name):
        what, hint = "is not known to numba", "write it with loops and arithmetic"
    return KernelError(f"`{name}` {what}, which a kernel cannot use", loc=place, hint=hint)
