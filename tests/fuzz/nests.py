"""Random nests of loops over one and two dimensions, as source text: imperfect, triangular,
strided, descending and skewed, with indices that are affine in the counters and in a length.

Dependences between iterations go every way: `a[3 * i]`, `a[n - 1 - i]` and `a[i + j]` of one array,
`b[i, j]` and `b[j, i]`, a row and the next one, the halves of an array.
"""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

N, M = 5, 4
"""Greatest values of the scalars `n` and `m`."""
CELLS, SIDE = 160, 20
"""Lengths of the arrays `a` and `f`, and of the sides of `b`."""
HALF = CELLS // 2
DEPTH = 3

HEADER = f"""import numpy as np
from vividc.frontend import kernel

SHAPES = {{"a": ("#{CELLS}",), "f": ("#{CELLS}",), "b": ("#{SIDE}", "#{SIDE}")}}
MOST = {{"n": {N}, "m": {M}}}


@kernel("int32(int32[::1], float32[::1], int32[:, ::1], int32, int32)")
def program(a, f, b, n, m):
    s = np.int32(1)
    z = np.float32(0.5)
"""


@dataclass(frozen=True, slots=True)
class Counter:
    """A loop's counter: it lies between the two, and if `below_n` it is less than n."""

    name: str
    least: int
    most: int
    below_n: bool


@dataclass(frozen=True, slots=True)
class _Index:
    """An affine form and its bounds."""

    text: str
    least: int
    most: int


class _Writer:
    def __init__(self, seed: int) -> None:
        self.random = Random(seed)
        self.number = 0

    def source(self) -> str:
        """The module."""
        nests = "".join(self.loop(1, []) for _ in range(self.random.choice([1, 1, 2])))
        return f"{HEADER}{nests}    f[0] = z\n    return s\n"

    def loop(self, indent: int, around: list[Counter]) -> str:
        """A loop; what is before and after the loops in it makes it imperfect."""
        self.number += 1
        bounds, counter = self.range(f"i{self.number}", around)
        inside = [*around, counter]
        text = f"{'    ' * indent}for {counter.name} in range({bounds}):\n"
        deeper = self.random.choice([0, 1, 1, 1, 2]) if len(inside) < DEPTH else 0
        for _ in range(deeper):
            text += self.maybe(indent + 1, inside) + self.loop(indent + 1, inside)
        return text + (self.maybe if deeper else self.statement)(indent + 1, inside)

    def range(self, name: str, around: list[Counter]) -> tuple[str, Counter]:
        """Bounds of a loop, and its counter."""
        forms = [
            ("n", 0, N - 1, True),
            ("m", 0, M - 1, False),
            ("1, n", 1, N - 1, True),
            ("n - 1", 0, N - 2, True),
            ("0, n, 2", 0, N - 1, True),
            ("1, 2 * n, 3", 1, 2 * N - 1, False),
            ("n - 1, -1, -1", 0, N - 1, True),
            ("n, 0, -2", 1, N, False),
            ("4", 0, 3, False),
        ]
        if around and self.random.random() < 0.6:
            forms = self.skewed(self.random.choice(around))
        bounds, least, most, below_n = self.random.choice(forms)
        return bounds, Counter(name, least, max(least, most), below_n)

    def skewed(self, outer: Counter) -> list[tuple[str, int, int, bool]]:
        """Ranges whose bounds move with a counter around."""
        i, least, most, below_n = outer.name, outer.least, outer.most, outer.below_n
        return [
            (i, 0, most - 1, below_n),
            (f"{i} + 1", 0, most, below_n),
            (f"{i}, n", least, N - 1, True),
            (f"{i} + 1, n", least + 1, N - 1, True),
            (f"n - {i}", 0, N - 1 - least, True),
            (f"{i}, {i} + m", least, most + M - 1, False),
            (f"{i}, -1, -1", 0, most, below_n),
            (f"n - 1, {i}, -1", least + 1, N - 1, True),
            (f"{i}, {i} + n, 2", least, most + N - 1, False),
        ]

    def maybe(self, indent: int, around: list[Counter]) -> str:
        return self.statement(indent, around) if self.random.random() < 0.6 else ""

    def statement(self, indent: int, around: list[Counter]) -> str:
        """Some assignments; one of them perhaps under a condition, or with an exit."""
        pad, random = "    " * indent, self.random
        text = "".join(f"{pad}{self.assignment(around)}\n" for _ in range(random.choice([1, 1, 2])))
        kind = random.random()
        if kind < 0.15:
            text += f"{pad}if {self.word(around)} & 1:\n{pad}    {self.assignment(around)}\n"
        elif kind < 0.2:
            text += f"{pad}if {self.word(around)} > {random.randint(20, 200)}:\n{pad}    break\n"
        return text

    def assignment(self, around: list[Counter]) -> str:
        kind = self.random.random()
        if kind < 0.15:
            return f"s = np.int32(s {self.random.choice('+^-')} {self.word(around)})"
        if kind < 0.25:
            return f"z = np.float32(z * np.float32(0.5) + {self.real(around)})"
        if kind < 0.4:
            return f"f[{self.cell(around)}] = {self.real(around)}"
        value = f"{self.word(around)} {self.random.choice('+^-')} {self.word(around)}"
        return f"{self.place(around)} {self.random.choice(['=', '=', '+='])} np.int32({value})"

    def word(self, around: list[Counter]) -> str:
        if self.random.random() < 0.2:
            return self.random.choice([around[-1].name, "s", "m"])
        return self.place(around)

    def real(self, around: list[Counter]) -> str:
        if self.random.random() < 0.2:
            return "z"
        return f"f[{self.cell(around)}] - f[{self.cell(around)}]"

    def place(self, around: list[Counter]) -> str:
        """An element of one of the arrays of integers."""
        if self.random.random() < 0.6:
            return f"a[{self.cell(around)}]"
        row, column = (self.index(around, SIDE, most_terms=1).text for _ in range(2))
        return f"b[{row}, {column}]"

    def cell(self, around: list[Counter]) -> str:
        if self.random.random() < 0.15:  # what is negative counts from the end
            part = self.index(around, HALF, most_terms=1).text
            return f"{part} {self.random.choice('+-')} {self.random.choice(['m', 'n', '2 * m'])}"
        half = self.random.choice(["", "", "", f"{HALF} + ", "len(a) // 2 + "])
        return half + self.index(around, HALF if half else CELLS, most_terms=2).text

    def index(self, around: list[Counter], length: int, most_terms: int) -> _Index:
        """An affine index of an array of this length."""
        while True:
            count = min(self.random.randint(1, most_terms), len(around))
            terms = [self.term(counter) for counter in self.random.sample(around, count)]
            least, most = sum(t.least for t in terms), sum(t.most for t in terms)
            ahead = self.random.choice([0, 0, 0, 1, 2, 5]) + max(0, -least)
            if most + ahead < length:
                text = " + ".join(term.text for term in terms)
                return _Index(f"{text} + {ahead}" if ahead else text, least + ahead, most + ahead)

    def term(self, counter: Counter) -> _Index:
        i, least, most = counter.name, counter.least, counter.most
        if counter.below_n and self.random.random() < 0.25:
            return _Index(f"n - 1 - {i}", 0, N - 1 - least)
        factor = self.random.choice([1, 1, 1, 2, 3, -1])
        if factor == 1:
            return _Index(i, least, most)
        bounds = sorted((factor * least, factor * most))
        return _Index(f"{factor} * {i}", bounds[0], bounds[1])


def random_nest_source(seed: int) -> str:
    """A module whose `program` is a kernel of nests."""
    return _Writer(seed).source()
