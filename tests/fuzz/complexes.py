"""Random kernels of complex numbers, as source text: scalars and arrays of them, their parts, whole
arrays and slices that overlap, constant tables, returned numbers and arrays.

All is complex64, so that numba rounds where the array does; elementary functions are left out.
"""

from __future__ import annotations

from random import Random

LENGTH, ROWS, COLUMNS = 9, 4, 5

HEADER = f"""import numpy as np
from vividc.frontend import kernel

SHAPES = {{"a": ("#{LENGTH}",), "b": ("#{LENGTH}",), "o": ("#{LENGTH}",)}}
SHAPES |= {{"m": ("#{ROWS}", "#{COLUMNS}")}}
MOST = {{"n": {LENGTH}}}
TABLE = np.array([1 + 2j, -0.5j, 3, 0.25 - 1j], np.complex64)
ARRAYS = "complex64[::1], complex64[::1], complex64[:, ::1], float32[::1]"


@kernel(f"({{ARRAYS}}, complex64, int32)")
def program(a, b, m, o, c, n):
    s = np.complex64(1 - 1j)
    t = np.zeros(4, np.complex64)
"""
BINARY = (
    *("({x} + {y})", "({x} - {y})", "({x} * {y})", "({x} * {y} + {z})"),
    *("np.complex64({x} / {d})", "({x} if {cond} else {y})", "({x} * {r})"),
    *("np.complex64(complex({r}, {q}))", "np.complex64({x} * 2)", "np.complex64({x} * 1j)"),
)
UNARY = ("(-{x})", "np.conj({x})", "{x}.conjugate()", "np.complex64({r})")
REAL = ("{x}.real", "{x}.imag", "np.real({x})", "np.imag({x})", "({x}.real * {y}.imag)")
TESTS = ("{x} == {y}", "{x} != {y}", "{x}.real < {y}.imag", "{x}.imag >= np.float32(0.5)")
WHOLE = (
    "a[1:] = a[:-1] * c",
    "a[:-1] = a[1:] + b[1:]",
    "b[:] = np.conj(a) + b",
    "b[::2] = a[::-1][::2]",
    "o[:] = a.real - b.imag",
    "a[:] = np.where(a.real < b.imag, a, b)",
    "m[1:, 1:] = m[:-1, :-1] * c",
    "m[:] = m + c",
    "m[2] = m[1].conj()",
    "t[:] = TABLE[::-1]",
    "t += b[:4]",
    "s += m.sum()",
    "s += np.dot(a, b)",
    "a[:5] = m[1] - m[2]",
)
RESULTS = ("s", "s * c, a[2:]", "a + b", "t, s", "m.T, o[1]", "a.imag, s.real", "b[::-2].copy()")


class _Writer:
    def __init__(self, seed: int) -> None:
        self.random = Random(seed)
        self.loops = 0

    def source(self) -> str:
        """The module."""
        text = "".join(self.statement(1) for _ in range(self.random.randint(2, 4)))
        return f"{HEADER}{text}    return {self.random.choice(RESULTS)}\n"

    def statement(self, indent: int, counters: tuple[str, ...] = ()) -> str:
        """A statement, a loop or a branch."""
        space, draw = "    " * indent, self.random.random()
        if draw < 0.4 and len(counters) < 2:
            self.loops += 1
            counter = f"i{self.loops}"
            bounds = self.random.choice(["n", "1, n", "n - 1, -1, -1", "4"])
            inside = "".join(
                self.statement(indent + 1, (*counters, counter))
                for _ in range(self.random.randint(1, 2))
            )
            return f"{space}for {counter} in range({bounds}):\n{inside}"
        if draw < 0.5 and indent < 4:
            inside = self.statement(indent + 1, counters)
            return f"{space}if {self.test(counters)}:\n{inside}"
        if draw < 0.62 and len(counters) < 2:
            return f"{space}{self.random.choice(WHOLE)}\n"
        if draw < 0.75:
            return f"{space}o[{self.index(counters, LENGTH)}] = {self.real(counters, 1)}\n"
        operator = self.random.choice(["=", "=", "+=", "-=", "*="])
        target = "s" if draw < 0.85 else self.element(counters, ("a", "b", "m", "t"))
        return f"{space}{target} {operator} {self.number(counters, 2)}\n"

    def index(self, counters: tuple[str, ...], length: int) -> str:
        """An index that lies in its array."""
        if not counters or self.random.random() < 0.2:
            return str(self.random.randrange(length))
        counter = self.random.choice(counters)
        if length == LENGTH and self.random.random() < 0.6:
            return counter
        return f"({counter} + {self.random.randrange(4)}) % {length}"

    def element(self, counters: tuple[str, ...], arrays: tuple[str, ...]) -> str:
        """An element of one of the arrays."""
        array = self.random.choice(arrays)
        if array == "m":
            return f"m[{self.index(counters, ROWS)}, {self.index(counters, COLUMNS)}]"
        return f"{array}[{self.index(counters, LENGTH if array in 'ab' else 4)}]"

    def number(self, counters: tuple[str, ...], depth: int) -> str:
        """A complex64."""
        if not depth or self.random.random() < 0.2:
            leaves = ("s", "c", "np.complex64(0.5 - 2j)")
            if self.random.random() < 0.3:
                return self.random.choice(leaves)
            return self.element(counters, ("a", "b", "m", "t", "TABLE"))
        return self.filled(self.random.choice(BINARY + UNARY), counters, depth - 1)

    def real(self, counters: tuple[str, ...], depth: int) -> str:
        """A float32."""
        if not depth or self.random.random() < 0.2:
            return self.random.choice([f"o[{self.index(counters, LENGTH)}]", "np.float32(1.5)"])
        return self.filled(self.random.choice(REAL), counters, depth - 1)

    def test(self, counters: tuple[str, ...]) -> str:
        """A condition."""
        return self.filled(self.random.choice(TESTS), counters, 0)

    def filled(self, form: str, counters: tuple[str, ...], depth: int) -> str:
        """A form with random parts."""
        parts = {
            "x": lambda: self.number(counters, depth),
            "y": lambda: self.number(counters, 0),
            "z": lambda: self.number(counters, 0),
            "d": lambda: self.random.choice(["c", "np.complex64(1 + 2j)", "np.complex64(0.5j)"]),
            "r": lambda: self.real(counters, depth),
            "q": lambda: self.real(counters, 0),
            "cond": lambda: self.test(counters),
        }
        return form.format(
            **{name: make() for name, make in parts.items() if f"{{{name}}}" in form}
        )


def random_complex_source(seed: int) -> str:
    """A module with a kernel `program` of complex numbers."""
    return _Writer(seed).source()
