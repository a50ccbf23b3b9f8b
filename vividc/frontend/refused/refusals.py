"""Numba's refusals, in the words of the kernel's author."""

from __future__ import annotations

import ast
import difflib
import importlib
import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vividc.errors import KernelError, SourceLoc
from vividc.frontend.refused.numpy import hint_for
from vividc.frontend.refused.source import KernelSource
from vividc.lang.numba_words import call_of, is_operator, plain, written

_UNKNOWN = re.compile(r">>> (?P<call>.+)")
_LOOPS = "write it with loops and arithmetic"
_BY_NAME = "call the functions by name, chosen by if and elif"
_UNIFORM = "give it values of one type, whichever way is taken: a number on each, or an array"


@dataclass(frozen=True, slots=True)
class Refusal:
    """What numba said of a kernel.

    Attributes
    ----------
    text
        Its message.
    kind
        The exception's name.
    line
        Line of the kernel's file that it is about, if `source` is there.
    source
        The kernel's source, None if there is none.
    """

    text: str
    kind: str
    line: int
    source: KernelSource | None

    @property
    def call(self) -> tuple[str, list[str]] | None:
        """Name and arguments' types of what numba could not type."""
        match = _UNKNOWN.search(self.text)
        return None if match is None else call_of(match["call"])

    @property
    def is_method(self) -> bool:
        """Whether that is a method of an array, which is its first argument."""
        return re.search(">>> (?:array|npy)_", self.text) is not None

    def callee(self, name: str = "") -> str:
        """What is called on the line, as written: of that name; of any, the only one that may be
        more than a shape or a cast; "": nothing.
        """
        calls = [] if self.source is None else self.source.calls_on(self.line)
        names = [
            ast.unparse(call.func)
            for call in calls
            if isinstance(call.func, ast.Name | ast.Attribute)
        ]
        if name:
            return next((text for text in names if text.rpartition(".")[2] == name), "")
        odd = [text for text in names if text.rpartition(".")[2] not in _HARMLESS]
        return odd[0] if len(odd) == 1 else ""


_HARMLESS = frozenset(
    [
        *("len", "range", "prange", "abs", "min", "max", "int", "float", "bool"),
        *("zeros", "empty", "array", "reshape", "float32"),
        *("int8", "uint8", "int16", "uint16", "int32", "uint32", "int64"),
    ]
)

Told = tuple[str, str]
"""Reason and hint."""


def in_words(refusal: Refusal, place: SourceLoc) -> KernelError:
    """The error for what numba refuses, where no construct of the source explains it."""
    reason, hint = _told(refusal)
    return KernelError(reason, loc=place, hint=hint)


def _told(refusal: Refusal) -> Told:
    for pattern, rule in _RULES:
        match = re.search(pattern, refusal.text, re.MULTILINE)
        if match is not None:
            return rule(refusal, match) if callable(rule) else rule
    return _of_first_line(refusal)


def _of_memory(refusal: Refusal, _: re.Match[str]) -> Told:
    """Numba takes memory from the heap: mostly for a list, a string, or an array of any size."""
    callee = refusal.callee("" if refusal.call is None else refusal.call[0])
    hint = "use an array of the kernel's own, np.zeros(16, np.float32), and loops over its elements"
    if not callee:
        return "this line needs memory of the host's heap", hint
    special = hint_for(callee.rpartition(".")[2])
    return f"`{callee}` of these arguments needs the host's heap", special or hint


def _of_call(refusal: Refusal, _: re.Match[str]) -> Told:
    assert refusal.call is not None
    name, arguments = refusal.call
    special = _SPECIAL.get(name)
    if special is not None and len(arguments) >= special[0]:
        return special[1](arguments)
    if is_operator(name, arguments):
        hint = "np.float32(x) and np.int32(x) make numbers of one type; of arrays, take elements"
        return f"numba has no `{written(name, arguments)}`", hint
    callee, of = refusal.callee(name) or name, ""
    if refusal.is_method:
        of = f" of {arguments.pop(0)}"
    return f"numba has no `{written(callee, arguments)}`{of}", _hint_of_call(name, arguments)


