"""Random kernels that end and stay in their arrays: indices are masked, `while` loops have fuel.

Names that start with `k_` are fuel: the shrinker leaves them alone.
"""

from __future__ import annotations

from random import Random

import numpy as np

LENGTH = 16
SIGNATURE = (
    "(uint8[::1], int16[::1], boolean[::1], int32[::1], uint32[::1], float32[::1], "
    "int32[:, ::1], float32[::1], int32, uint32, int64)"
)
PARAMETERS = "b, h, flags, x, u, f, g, out, n, m, q"
INT_ARRAYS = {"b": "uint8", "h": "int16", "x": "int32", "u": "uint32"}
INT_VARIABLES = {"s": "int32", "t": "uint32", "w": "int64"}
CASTS = ("np.int32", "np.uint32", "np.int64", "np.uint8", "np.int16")
CONSTANTS = (0, 1, -1, 2, 3, 7, 31, 255, 65535, 1 << 20, 2**31 - 1, -(2**31), 4294967295)
DIVISORS = (1, 2, 3, 7, 10, 64, 641, 65536, -3, -8)
TESTS = ("<", "<=", ">", ">=", "==", "!=")
TRIPS = ("3", "16", "1, 12, 3", "15, -1, -2", "n & 15", "m & 7", "len(x)", "0")
INNER = ("i", "i & 3", "4", "n & 3", "x[i & 15] & 7", "3, -1, -1", "i, 8", "1, 9, 2")
HEADER = """import numba
import numpy as np
from vividc.frontend import kernel

TABLE = np.array({table}, np.int32)
PAIR = ({one}, {two})


@numba.njit
def helper(a, c):
    if a > c:
        return np.int32(a {ring} c)
    return np.int32(c ^ {constant})


@kernel("{returns}{signature}")
def program({parameters}):
    s = np.int32(1)
    t = np.uint32(2)
    w = np.int64(q)
    z = np.float32(0.5)
    v = np.zeros(8, np.int32)
{body}    return np.{returns}({result})
"""
FORMS = (
    "{cast}({a})",
    "({a} << {constant})",
    "(np.int32({a}) >> (np.int32({b}) & 31))",
    "(np.uint32({a}) >> (np.uint32({b}) & 31))",
    "(np.int32({a}) << (np.int32({b}) & 15))",
    "(np.int64({a}) >> (np.int64({b}) & 63))",
    "({a} // {divisor})",
    "({a} % {divisor})",
    "(np.int32({a}) // ((np.int32({b}) & 15) + 1))",
    "(np.int32({a}) % ((np.int32({b}) & 255) + 1))",
    "(np.uint32({a}) % ((np.uint32({b}) & 63) + 1))",
    "min({a}, {b})",
    "max({a}, {b})",
    "abs({cast}({a}))",
    "(-{a})",
    "(~{a})",
    "({a} if {cond} else {b})",
    "np.int32({cond})",
    "helper(np.int32({a}), np.int32({b}))",
    "np.int32(min(max({float}, np.float32(-999)), np.float32(999)))",
)
FLOAT_FORMS = (
    "({a} + {b})",
    "({a} - {b})",
    "({a} * {b})",
    "min({a}, {b})",
    "max({a}, {b})",
    "abs({a})",
    "(-{a})",
    "np.float32(np.int16({int}))",
    "({a} if {cond} else {b})",
)
INEXACT = ("np.exp(-abs({a}))", "np.float32({a} / (abs({b}) + np.float32(1)))", "np.sin({a})")


def random_source(seed: int) -> str:
    """Source of a module whose `program` is a kernel."""
    random = Random(seed)
    draw = _Generator(random)
    body = draw.block(random.randint(2, 5), 3, 1)
    returns = random.choice(["int32", "uint32", "int64"])
    return HEADER.format(
        table=[random.randint(-999, 999) for _ in range(8)],
        one=random.choice(CONSTANTS[:8]),
        two=random.choice(CONSTANTS[:8]),
        ring=random.choice("+-*&|^"),
        constant=random.choice(CONSTANTS[:9]),
        returns=returns,
        signature=SIGNATURE,
        parameters=PARAMETERS,
        body=body,
        result=random.choice(["s", "t", "w"]),
    ).replace("RETURNS", returns)


