"""What numba refuses, in the user's words: the construct, its line, and what to write instead.

Numba says which function it could not type; the source says which construct was meant. Asked only
after numba has refused, so that nothing that compiles is ever refused here.
"""

from __future__ import annotations

import ast
import builtins
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain

from vividc.errors import KernelError, SourceLoc
from vividc.frontend.lang_formats import MISUSE
from vividc.frontend.numpy_refused import refused_calls

_ESCAPE = re.compile(r"\x1b\[[0-9;]*m")
_PLACE = re.compile(r'File "(?P<file>[^"]+)", line (?P<line>\d+)')
_UNTYPED = re.compile(r"Untyped global name '(?P<name>\w+)'.*?(?:<class '(?P<kind>[\w.]+)'>|$)")
_UNDEFINED = re.compile(r"name '(?P<name>\w+)' is not defined")
_FROZEN = re.compile(r"assigned to variable '(?P<name>\w+)' in globals")
_UNKNOWN = re.compile(r">>> (?P<call>.+)")
_MISUSE = re.compile(rf"\b{MISUSE}(?P<what>.+)")
_ADDRESS = re.compile(r" at 0x[0-9a-f]+")

_FLAG = "the array has no exceptions: return or store a flag instead"
_ARRAY = "use an array, np.zeros(16, np.float32), or a tuple of constants"


@dataclass(frozen=True, slots=True)
class _Rule:
    what: str
    hint: str


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
    ast.Try: _Rule("`try`", "the array has no exceptions: test the condition beforehand"),
    ast.Raise: _Rule("`raise`", _FLAG),
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
    "str": _Rule("a string", "strings are for the host: use integers"),
    "complex": _Rule("a complex number", "use two floats"),
}
_ENDLESS = (_CALLS["map"], _CALLS["filter"], _NODES[ast.Yield], _NODES[ast.GeneratorExp])
"""What numba makes loops of that seem to have no end."""
_LINEAR_ALGEBRA = _Rule("numba's linear algebra", "write the loops over rows and columns")
_COMPLEX = _Rule("a complex number", "use two floats")
_STRING = _Rule("a string", "strings are for the host: use integers")
_RECURSION = _Rule("a recursive call", "use a loop, with an array as its stack")


_RAISES = (
    ("range()", "test the step before the loop: if step < 1: return"),
    ("zero-size", "start from the first element and write the loop: best = x[0]"),
    ("empty sequence", "start from the first element and write the loop: best = x[0]"),
    ("cannot assign slice", "write the loop over the elements"),
    ("total size of new array", "index with i * columns + j instead"),
    ("axis", "name an axis that the array has"),
    ("division", "test the divisor before"),
    ("AssertionError", "test the condition on the host, or return a flag"),
)


def hint_of_raise(what: str) -> str:
    """What to write instead of what raises `what`, an exception's name and text."""
    return next((hint for text, hint in _RAISES if text in what), _FLAG)


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
    lines = _lines_named(text, loc)
    place = SourceLoc(loc.file, lines[-1]) if lines else loc
    global_ = _UNTYPED.search(text)
    if global_ is not None and not hasattr(builtins, global_["name"]):
        return _of_global(global_["name"], global_["kind"] or "", place)
    misuse = _MISUSE.search(text)
    if misuse is not None:
        reason, _, hint = misuse["what"].partition(": ")
        return KernelError(reason, loc=place, hint=hint or None)
    unknown = _UNDEFINED.search(text)
    if unknown is not None:
        return _of_undefined(unknown["name"], loc, name)
    findings = sorted(_findings(loc, name, lines), key=lambda f: (f.line not in lines, f.line))
    if findings and (findings[0].line in lines or not _is_precise(loc, lines)):
        return _refusal(loc.file, findings[0])
    if global_ is not None:
        return _of_global(global_["name"], global_["kind"] or "", place)
    return _in_numbas_words(text, type(error).__name__, place)


def construct_at(loc: SourceLoc, name: str, line: int | None = None) -> KernelError | None:
    """The error about the first construct of the kernel that no array runs, on `line` if given.

    Parameters
    ----------
    loc, name
        As for `diagnose`.
    """
    findings = [f for f in _findings(loc, name, []) if line is None or f.line == line]
    return _refusal(loc.file, min(findings, key=lambda f: f.line)) if findings else None


