"""Functions of numpy that numba has and the array has not, with what to write instead.

Numba compiles them to lists, to memory whose size is not known at launch, or to exceptions; of that
a user wrote nothing, so the function itself is named. What a hint has in backticks is code; every
hint's code is run by tests/frontend/test_hints.py.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator

_SIZE = (
    "how many elements it finds is known at the end only: make room for all, "
    "`found = np.zeros(len(x), np.int32)`, and count in a loop: `found[count] = i`"
)
_SET = (
    "how many elements it finds is known at the end only: sort, `s = np.sort(x)`, and count those "
    "that differ from the one before: `if i == 0 or s[i] != s[i - 1]:`"
)
_MEMBERS = "loop over the elements of one, and ask for each: `if x[i] in y:`"
_ORDER = "sort a copy, `s = np.sort(x)`, and take its elements by index: `s[len(s) // 2]`"
_INDICES = (
    "insert each index in a loop: start from `order = np.arange(len(x))`, and move larger elements "
    "up: `while k > 0 and x[order[k - 1]] > x[i]:`"
)
_AXES = "index with the axes exchanged: `m[j, i]` for element (i, j)"
_ROOM = "make the result, and fill it in a loop: "
_ALONG = "take the rows one by one in a loop: `m[i]` is an array of one dimension"
_RANDOM = "make random numbers on the host, and pass them in an array: `noise[i]`"

_ALWAYS = {
    **dict.fromkeys(("argsort", "argpartition"), _INDICES),
    **dict.fromkeys(("median", "percentile", "quantile"), _ORDER),
    **dict.fromkeys(("nanmedian", "nanpercentile", "nanquantile"), _ORDER),
    "partition": "`np.sort(x)` sorts the whole, which is a partition, too",
    **dict.fromkeys(("unique", "union1d"), _SET),
    **dict.fromkeys(("intersect1d", "setdiff1d", "setxor1d", "isin", "in1d"), _MEMBERS),
    **dict.fromkeys(("nonzero", "argwhere", "flatnonzero", "extract"), _SIZE),
    **dict.fromkeys(("moveaxis", "rollaxis"), _AXES),
    "bincount": "count in a loop: `counts[x[i]] += 1`",
    "histogram": "count in a loop: `counts[min(int((x[i] - low) * scale), bins - 1)] += 1`",
    "digitize": '`np.searchsorted(edges, x[i], side="right")` is one element\'s',
    **dict.fromkeys(("split", "array_split", "hsplit", "vsplit"), "take slices: `x[:4]`, `x[4:]`"),
    "interp": (
        "find the place, `k = np.searchsorted(at, v)`, and go from one value to the next: "
        "`y[k - 1] + (y[k] - y[k - 1]) * (v - at[k - 1]) / (at[k] - at[k - 1])`"
    ),
    "convolve": _ROOM + "`y[i + j] += x[i] * h[j]`",
    "correlate": _ROOM + "`y[i] += x[i + j] * h[j]`",
    "delete": _ROOM + "`y[i] = x[i] if i < at else x[i + 1]`",
    "allclose": "ask for each element in a loop: `np.isclose(x[i], y[i])`",
    "broadcast_to": "arithmetic broadcasts by itself; else leave the index of the new axis out",
    "take": "index with an array of integers: `x[places]`",
}
"""Whatever their arguments."""

_SOMETIMES = {
    "sort": _ALONG,
    **dict.fromkeys(("argmax", "argmin", "max", "min", "amax", "amin"), _ALONG),
    **dict.fromkeys(("mean", "prod", "any", "all", "cumsum", "cumprod"), _ALONG),
    "rot90": _AXES,
    "cross": "of vectors and matrices it runs: take the parts of the arrays in a loop",
    "resize": _ROOM + "`y[i] = x[i % len(x)]`",
    "indices": "the loops over the elements have them",
    "where": _SIZE,
    "einsum": "write the sums as loops; `np.dot(a, b)` is a product of matrices or vectors",
    **dict.fromkeys(("matmul", "tensordot", "inner"), "`np.dot(a, b)` is their product"),
    "isclose": "ask for each element in a loop: `np.isclose(x[i], y[i])`",
    "round": "`np.round(x)` does that",
    "heaviside": "compare: `np.where(x < 0, 0, 1)`",
    "squeeze": "index the axis of one element: `m[0]`",
    "tile": _ROOM + "`y[i] = x[i % len(x)]`",
    "pad": _ROOM + "`y[i + 1] = x[i]`",
    "clip": "`min(max(v, low), high)` is one number's",
    "gradient": _ROOM + "`y[i] = (x[i + 1] - x[i - 1]) / 2`",
}
"""With some arguments only, or numba has them not."""

_FILES = "files are for the host: read and write them there, and pass arrays"
_SOMETIMES |= dict.fromkeys(
    ("save", "savez", "savetxt", "load", "loadtxt", "genfromtxt", "fromfile", "tofile"), _FILES
)

_HOST = {
    "random": _RANDOM,
    "fft": "transform on the host, or write the loops",
    "ctypes": "pass arrays, and index them",
}
"""Modules of what no array has."""


def hint_for(name: str, *, has_axes: bool = True) -> str | None:
    """What to write instead of a function of numpy of this name; None: nothing in particular.

    `has_axes`: some argument has more than one dimension.
    """
    hint = _ALWAYS.get(name) or _SOMETIMES.get(name)
    return None if hint == _ALONG and not has_axes else hint


def hints() -> dict[str, str]:
    """All, by function."""
    return {**_SOMETIMES, **_ALWAYS}


def refused_calls(function: ast.AST) -> Iterator[tuple[int, str, str]]:
    """(line, construct, way out) of each call that no array runs, by numpy's name or as an array's
    method.
    """
    for node in ast.walk(function):
        if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
            continue
        hint = _ALWAYS.get(node.func.attr) or _of_module(node.func)
        if node.func.attr == "where" and len(node.args) == 1:
            hint = _SIZE
        if hint is not None:
            yield node.lineno, f"`{ast.unparse(node.func)}`", hint


def refused_on(calls: list[ast.Call]) -> Iterator[tuple[str, str]]:
    """(construct, way out) of the calls among these that some arguments make what no array runs."""
    for call in calls:
        name = call.func.attr if isinstance(call.func, ast.Attribute) else ""
        hint = hint_for(name)
        if hint is not None:
            yield f"`{ast.unparse(call.func)}`", hint


def _of_module(function: ast.Attribute) -> str | None:
    """`np.random.rand`, `random.random`."""
    home = function.value
    if isinstance(home, ast.Attribute | ast.Name):
        name = home.attr if isinstance(home, ast.Attribute) else home.id
        return _HOST.get(name)
    return None