def _hint_of_call(name: str, arguments: list[str]) -> str:
    types = {"bool": "np.bool_", "int": "np.int32", "float": "np.float32"}
    named = [types[item] for item in arguments if item in types]
    if named and name in ("zeros", "ones", "empty", "full", "array", "arange", "astype"):
        return f"name numpy's type: {named[0]}"
    if any(item.startswith("axis=") for item in arguments):
        return "without an axis it takes the whole array; along one, write the loop over the others"
    if any("lang." in item for item in arguments):
        return (
            "numbers of 16 and 8 bits have +, -, * and comparisons, one by one: "
            "np.float32(x) has all"
        )
    has_axes = any("[:," in item for item in arguments)
    return hint_for(name, has_axes=has_axes) or _LOOPS


def _of_getitem(arguments: list[str]) -> Told:
    of, index = arguments[:2]
    if of.startswith("("):
        hint = "a variable picks from values of one type: choose by if and elif, or use an array"
        return f"a tuple of {of[1:-1]} is indexed by a variable", hint
    return f"numba cannot index {of} with {_bracketed(index)}", _index_hint(of)


def _of_setitem(arguments: list[str]) -> Told:
    of, index, value = arguments[:3]
    if "lang." in value:
        hint = "cast it to the array's: lang.fp16(value) to float16, np.float32(value) to float32"
        return "a number stored into an array of another format", hint
    return f"numba cannot store {value} into {of} at {_bracketed(index)}", _index_hint(of)


def _bracketed(index: str) -> str:
    return f"[{index[1:-1] if index.startswith('(') else index}]"


def _index_hint(of: str) -> str:
    if "[" not in of:
        return f"{of} has no elements: index the array with all its dimensions, a[i, j]"
    axes = of.count(":") - of.count("::1")
    which = "one integer or slice" if axes == 1 else f"at most {axes} integers or slices"
    return f"{which} between the brackets; one number to one element, arrays to slices"


_SPECIAL: dict[str, tuple[int, Callable[[list[str]], Told]]] = {
    "getitem": (2, _of_getitem),
    "static_getitem": (2, _of_getitem),
    "setitem": (3, _of_setitem),
    "exception_match": (
        0,
        lambda _: (
            "`try` cannot run on the array",
            "the array has no exceptions: test the condition beforehand",
        ),
    ),
}


def _of_missing(_: Refusal, match: re.Match[str]) -> Told:
    """A module has no such name."""
    module, name = match["of"], match["name"]
    written_as = "np" if module == "numpy" else module.removeprefix("vividc.")
    try:
        known = dir(importlib.import_module(module))
    except ImportError:
        known = []
    near = difflib.get_close_matches(name, known, 1)
    hint = f"did you mean `{written_as}.{near[0]}`?" if near else "check the spelling"
    return f"`{module}` has no `{name}`", hint


def _of_attribute(_: Refusal, match: re.Match[str]) -> Told:
    name, of = match["name"], plain(match["of"])
    if name in ("njit", "jit", "vectorize", "kernel"):
        hint = "decorate functions outside the kernel; a function inside it needs no decorator"
        return f"`{of}.{name}` within a kernel", hint
    if re.fullmatch(r"[\w.]+", of) and "Module" in match["of"]:
        short = "np" + of.removeprefix("numpy") if of.startswith("numpy") else of
        return f"numba has no `{short}.{name}`", hint_for(name, has_axes=False) or _LOOPS
    near = difflib.get_close_matches(name, dir(np.ndarray), 1) if "[" in of else []
    hint = hint_for(name) or _LOOPS
    if near and near[0] != name:
        hint = f"did you mean `.{near[0]}`?"
    return f"numba has no `.{name}` of {of}", hint


