"""Random well-typed kernels as source text: they terminate and stay within their arrays."""

from __future__ import annotations

from dataclasses import dataclass, field
from random import Random

LENGTH = 16
ARRAYS = {
    "a": "uint8",
    "b": "int8",
    "c": "uint16",
    "d": "int16",
    "e": "boolean",
    "x": "int32",
    "u": "uint32",
    "f": "float32",
}
"""Array parameters of `LENGTH` elements by name."""

SCALARS = {"n": "int32", "m": "uint32", "p": "int64", "q": "int8"}
RETURNS = ("int32", "int8", "uint8", "int16", "uint16", "uint32", "int64")
HEADER = """import numpy as np
from vividc.frontend import kernel

TABLE = np.array([3, -1, 4, 200, -5, 9, 2, 6, 2147483647, 3, 5, -8, 9, 7, 9, -2147483648], np.int32)
SMALL = (7, -3, 12, 5)


@kernel("int32(int32, int32)")
def mix(v, w):
    if v > w:
        return np.int32(v - w)
    return np.int32((v ^ w) + 1)


@kernel("{signature}")
def program({parameters}):
"""
CASTS = ("np.uint8", "np.int8", "np.uint16", "np.int16", "np.int32", "np.uint32", "np.int64")
CONSTANTS = (0, 1, -1, 2, 7, 31, 127, 255, 256, -128, 32767, 65535, 2**31 - 1, -(2**31), 2**32 - 1)
FORMS = (
    "np.int64({cast}({a}))",
    "np.int64(np.uint32({a}) {ring} np.uint32({b}))",
    "np.int64(np.uint32({a}) // np.uint32(({b}) | 1))",
    "np.int64(np.uint32({a}) % np.uint32(({b}) | 1))",
    "np.int64(np.uint32({a}) >> np.uint32(({b}) & 31))",
    "(np.int32({a}) // np.int32(({b}) | 1))",
    "(np.int32({a}) % np.int32(({b}) | 1))",
    "({a} // {divisor})",
    "({a} % {divisor})",
    "(np.int32({a}) >> (({b}) & 31))",
    "({a} >> (({b}) & 63))",
    "({a} << (({b}) & 15))",
    "({a} << {shift})",
    "({a} >> {shift})",
    "min({a}, {b})",
    "max({a}, {b})",
    "min(max({a}, 0), 255)",
    "abs(np.int32({a}))",
    "(~({a}))",
    "(-({a}))",
    "({a} & {mask})",
    "({a} if {cond} else {b})",
    "mix(np.int32({a}), np.int32({b}))",
    "TABLE[({a}) & 15]",
    "SMALL[({a}) & 3]",
)
FLOAT_FORMS = (
    "({a} + {b})",
    "({a} - {b})",
    "({a} * {b})",
    "({a} * np.float32(0.5))",
    "min({a}, {b})",
    "max({a}, {b})",
    "abs({a})",
    "(-{a})",
    "({a} if {cond} else {b})",
)
RING = ("+", "-", "*", "&", "|", "^")
TESTS = ("<", "<=", ">", ">=", "==", "!=")
TRIPS = ("16", "1, 16", "len(x)", "15, -1, -1", "0, 14, 3", "n & 15", "q & 7", "14, 2, -3")
INNER = ("3", "{i} & 3", "1, 9, 2", "n & 3", "{i} & 7, 5", "6, {i} & 7, -1", "4")
INDICES = ("{i} & 15", "(15 - {i}) & 15", "({i} - 1) & 15", "({i} + 1) & 15", "(2 * {i}) & 15")


