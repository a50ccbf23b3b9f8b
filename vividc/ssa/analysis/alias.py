"""Whether two accesses of one array can meet."""

from __future__ import annotations


def different_elements(one: tuple[int | None, ...], other: tuple[int | None, ...]) -> bool:
    """Whether subscripts of one array differ in some dimension, whatever those unknown are.

    A subscript outside its dimension is undefined: `a[i, 1]` and `a[j, 2]` never meet, although
    rows of one column would put them at one address.
    """
    pairs = zip(one, other, strict=False)
    return any(None not in pair and pair[0] != pair[1] for pair in pairs)