def behind(error: KernelError, loc: SourceLoc, name: str) -> KernelError | None:
    """The construct that led to an error about what numba made of it; None: the error says it.

    Parameters
    ----------
    error
        What was found in numba's code: a call of its runtime, an exception, an allocation.
    loc, name
        As for `diagnose`.
    """
    if "never ends" in error.reason:
        found = (f for f in _findings(loc, name, []) if f.rule in _ENDLESS)
        return next((_refusal(loc.file, finding) for finding in found), None)
    if not isinstance(error.loc, SourceLoc) or error.loc.file != loc.file:
        return None
    line = error.loc.line
    findings = [f for f in _findings(loc, name, [line]) if f.line == line]
    if "call" not in error.reason:
        tree = _parsed(loc.file)
        called = {} if tree is None else {w: h for at, w, h in refused_calls(tree) if at == line}
        hidden = any(text in error.reason for text in ("can raise", "not known at launch"))
        findings = [f for f in findings if hidden and f.rule.what in called]
    return _refusal(loc.file, findings[0]) if findings else None


def _refusal(file: str, finding: _Finding) -> KernelError:
    reason = f"{finding.rule.what} cannot run on the array"
    return KernelError(reason, loc=SourceLoc(file, finding.line), hint=finding.rule.hint)


def _of_undefined(unknown: str, loc: SourceLoc, name: str) -> KernelError:
    tree = _parsed(loc.file)
    nodes = () if tree is None else ast.walk(_kernel_in(tree, loc, name) or tree)
    lines = [n.lineno for n in nodes if isinstance(n, ast.Name) and n.id == unknown]
    place = SourceLoc(loc.file, min(lines)) if lines else loc
    return KernelError(f"`{unknown}` is not defined", loc=place, hint="define or import it")


def _lines_named(text: str, loc: SourceLoc) -> list[int]:
    """Lines of the kernel's file that numba names: its messages go from the outer to the inner
    fault.
    """
    return [
        int(match["line"])
        for match in _PLACE.finditer(text)
        if loc.file.endswith(match["file"].lstrip("./"))
    ]


def _is_precise(loc: SourceLoc, lines: list[int]) -> bool:
    """Whether numba's last line is that of a statement: it names the head for want of a better."""
    if not lines:
        return False
    tree = _parsed(loc.file)
    heads = () if tree is None else (n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef))
    return all(
        not min([n.lineno, *(d.lineno for d in n.decorator_list)]) <= lines[-1] < n.body[0].lineno
        for n in heads
    )


def _findings(loc: SourceLoc, name: str, lines: list[int]) -> Iterator[_Finding]:
    """What the kernel, the functions it calls by name and those around `lines` have that no array
    runs.
    """
    tree = _parsed(loc.file)
    if tree is None:
        return
    functions = [node for node in ast.walk(tree) if isinstance(node, _FUNCTIONS)]
    kernel = _kernel_in(tree, loc, name)
    reached = [] if kernel is None else [kernel]
    reached += [node for node in functions if any(line in _span(node) for line in lines)]
    for function in reached:  # grows as it goes
        called = {
            node.func.id
            for node in ast.walk(function)
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
        }
        reached += [f for f in functions if f.name in called and f not in reached]
    for function in dict.fromkeys(reached):
        yield from _in_function(function)


_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
_AnyFunction = ast.FunctionDef | ast.AsyncFunctionDef


def _span(function: _AnyFunction) -> range:
    """Lines of a function, its decorators included."""
    first = min([function.lineno, *(d.lineno for d in function.decorator_list)])
    return range(first, (function.end_lineno or function.lineno) + 1)


def _kernel_in(tree: ast.Module, loc: SourceLoc, name: str) -> _AnyFunction | None:
    """The definition of the kernel."""
    for node in ast.walk(tree):
        if isinstance(node, _FUNCTIONS) and node.name == name and loc.line in _span(node):
            return node
    return None


def _parsed(file: str) -> ast.Module | None:
    try:
        with open(file, encoding="utf-8") as source:
            return ast.parse(source.read())
    except (OSError, SyntaxError, ValueError):
        return None


def _in_function(function: _AnyFunction) -> Iterator[_Finding]:
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


def _of_global(name: str, kind: str, place: SourceLoc) -> KernelError:
    what, hint = {
        "function": (
            "is a plain Python function",
            "decorate it with @numba.njit, or with @vividc.kernel and a signature",
        ),
        "": ("is not known here", "pass it as a parameter"),
    }.get(
        kind,
        (
            f"is a {kind}",
            "pass arrays and scalars as parameters; constants may be numbers, "
            "tuples of them, and arrays",
        ),
    )
    if hasattr(builtins, name):
        what, hint = "is not known to numba", "write it with loops and arithmetic"
    return KernelError(f"`{name}` {what}, which a kernel cannot use", loc=place, hint=hint)


def _frozen(text: str) -> str:
    match = _FROZEN.search(text)
    name = "a global" if match is None else f"`{match['name']}`"
    return f"{name} is no number, tuple or array, which a kernel could read"