def random_arguments(seed: int, trial: int) -> list[object]:
    """Arguments of the kernel; later trials have values nearer to 0."""
    rng = np.random.default_rng([seed, trial])

    def draw(dtype: str, *shape: int) -> np.ndarray:
        info = np.iinfo(dtype)
        limit = (info.max, 200, 3)[trial % 3]
        low, high = max(info.min, -limit - 1), min(info.max, limit)
        return rng.integers(low, high, shape, dtype=dtype, endpoint=True)

    def floats() -> np.ndarray:
        return rng.uniform(-4, 4, LENGTH).astype(np.float32)

    arrays: list[object] = [draw("uint8", LENGTH), draw("int16", LENGTH)]
    arrays += [draw("uint8", LENGTH) > LENGTH // 2, draw("int32", LENGTH)]
    arrays += [draw("uint32", LENGTH), floats(), draw("int32", 4, 4), floats()]
    return arrays + [draw(t, 1)[0] for t in ("int32", "uint32", "int64")]


class _Generator:
    """Statements and expressions; `loops` are the counters in sight."""

    def __init__(self, random: Random) -> None:
        self.random = random
        self.loops: list[str] = []
        self.names = 0
        self.pads = 0

    def block(self, count: int, depth: int, indent: int) -> str:
        return "".join(self.statement(depth, indent) for _ in range(count))

    def statement(self, depth: int, indent: int) -> str:
        pad = "    " * indent
        kinds = [self._assign] * 3 + [self._store] * 4
        if depth:
            kinds += [self._if] * 2 + [self._for] * 3 + [self._while]
        if self.loops:
            kinds.append(self._leave)
        if indent > 1:
            kinds.append(self._return)
        return self.random.choice(kinds)(pad, depth, indent)

    def _assign(self, pad: str, _depth: int, _indent: int) -> str:
        if self.random.random() < 0.25:
            return f"{pad}z = {self.float(2)}\n"
        name, dtype = self.random.choice(list(INT_VARIABLES.items()))
        return f"{pad}{name} = np.{dtype}({self.int(self.random.randint(1, 3))})\n"

    def _store(self, pad: str, _depth: int, _indent: int) -> str:
        kind = self.random.choice(["int"] * 5 + ["v", "g", "flags", "f", "out"])
        if kind == "int":
            name, dtype = self.random.choice(list(INT_ARRAYS.items()))
            place = f"{name}[{self.index()}]"
            operator = self.random.choice(["", "", f"{place} + ", f"{place} ^ "])
            return f"{pad}{place} = np.{dtype}({operator}{self.int(2)})\n"
        if kind == "v":
            return f"{pad}v[{self.index(7)}] = np.int32({self.int(2)})\n"
        if kind == "g":
            return f"{pad}g[{self.index(3)}, {self.index(3)}] = np.int32({self.int(2)})\n"
        if kind == "flags":
            return f"{pad}flags[{self.index()}] = {self.condition(1)}\n"
        if kind == "f":
            return f"{pad}f[{self.index()}] = {self.float(2)}\n"
        form = self.random.choice(INEXACT)
        return f"{pad}out[{self.index()}] = {form.format(a=self.float(0), b=self.float(0))}\n"

    def _if(self, pad: str, depth: int, indent: int) -> str:
        count = self.random.randint(1, 2)
        text = f"{pad}if {self.condition(1)}:\n{self.block(count, depth - 1, indent + 1)}"
        if self.random.random() < 0.3:
            text += f"{pad}elif {self.condition(1)}:\n{self.statement(depth - 1, indent + 1)}"
        if self.random.random() < 0.4:
            text += f"{pad}else:\n{self.statement(depth - 1, indent + 1)}"
        return text

    def _for(self, pad: str, depth: int, indent: int) -> str:
        name = ("i", "j", "l")[len(self.loops)]
        trips = TRIPS if not self.loops else INNER
        head = f"{pad}for {name} in range({self.random.choice(trips)}):\n"
        self.loops.append(name)
        body = self.block(self.random.randint(1, 3), depth - 1, indent + 1)
        self.loops.pop()
        return head + body

    def _while(self, pad: str, depth: int, indent: int) -> str:
        self.names += 1
        fuel = f"k_{self.names}"
        forever = self.random.random() < 0.3
        test = (
            "True" if forever else f"{fuel} < {self.random.randint(0, 9)} and {self.condition(1)}"
        )
        text = f"{pad}{fuel} = 0\n{pad}while {test}:\n{pad}    {fuel} += 1\n"
        if forever:
            text += f"{pad}    if {fuel} > {self.random.randint(0, 9)}:\n{pad}        break\n"
        outer, self.loops = self.loops, [*self.loops]
        if not self.loops:
            self.loops = []
        text += self.block(self.random.randint(1, 2), depth - 1, indent + 1)
        self.loops = outer
        return text

    def _leave(self, pad: str, _depth: int, _indent: int) -> str:
        leave = self.random.choice(["continue", "break"])
        return f"{pad}if {self.condition(1)}:\n{pad}    {leave}\n"

    def _return(self, pad: str, _depth: int, _indent: int) -> str:
        return f"{pad}if {self.condition(2)}:\n{pad}    return np.RETURNS({self.int(1)})\n"

    def index(self, mask: int = LENGTH - 1) -> str:
        plain = [*self.loops] * 4 + ["s", "n", "m", "b[s & 15]", "x[n & 15]"]
        place = self.random.choice(plain)
        shift = self.random.choice(["", "", "+ 1", "- 1", ">> 1"])
        return f"({place} {shift}) & {mask}" if shift else f"{place} & {mask}"

    def int(self, depth: int) -> str:
        if depth == 0:
            return self._leaf()
        a, b = self.int(depth - 1), self.int(depth - 1)
        if self.random.random() < 0.5:
            return f"({a} {self.random.choice('+-*&|^')} {b})"
        form = self.random.choice(FORMS)
        return form.format(
            a=a,
            b=b,
            cast=self.random.choice(CASTS),
            constant=self.random.choice([0, 1, 5, 16, 31]),
            divisor=self.random.choice(DIVISORS),
            cond=self.condition(depth - 1),
            float=self.float(depth - 1),
        )

    def _leaf(self) -> str:
        kind = self.random.random()
        if kind < 0.35:
            return f"{self.random.choice(list(INT_ARRAYS))}[{self.index()}]"
        if kind < 0.45:
            return self.random.choice(
                [
                    f"v[{self.index(7)}]",
                    f"TABLE[{self.index(7)}]",
                    f"g[{self.index(3)}, {self.index(3)}]",
                    "PAIR[1]",
                ]
            )
        if kind < 0.6:
            return str(self.random.choice(CONSTANTS))
        return self.random.choice(["n", "m", "q", "s", "t", "w", *self.loops * 2])

    def float(self, depth: int) -> str:
        if depth == 0:
            number = f"np.float32({self.random.choice(['0.5', '-1.25', '3', '0'])})"
            return self.random.choice([f"f[{self.index()}]", "z", number])
        return self.random.choice(FLOAT_FORMS).format(
            a=self.float(depth - 1),
            b=self.float(depth - 1),
            int=self.int(depth - 1),
            cond=self.condition(0),
        )

    def condition(self, depth: int) -> str:
        kind = self.random.random()
        if kind < 0.1:
            return f"flags[{self.index()}]"
        if kind < 0.25:
            return f"({self.float(depth)} {self.random.choice(TESTS)} {self.float(0)})"
        if kind < 0.4 and depth:
            word = self.random.choice(["and", "or"])
            return f"({self.condition(depth - 1)} {word} not {self.condition(depth - 1)})"
        return f"({self.int(depth)} {self.random.choice(TESTS)} {self.int(depth)})"
