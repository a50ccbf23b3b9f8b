"""Numba's types, calls and places in the words of whoever wrote the kernel."""

from __future__ import annotations

import re
from collections.abc import Callable
from types import TracebackType

from numba.core.ir import Loc

_ADDRESS = re.compile(r" at 0x[0-9a-f]+")


def _array(match: re.Match[str]) -> str:
    """`float32[:, ::1]`, as in a signature."""
    axes = [":"] * int(match[2])
    if axes and match[3] != "A":
        axes[-1 if match[3] == "C" else 0] = "::1"
    return f"{match[1]}[{', '.join(axes)}]"


_TYPES: tuple[tuple[str, str | Callable[[re.Match[str]], str]], ...] = (
    (r"omitted\(default=([^()]*)\)", r"\1"),
    (r"Literal\[(?:int|bool)\]\((-?\w+)\)", r"\1"),
    (r"Literal\[str\]\(([^()]*)\)", r"'\1'"),
    (r"readonly (?=[Aa]rray)|, readonly", ""),
    (r"[Aa]rray\(([^()]*?), (\d+)d?, '?([CFA])'?[^()]*\)", _array),
    (r"Record\([^()]*\)", "a structure"),
    (r"(?:Function|type)\((?:CPUDispatcher|_Dispatcher)\(<function (\w+)>\)\)", r"\1"),
    (r"Function\(<ufunc '(\w+)'>\)", r"np.\1"),
    (r"Function\(<(?:[\w-]+ )+'?([\w.]+)'?>\)", r"\1"),
    (r"Module\(<module '([\w.]+)'[^>]*>\)", r"\1"),
    (r"(?:class|typeref|dtype)[\[(]([^()\[\]]*)[\])]", r"\1"),
    (r"UniTuple\(([^()]*) x (\d+)\)", lambda m: f"«{', '.join([m[1]] * int(m[2]))}»"),
    (r"Tuple\(([^()]*)\)", r"«\1»"),
    (r"OptionalType\(([^()]*)\)", r"\1 or None"),
    (r"(?:reflected )?list\(([^()]*)\)(?:<[^>]*>)?", "list"),
    (r"ListType\[[^\]]*\]", "numba.typed.List"),
    (r"DictType\[[^\]]*\](?:<[^>]*>)?", "numba.typed.Dict"),
    (r"slice<\w:\w>|slice\d_type", "a slice"),
    (r"\bunicode_type\b", "str"),
    (r"\bnone\b", "None"),
    (r"\bellipsis\b", "..."),
    (r"\brange_(?:state|iter)_\w+", "range"),
    (r"\bnumba\.\w+\.\w+\.(\w+)", r"numba.\1"),
    (r"<[\w ]*?'?([\w.]+)'?>", r"\1"),
)
_OPERATORS = {
    "add": "+", "sub": "-", "mul": "*", "truediv": "/", "floordiv": "//", "mod": "%", "pow": "**",
    "matmul": "@", "and_": "&", "or_": "|", "xor": "^", "lshift": "<<", "rshift": ">>",
    "eq": "==", "ne": "!=", "lt": "<", "le": "<=", "gt": ">", "ge": ">=", "is_": "is",
}  # fmt: skip
_OPERATORS |= {f"i{name}": f"{sign}=" for name, sign in _OPERATORS.items()}
_CALL = re.compile(r"(?P<name>[\w.<>]+)\((?P<arguments>.*)\)$", re.DOTALL)
_HIDDEN = re.compile(r"^(?:npy|array|np|numpy|impl|ol)_(?=\w)")
_PAIR = 2


def plain(text: str) -> str:
    """Numba's names of types, and Python's reprs, as they would be written in a kernel."""
    text = _ADDRESS.sub("", text)
    before = ""
    while before != text:  # from the inside out
        before = text
        for pattern, words in _TYPES:
            text = re.sub(pattern, words, text)
    return text.replace("«", "(").replace("»", ")")


def call_of(text: str) -> tuple[str, list[str]]:
    """Name and types of the arguments of a call as numba writes it, `add(int32, none)`."""
    match = _CALL.match(text.strip())
    if match is None:
        return plain(text), []
    name = re.sub(r"^.*\.", "", plain(match["name"]))
    return _HIDDEN.sub("", name), _split(plain(match["arguments"]))


def written(name: str, arguments: list[str]) -> str:
    """A call as it is written: operators between their operands."""
    if is_operator(name, arguments):
        return f"{arguments[0]} {_OPERATORS[name]} {arguments[1]}"
    return f"{name}({', '.join(arguments)})"


def is_operator(name: str, arguments: list[str]) -> bool:
    """Whether a call is an operator's."""
    return name in _OPERATORS and len(arguments) == _PAIR


def _split(arguments: str) -> list[str]:
    """At the commas outside brackets."""
    parts, depth, start = [], 0, 0
    for place, character in enumerate(arguments):
        depth += (character in "([{") - (character in ")]}")
        if character == "," and depth == 0:
            parts.append(arguments[start:place].strip())
            start = place + 1
    rest = arguments[start:].strip()
    return [*parts, rest] if rest else parts


def is_numbas(error: Exception) -> bool:
    """Whether numba's own code raised an exception."""
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    return trace is not None and str(trace.tb_frame.f_globals.get("__name__")).startswith("numba.")


def lines_passed(trace: TracebackType | None, file: str) -> list[int]:
    """Lines of a file that numba was at while it failed, the innermost first."""
    lines: list[int] = []
    while trace is not None:
        for value in list(trace.tb_frame.f_locals.values()):
            loc = value if isinstance(value, Loc) else _loc_of(value)
            if isinstance(loc, Loc) and loc.filename == file and loc.line:
                lines.insert(0, loc.line)
        trace = trace.tb_next
    return list(dict.fromkeys(lines))


def _loc_of(value: object) -> object:
    return getattr(value, "loc", None) if type(value).__module__.startswith(_LOCATED) else None


_LOCATED = ("numba.core.ir", "numba.core.lowering", "numba.core.typeinfer")
"""Modules of numba whose objects say where they are."""
