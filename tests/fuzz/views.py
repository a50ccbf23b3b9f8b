"""Parts of arrays as expressions, by the lengths of their axes: what can be added to what.

Two parts have the same lengths if their dimensions have the same names: `L` of which one element is
cut off is `L-1`, at whichever end, forwards or backwards.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import prod
from random import Random

from tests.fuzz.places import Array, Places, most

CUTS = {
    "": (":", ":", ":", "::-1"),
    "-1": ("1:", ":-1", ":0:-1", "-2::-1"),
    "-2": ("1:-1", "2:", ":-2"),
    "/2": ("::2", "::2", "-1::-2"),
    "//2": ("1::2", "-2::-2"),
}
"""Slices by what they leave of an axis."""

_FIRST = ":1"
"""A slice that broadcasts: one element, or none of none."""


@dataclass(frozen=True, slots=True)
class View:
    """Part of an array: its text, what it is of, and the lengths of its axes."""

    text: str
    array: Array
    dims: tuple[str, ...]

    @property
    def size(self) -> int:
        """Its elements, at most."""
        return prod(map(most, self.dims))

    @property
    def is_whole(self) -> bool:
        """Whether it is all of an array, by its name."""
        return self.text == self.array.name


def part(random: Random, places: Places, array: Array, index: Callable[[], str]) -> View:
    """Some part of an array, of one axis at least; `index` is any expression of a signed type."""
    rest, heads = list(array.dims), []
    while len(rest) > 1 and random.random() < 0.4 and places.can_index_axis(rest[0]):
        heads.append(places.index_axis(rest.pop(0), index()))
    kinds = [random.choice(["", "", "", *CUTS]) for _ in rest]
    dims = tuple(
        dim + kind if _can_cut(dim) else dim for dim, kind in zip(rest, kinds, strict=True)
    )
    cuts = [_cut(random, base, dim) for base, dim in zip(rest, dims, strict=True)]
    return View(_subscripted(random, array.name, heads, cuts), array, dims)


def fitting(random: Random, array: Array, dims: tuple[str, ...]) -> View | None:
    """A part of `array` that can be combined with another of these dimensions, by broadcasting if
    it has fewer axes or one element of one; None if there is none.
    """
    wanted = dims[len(dims) - len(array.dims) :]
    if len(array.dims) > len(dims):
        return None
    cuts = []
    for base, dim in zip(array.dims, wanted, strict=True):
        if base == "#1":
            cuts.append(":")
        elif dim.startswith(base) and dim[len(base) :] in CUTS:
            same = dim == base and random.random() < 0.15
            cuts.append(_FIRST if same else _cut(random, base, dim))
        else:
            return None
    text = _subscripted(random, array.name, [], cuts)
    if len(array.dims) == 2 and array.dims[0] == array.dims[1] and random.random() < 0.3:
        text += ".T" if all(cut in (":", "::-1") for cut in cuts) else ""
    return View(text, array, tuple(wanted))


def _can_cut(dim: str) -> bool:
    return "-" not in dim and "/" not in dim


def _cut(random: Random, base: str, dim: str) -> str:
    return random.choice(CUTS[dim[len(base) :]])


def _subscripted(random: Random, name: str, heads: list[str], cuts: list[str]) -> str:
    if not heads and all(cut == ":" for cut in cuts) and random.random() < 0.7:
        return name
    while len(heads) + len(cuts) > 1 and cuts and cuts[-1] == ":" and random.random() < 0.5:
        cuts = cuts[:-1]
    return f"{name}[{', '.join([*heads, *cuts])}]"
