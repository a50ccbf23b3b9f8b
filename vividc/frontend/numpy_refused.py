"""Functions of numpy that numba has and the array has not, with what to write instead.

Numba compiles them to lists, to memory whose size is not known at launch, or to exceptions; of that
a user wrote nothing, so the function itself is named.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator

_SIZE = (
    "how many elements it finds is known at the end only: allocate as many as there can be, "
    "np.zeros(len(x), np.int32), and count them in a loop"
)
_ORDER = "sort a copy, np.sort(x), and take its elements by index"
_AXES = "index with the axes exchanged, in loops"
_LOOP = "write the loop over the elements"
_INDICES = "sort the indices in a loop of your own: for each element insert its index"
_TABLE = "count in a loop: counts[int(x[i])] += 1"

_HINTS = {
    **dict.fromkeys(("argsort", "argpartition"), _INDICES),
    **dict.fromkeys(
        ("median", "nanmedian", "percentile", "nanpercentile", "quantile", "nanquantile"), _ORDER
    ),
    "partition": "np.sort(x) sorts the whole, which is a partition, too",
    **dict.fromkeys(
        ("unique", "union1d", "intersect1d", "setdiff1d", "setxor1d", "nonzero", "argwhere"), _SIZE
    ),
    **dict.fromkeys(("flatnonzero", "extract"), _SIZE),
    **dict.fromkeys(("swapaxes", "moveaxis", "rollaxis"), _AXES),
    **dict.fromkeys(("bincount", "histogram", "digitize"), _TABLE),
    **dict.fromkeys(("split", "array_split", "hsplit", "vsplit"), "take slices: x[:4], x[4:]"),
    **dict.fromkeys(
        ("isin", "in1d", "interp", "convolve", "correlate", "delete", "allclose", "broadcast_to"),
        _LOOP,
    ),
    **dict.fromkeys(("ediff1d", "take"), _LOOP),
}


def refused_calls(function: ast.AST) -> Iterator[tuple[int, str, str]]:
    """(line, construct, way out) of each such call, by numpy's name or as an array's method."""
    for node in ast.walk(function):
        if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
            continue
        hint = _HINTS.get(node.func.attr)
        if hint is not None:
            yield node.lineno, f"`{ast.unparse(node.func)}`", hint
