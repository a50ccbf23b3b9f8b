"""Loops over the dimensions of arrays, and indices that stay inside."""

from __future__ import annotations

from dataclasses import dataclass, field
from random import Random

MOST = {"L": 17, "M": 8, "K": 4, "OWN": 16, "FOUR": 4}
"""Dimensions and their greatest lengths; `OWN` and `FOUR` are those of a kernel's own arrays."""

CONSTANT = {"OWN": 16, "FOUR": 4}
"""Lengths of what the kernel allocates."""

FIXED = {"L": 16, "M": 8, "K": 4}
"""Lengths where a program relies on them: powers of two for masks."""

OVER = (
    ("{d}", 0, 0),
    ("{d}", 0, 0),
    ("0, {d}", 0, 0),
    ("1, {d}", 1, 0),
    ("1, {d} - 1", 1, 1),
    ("{d} - 1", 0, 1),
    ("2, {d}", 2, 0),
    ("0, {d} - 3, 4", 0, 3),
    ("0, {d}, 2", 0, 0),
    ("1, {d} - 1, 3", 1, 1),
    ("{d} - 1, -1, -1", 0, 0),
    ("{d} - 1, 0, -1", 1, 0),
    ("{d} - 2, 0, -2", 1, 1),
    ("{d} - 1, -1, -3", 0, 0),
    ("0, {d}, 1 + (n & 3)", 0, 0),
    ("1, {d}, 1 + (q & 1)", 1, 0),
    ("{d} - 1, -1, -1 - (n & 1)", 0, 0),
)
"""Ranges over a dimension; how far one may look below and above their counters."""


def counted(length: int) -> str:
    """The name of a dimension of a constant's, whose length everybody knows."""
    return f"#{length}"


def fixed_length(dim: str) -> int | None:
    """The length of a dimension if it is the same in every run of every program."""
    return int(dim[1:]) if dim[0] == "#" and dim[1:].isdecimal() else CONSTANT.get(dim)


def most(dim: str) -> int:
    """The greatest length of a dimension; what is cut from one is no longer than that."""
    whole = dim.partition("-")[0].partition("/")[0]
    return MOST[whole] if whole in MOST else int(whole[1:])


@dataclass(frozen=True, slots=True)
class Array:
    """A parameter, a constant or an array of the kernel's own; `dims` names its dimensions."""

    name: str
    dtype: str
    dims: tuple[str, ...]
    is_constant: bool = False


@dataclass(frozen=True, slots=True)
class Counter:
    """A loop's counter: counter + k indexes dimension `dim` for k from -below to above."""

    name: str
    dim: str
    below: int
    above: int
    most: int
    trips: int


@dataclass
class Places:
    """What can be indexed at a point of the program."""

    random: Random
    arrays: list[Array]
    is_fixed: bool
    counters: list[Counter] = field(default_factory=list)
    nonempty: list[str] = field(default_factory=list)

    def length(self, dim: str) -> str:
        """The length of a dimension, in one of many ways."""
        fixed = fixed_length(dim)
        if fixed is not None:
            return str(fixed)
        ways = [f"n{dim}"]
        for array in self.arrays:
            ways += [f"{array.name}.shape[{k}]" for k, d in enumerate(array.dims) if d == dim]
            ways += [f"len({array.name})"] * (array.dims[0] == dim)
        if self.is_fixed:
            ways.append(str(FIXED[dim]))
        return self.random.choice(ways)

    def known(self, dim: str) -> int:
        """The length of a dimension if the program may rely on it, else 0."""
        fixed = fixed_length(dim)
        if fixed is not None:
            return fixed
        return FIXED.get(dim, 0) if self.is_fixed else 0

    def trips(self) -> int:
        """At most so many iterations of the loops around."""
        product = 1
        for counter in self.counters:
            product *= counter.trips
        return product

    def over(self, name: str, dim: str) -> tuple[str, Counter]:
        """A range over a dimension, perhaps from or to a counter around."""
        inside = [c for c in self.counters if c.dim == dim and c.below >= 0 and c.above >= 0]
        size = most(dim)
        if inside and self.random.random() < 0.5:
            return self._triangle(name, self.random.choice(inside), size)
        text, below, above = self.random.choice(OVER)
        bounds = text.format(d=self.length(dim))
        return bounds, Counter(name, dim, below, above, size, size)

    def _triangle(self, name: str, outer: Counter, size: int) -> tuple[str, Counter]:
        i, d = outer.name, self.length(outer.dim)
        forms = (
            (i, 0, outer.above + 1),
            (f"{i}, {d}", outer.below, 0),
            (f"{i} + 1, {d}", outer.below + 1, 0),
            (f"{i}, -1, -1", 0, outer.above),
            (f"{d} - 1, {i}, -1", outer.below + 1, 0),
            (f"{i} + 1", 0, outer.above),
        )
        bounds, below, above = self.random.choice(forms)
        return bounds, Counter(name, outer.dim, below, above, size, size)

    def can_index(self, array: Array) -> bool:
        """Whether there is a valid index for every dimension here."""
        return all(self.can_index_axis(dim) for dim in array.dims)

    def can_index_axis(self, dim: str) -> bool:
        """Whether there is a valid index for a dimension here."""
        near = any(c.dim == dim for c in self.counters)
        return near or dim in self.nonempty or bool(self.known(dim))

    def index(self, array: Array, anything: str) -> str:
        """Indices of an element; `anything` is an expression of a signed type."""
        return ", ".join(self.index_axis(dim, anything) for dim in array.dims)

    def index_axis(self, dim: str, anything: str) -> str:
        """An index that is valid here."""
        near = [c for c in self.counters if c.dim == dim]
        size = self.known(dim)
        if near and self.random.random() < 0.75:
            return self._near(self.random.choice(near), dim)
        if size and not size & size - 1:
            return self._masked(size, anything)
        d = self.length(dim)
        forms = (
            "({e}) % {d}",
            "({e}) % {d}",
            "min(max({e}, 0), {d} - 1)",
            "0",
            "{d} - 1",
            "-1",
            "abs(np.int32({e}) >> 1) % {d}",
        )
        return self.random.choice(forms).format(e=anything, d=d)

    def _near(self, counter: Counter, dim: str) -> str:
        by = self.random.randint(-counter.below, counter.above)
        if self.random.random() < 0.4 and -counter.below <= 0 <= counter.above:
            by = 0
        base = counter.name if by == 0 else f"{counter.name} {'+-'[by < 0]} {abs(by)}"
        kind = self.random.random()
        if kind < 0.75:
            return base
        d = self.length(dim)
        forms = ("{d} - 1 - ({i})", "-1 - ({i})", "({i}) - {d}", "min({i} + 1, {d} - 1)")
        return self.random.choice((*forms, "max({i} - 2, 0)")).format(i=base, d=d)

    def _masked(self, size: int, anything: str) -> str:
        mask = size - 1
        if not self.counters or self.random.random() < 0.3:
            return self.random.choice([f"({anything}) & {mask}", str(self.random.randrange(size))])
        i = self.random.choice(self.counters).name
        forms = ("{i} & {k}", "({k} - {i}) & {k}", "({i} - 1) & {k}", "(2 * {i} + 1) & {k}")
        return self.random.choice((*forms, "({i} + 1) % {n}")).format(i=i, k=mask, n=size)