@dataclass
class Generator:
    """Writes one kernel. `loops` holds the counters of the loops around."""

    random: Random
    arrays: list[str]
    loops: list[str] = field(default_factory=list)
    counters: int = 0
    returns: str = "int32"

    def body(self) -> str:
        """Statements of the kernel, its return included."""
        lines = ["    s = np.int32(1)", "    t = np.int64(n)", "    z = np.float32(0.5)"]
        lines.append("    own = np.zeros(16, np.int32)")
        text = "\n".join(lines) + "\n"
        if self.random.random() < 0.9:
            text += self.loop(2, 1, TRIPS)
        for _ in range(self.random.randint(0, 2)):
            text += self.statement(2, 1)
        result = self.random.choice(["s", "t", "s + t", "own[n & 15]", self.integer(1)])
        return f"{text}    return np.{self.returns}({result})\n"

    def block(self, depth: int, indent: int, most: int = 3) -> str:
        count = self.random.randint(1, most)
        return "".join(self.statement(depth, indent) for _ in range(count))

    def statement(self, depth: int, indent: int) -> str:
        pad = "    " * indent
        kind = self.random.random()
        if depth and kind < 0.2:
            return self.branch(depth, indent)
        if depth and kind < 0.3 and len(self.loops) < 3:
            return self.loop(depth - 1, indent, INNER if self.loops else TRIPS)
        if depth and kind < 0.36 and len(self.loops) < 3:
            return self.while_loop(depth - 1, indent)
        if self.loops and kind < 0.43:
            word = self.random.choice(["break", "continue", "continue", self.leave()])
            return f"{pad}if {self.condition(1)}:\n{pad}    {word}\n"
        return f"{pad}{self.assignment()}\n"

    def leave(self) -> str:
        return f"return np.{self.returns}({self.integer(1)})"

    def branch(self, depth: int, indent: int) -> str:
        pad = "    " * indent
        text = f"{pad}if {self.condition(1)}:\n{self.block(depth - 1, indent + 1, 2)}"
        if self.random.random() < 0.3:
            text += f"{pad}elif {self.condition(1)}:\n{self.block(depth - 1, indent + 1, 2)}"
        if self.random.random() < 0.5:
            text += f"{pad}else:\n{self.block(depth - 1, indent + 1, 2)}"
        return text

    def loop(self, depth: int, indent: int, trips: tuple[str, ...]) -> str:
        name = self.counter("i")
        bounds = self.random.choice(trips).format(i=self.index())
        self.loops.append(name)
        inner = self.block(depth, indent + 1)
        self.loops.pop()
        return f"{'    ' * indent}for {name} in range({bounds}):\n{inner}"

    def while_loop(self, depth: int, indent: int) -> str:
        name, pad = self.counter("w"), "    " * indent
        limit = self.random.choice(["5", "n & 7", "12"])
        test = f"{name} < ({limit})"
        if self.random.random() < 0.5:
            test += f" and {self.condition(1)}"
        self.loops.append(name)
        inner = self.block(depth, indent + 1)
        self.loops.pop()
        return f"{pad}{name} = 0\n{pad}while {test}:\n{pad}    {name} += 1\n{inner}"

    def counter(self, prefix: str) -> str:
        self.counters += 1
        return f"{prefix}{self.counters}"

    def index(self) -> str:
        return self.random.choice(self.loops) if self.loops else self.random.choice("nq")

    def place(self) -> str:
        if self.random.random() < 0.15:
            return f"({self.integer(1)}) & 15"
        return self.random.choice(INDICES).format(i=self.index())

    def assignment(self) -> str:
        kind = self.random.random()
        if kind < 0.25:
            return f"s = np.int32({self.integer(2)})"
        if kind < 0.35:
            return f"t = np.int64({self.integer(2)})"
        if kind < 0.42:
            return f"z = {self.real(2)}"
        if kind < 0.52:
            operator = self.random.choice(["=", "+=", "^="])
            return f"own[{self.place()}] {operator} {self.integer(2)}"
        return self.store()

    def store(self) -> str:
        name = self.random.choice(self.arrays)
        target = f"{name}[{self.place()}]"
        if name == "e":
            return f"{target} = {self.condition(1)}"
        if name == "f":
            return f"{target} {self.random.choice(['=', '+='])} {self.real(2)}"
        if name in "acu":
            return f"{target} = {self.integer(2)}"
        return f"{target} {self.random.choice(['=', '=', '+=', '^='])} {self.integer(2)}"

    def integer(self, depth: int) -> str:
        """An expression of a signed integer type."""
        if depth == 0:
            return self.leaf()
        a, b = self.integer(depth - 1), self.integer(self.random.randint(0, depth - 1))
        if self.random.random() < 0.4:
            return f"({a} {self.random.choice(RING)} {b})"
        return self.random.choice(FORMS).format(
            a=a,
            b=b,
            cast=self.random.choice(CASTS),
            ring=self.random.choice(RING),
            cond=self.condition(depth - 1),
            divisor=self.random.choice([1, 2, 3, 7, 10, 16, 255, -3, -7, -8, 641]),
            shift=self.random.choice([0, 1, 5, 8, 16, 31, 32]),
            mask=self.random.choice([1, 15, 255, 65535, 2**31 - 1, 2**32 - 1]),
        )

    def leaf(self) -> str:
        kind = self.random.random()
        if kind < 0.2:
            return self.random.choice(["s", "t", "n", "p", "q", "np.int64(m)"])
        if kind < 0.3:
            return f"own[{self.place()}]"
        if kind < 0.45:
            return self.index()
        names = [name for name in self.arrays if name != "f"]
        if kind < 0.6 or not names:
            return str(self.random.choice(CONSTANTS))
        name = self.random.choice(names)
        return f"np.int64({name}[{self.place()}])"

    def real(self, depth: int) -> str:
        """A float32 expression."""
        if depth == 0:
            leaves = ["z", "np.float32(1.25)", "np.float32(-3.0)"]
            leaves.append(f"np.float32(np.int16({self.integer(1)}))")
            leaves += [f"f[{self.place()}]"] * 3 * ("f" in self.arrays)
            return self.random.choice(leaves)
        a, b = self.real(depth - 1), self.real(depth - 1)
        form = self.random.choice(FLOAT_FORMS)
        return form.format(a=a, b=b, cond=self.condition(0))

    def condition(self, depth: int) -> str:
        kind = self.random.random()
        if depth and kind < 0.15:
            word = self.random.choice(["and", "or"])
            return f"({self.condition(0)} {word} {self.condition(0)})"
        if depth and kind < 0.2:
            return f"(not {self.condition(0)})"
        if kind < 0.27:
            return f"({self.real(0)} {self.random.choice(TESTS)} {self.real(0)})"
        if kind < 0.35 and "e" in self.arrays:
            return f"e[{self.place()}]"
        return f"({self.integer(depth)} {self.random.choice(TESTS)} {self.integer(depth)})"


def random_source(seed: int) -> str:
    """Source of a module whose `program` is a kernel."""
    random = Random(seed)
    arrays = sorted({"x", *random.sample(sorted(ARRAYS), random.randint(1, 4))})
    generator = Generator(random, arrays, returns=random.choice(RETURNS))
    body = generator.body()
    types = [f"{ARRAYS[name]}[::1]" for name in arrays] + list(SCALARS.values())
    signature = f"{generator.returns}({', '.join(types)})"
    parameters = ", ".join([*arrays, *SCALARS])
    return HEADER.format(signature=signature, parameters=parameters) + body