def _of_iteration(_: Refusal, match: re.Match[str]) -> Told:
    of = plain(match["of"])
    hint = "loop over range(n), an array, or a tuple of values of one type"
    return f"a loop over {of}", hint


def _of_types(_: Refusal, match: re.Match[str]) -> Told:
    name = match["name"].partition(".")[0]
    first, second = plain(match["one"]), plain(match["other"])
    if "lang." in first + second:
        hint = "cast where it is assigned, so that it has one format everywhere"
        return "a variable that holds numbers of two formats", hint
    what = "a result" if name.startswith("$") else f"`{name}`"
    return f"{what} is {first} on one way, and {second} on another", _UNIFORM


def _of_conversion(_: Refusal, match: re.Match[str]) -> Told:
    given, wanted = plain(match["one"]), plain(match["other"])
    if "return_value" not in match["name"]:
        return f"`{match['name'].partition('.')[0]}` is {given}, and {wanted} is wanted", _UNIFORM
    returned = "nothing" if given == "None" else "a string" if given.startswith("'") else given
    signed = "void" if wanted == "None" else wanted
    hint = 'the type in front of the signature is that of what is returned: "int32(float32[::1])"'
    return f"the kernel returns {returned}, and its signature says {signed}", hint


def _of_frozen(_: Refusal, match: re.Match[str]) -> Told:
    name = "a global" if match["name"] is None else f"`{match['name']}`"
    what = f"{name} is not a number, tuple or array, which a kernel could read"
    return what, "make it a tuple of numbers, or an array"


Rule = Told | Callable[[Refusal, re.Match[str]], Told]

_RULES: tuple[tuple[str, Rule], ...] = (
    (
        "recursi|re-entrant",
        ("a recursive call cannot run on the array", "use a loop, with an array as its stack"),
    ),
    (r"(?:assigned to variable '(?P<name>\w+)' in|not supported as) globals", _of_frozen),
    (
        "scipy",
        ("numba's linear algebra cannot run on the array", "write the loops over rows and columns"),
    ),
    (
        "Cannot modify readonly",
        ("a write to a global array, which is a constant", "pass the array as a parameter"),
    ),
    ("NRT required", _of_memory),
    (
        r"no attribute 'Literal\[int\]",
        (
            "a numpy function whose errors name a number (cumsum along an axis is one)",
            "write the loops over the elements",
        ),
    ),
    (
        r"Cannot unify .*lang\.\w+|lang\.\w+ cannot be represented",
        (
            "a variable that holds numbers of two formats",
            "cast where it is assigned, so that it has one format everywhere",
        ),
    ),
    (
        r"^float16$",
        (
            "np.float16 in a kernel",
            "write lang.fp16(x) for a number; an array of the kernel's own can be float32",
        ),
    ),
    (r"^(?:float|complex)\d{3}$", ("a number of more than 64 bits", "use np.float32")),
    (
        r"CPUDispatcher\(.*getitem|getitem.*type\(CPUDispatcher",
        lambda refusal, _: (f"{_functions(refusal)} are picked by a variable", _BY_NAME),
    ),
    (r"_dynfunc|_Closure object", ("a function taken from a tuple", _BY_NAME)),
    (r"exception_match", _SPECIAL["exception_match"][1]([])),
    ("No implementation of function", _of_call),
    (
        r"unsupported NumPy function 'numpy\.(?P<name>[\w.]+)'",
        lambda _, m: (f"numba has no `np.{m['name']}`", hint_for(m["name"]) or _LOOPS),
    ),
    (r"module '(?P<of>[\w.]+)' has no attribute '(?P<name>\w+)'", _of_missing),
    (r"Unknown attribute '(?P<name>\w+)' of type (?P<of>.+)", _of_attribute),
    (
        r"Variable '(?P<name>\w+)' is not defined",
        lambda _, m: (
            f"`{m['name']}` is read before anything is assigned to it",
            "assign to it on every way that leads here",
        ),
    ),
    (r"getitem>?\(.*\.\.\.\)|, \.\.\.\)", ("a subscript with `...`", "write `:`, or leave it out")),
    (r"Invalid use of getiter with parameters \((?P<of>.+)\)", _of_iteration),
    (r"Cannot unify (?P<one>.+) and (?P<other>.+?) for '(?P<name>[^']+)'", _of_types),
    (r"No conversion from (?P<one>.+) to (?P<other>.+?) for '(?P<name>[^']+)'", _of_conversion),
    (
        r"Invalid use of (?P<of>.+) with parameters",
        lambda _, m: (
            f"a call of {plain(m['of'])}, which is no function",
            "leave the parentheses out; an index has brackets",
        ),
    ),
    (
        r"unsupported keyword arguments when calling (?P<of>.+)",
        lambda _, m: (
            f"numba has no keyword arguments of {plain(m['of'])}",
            "assign the result: x[:] = np.add(x, y)",
        ),
    ),
    (
        r"(?:resolve setattr: \(|for lowering )(?P<of>.+?\))?\)?\.(?P<name>\w+) = ",
        lambda _, m: (
            f"an assignment to `.{m['name']}` of {plain(m['of'] or 'a value')}",
            "an array keeps its attributes: y = x.reshape((2, 4)) is another one",
        ),
    ),
    (
        r"Int value is too large: (?P<number>-?\d+)",
        lambda _, m: (f"the integer {m['number']} does not fit 64 bits", "use smaller integers"),
    ),
    ("pyobject", ("an array of Python objects", "pass arrays of numbers")),
    (
        r"missing a required argument: '(?P<name>\w+)'|too many positional|unexpected keyword",
        lambda r, _: (f"the arguments of {_quoted(r.callee())} do not fit it", "count them"),
    ),
    (
        "Resolution failure for literal arguments",
        lambda r, _: (f"{_quoted(r.callee())} does not take what it is given", _LOOPS),
    ),
)  # fmt: skip