_WORDS: tuple[tuple[str, Callable[[str], str], str], ...] = (
    (
        "recursi|re-entrant",
        lambda _: "a recursive call cannot run on the array",
        "use a loop, with an array as its stack",
    ),
    (
        "not supported as globals",
        _frozen,
        "make it a tuple of numbers, or an array",
    ),
    (
        "scipy",
        lambda _: "numba's linear algebra cannot run on the array",
        "write the loops over rows and columns",
    ),
    (
        "Cannot modify readonly",
        lambda _: "a write to a global array, which is a constant",
        "pass the array as a parameter",
    ),
    (
        "NRT required",
        lambda _: "memory that numba would take from the host's heap",
        "use an array of the kernel's own, np.zeros(16, np.float32), and loops over its elements",
    ),
    (
        r"no attribute 'Literal\[int\]",
        lambda _: "a numpy function whose errors name a number (cumsum along an axis is one)",
        "write the loops over the elements",
    ),
    (
        r"setitem.*lang\.\w+",
        lambda _: "a number stored into an array of another format",
        "cast it to the array's: lang.fp16(value) to float16, np.float32(value) to float32",
    ),
    (
        r"Cannot unify .*lang\.\w+|lang\.\w+ cannot be represented",
        lambda _: "a variable that holds numbers of two formats",
        "cast where it is assigned, so that it has one format everywhere",
    ),
    (
        r">>> .*lang\.\w+",
        lambda text: f"numba has no `{_call(text)}`",
        "numbers of 16 and 8 bits have +, -, * and comparisons, one by one: np.float32(x) has all",
    ),
    (
        r"^float16$",
        lambda _: "np.float16 in a kernel",
        "write lang.fp16(x) for a number; an array of the kernel's own can be float32",
    ),
    (
        r"CPUDispatcher\(.*getitem|getitem.*type\(CPUDispatcher",
        lambda text: f"numba has no `{_call(text)}`",
        "call the functions by name, chosen by if and elif",
    ),
    (
        r"_dynfunc|_Closure object",
        lambda _: "a function taken from a tuple",
        "call the functions by name, chosen by if and elif",
    ),
    (
        "No implementation of function",
        lambda text: f"numba has no `{_call(text)}`",
        "write it with loops and arithmetic",
    ),
)


def _in_numbas_words(text: str, kind: str, place: SourceLoc) -> KernelError:
    for pattern, reason, hint in _WORDS:
        if re.search(pattern, text):
            return KernelError(reason(text), loc=place, hint=hint)
    lines = [line.strip() for line in text.splitlines()]
    kept = [line for line in lines if line and not line.startswith(_NOISE)]
    words = _plain(kept[0]) if kept else kind
    for pattern, told in _PLAIN_REASONS:
        match = re.search(pattern, words)
        if match is not None:
            hint = "write it with loops and arithmetic"
            return KernelError(told.format(*match.groups()), loc=place, hint=hint)
    hint = "numba types and compiles kernels: what numba.njit refuses, the array cannot run"
    return KernelError(f"numba: {words}", loc=place, hint=hint)


_PLAIN_REASONS = (
    (r"unsupported NumPy function 'numpy\.([\w.]+)'", "numba has no `np.{}`"),
    (r"Unknown attribute '(\w+)' of type Module\(<?module '?(\w+)", "numba has no `{1}.{0}`"),
    (r"module '(\w+)' has no attribute '(\w+)'", "`{}` has no `{}`"),
    (r"Unknown attribute '(\w+)' of type (.+)", "numba has no `.{}` of {}"),
    (r"Variable '(\w+)' is not defined", "`{}` is read before anything is assigned to it"),
    (r"getitem>?\(.*\.\.\.\)|, \.\.\.\)", "a subscript with `...`"),
    (r"'NoneType' object has no attribute", "a construct that numba fails on"),
    (r"Resolution failure for literal arguments", "these arguments of a method or function"),
)
"""What numba says of its own, and what the user is told."""


def _plain(words: str) -> str:
    """Without addresses, paths of modules, and mangled names."""
    words = _ADDRESS.sub("", words)
    words = re.sub(r"(<module '\w+') from '[^']*'>", r"\1>", words)
    return re.sub(r"type\(CPUDispatcher\(<function (\w+)>\)\)", r"the function \1", words)


_NOISE = ("Failed in", "File ", "During:", ">>>", "<source", "def ")


def _call(text: str) -> str:
    """The innermost call that numba could not type, without addresses."""
    calls = [match["call"] for match in _UNKNOWN.finditer(text)]
    return _plain(calls[0]).strip() if calls else "function for these types"