def _functions(refusal: Refusal) -> str:
    names = re.findall(r"<function (\w+)>", plain_addresses(refusal.text))
    return "functions" if not names else f"the functions {' and '.join(dict.fromkeys(names))}"


def plain_addresses(text: str) -> str:
    """Without the addresses of objects."""
    return re.sub(r" at 0x[0-9a-f]+", "", text)


def _quoted(callee: str) -> str:
    return f"`{callee}`" if callee else "this call"


_NOISE = ("Failed in", "File ", "During:", ">>>", "<source", "def ")
_INTERNAL = re.compile(
    r"\$\d|0x[0-9a-f]{3}|object has no|has no attribute|[<>|%{}]|_\w+_|No definition|Literal"
    r"|\bcodegen|lower|numba\.|llvm|LLVM|constant size"
)


def _of_first_line(refusal: Refusal) -> Told:
    """Numba's own words where they are fit to be read."""
    lines = [line.strip() for line in refusal.text.splitlines()]
    kept = [line for line in lines if line and not line.startswith(_NOISE)]
    words = plain(kept[0]) if kept else ""
    if not words or _INTERNAL.search(words) or refusal.kind not in _READABLE:
        inner = None if refusal.source is None else refusal.source.inner_at(refusal.line)
        if inner is not None:
            hint = "an inner function has parameters by name, and as many arguments"
            return f"numba cannot fit a call of `{inner.name}` to its parameters", hint
        callee = refusal.callee()
        what = f"numba fails on `{callee}`" if callee else "numba cannot compile this line"
        return what, _LOOPS
    hint = "numba types and compiles kernels: what numba.njit refuses, the array cannot run"
    return f"numba: {words}", hint


_READABLE = (
    *("TypingError", "LoweringError", "UnsupportedError", "UnsupportedBytecodeError"),
    *("NumbaTypeError", "NumbaValueError", "SyntaxError", "ConstantInferenceError"),
)
"""Exceptions of numba's whose text is meant for users."""
