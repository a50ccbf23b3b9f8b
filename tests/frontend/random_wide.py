"""Random kernels on 64-bit integers: expressions of every operation, in loops that carry them."""

from __future__ import annotations

from random import Random

HEADER = """import numpy as np
from vividc.frontend import kernel


@kernel("{returns}(int32[::1], uint32[::1], float32[::1], int64, uint64)")
def program(x, u, f, p, q):
    a = np.int64({start})
    h = np.uint64({seed})
    for i in range(len(x)):
{body}    return {result}
"""

BITS = (1, 4, 8, 16, 31, 32, 33, 40, 48, 62, 63)
SIGNED_LEAVES = ("x[i]", "x[i - 1]", "p", "a", "i", "np.int64(u[i])", "np.int64(h)")
UNSIGNED_LEAVES = ("np.uint64(u[i])", "q", "h", "np.uint64(a)", "np.uint64(x[i])")
SIGNED_FORMS = (
    "({a} << {near})",
    "({a} >> {near})",
    "({a} << {far})",
    "({a} >> {far})",
    "({a} << ({b} & 63))",
    "({a} >> ({b} & 63))",
    "({a} >> ({b} & 31))",
    "({a} << (32 + ({b} & 31)))",
    "min({a}, {b})",
    "max({a}, {b})",
    "abs({a})",
    "(-{a})",
    "(~{a})",
    "np.int64(np.int32({a}))",
    "np.int64(np.uint32({a}))",
    "({a} & {mask})",
    "({a} if {cond} else {b})",
    "({a} // {divisor})",
    "({a} % {divisor})",
    "({a} // (({b} & {mask}) | 1))",
    "({a} % (({b} & {mask}) | 1))",
    "max({a} - {b}, 0)",
    "min(max({a}, -{mask}), {mask})",
    "np.int64({cond})",
    "np.int64({unsigned})",
)
UNSIGNED_FORMS = (
    "({a} << np.uint64({near}))",
    "({a} >> np.uint64({near}))",
    "({a} << np.uint64({far}))",
    "({a} >> np.uint64({far}))",
    "({a} << ({b} & np.uint64(63)))",
    "({a} >> ({b} & np.uint64(63)))",
    "(({a} << np.uint64({far})) | ({a} >> np.uint64(64 - {far})))",
    "(({a} << np.uint64({turn})) | ({b} >> np.uint64(64 - {turn})))",
    "min({a}, {b})",
    "max({a}, {b})",
    "(~{a})",
    "({a} & np.uint64({mask}))",
    "({a} if {cond} else {b})",
    "({a} // np.uint64({positive}))",
    "({a} % np.uint64({positive}))",
    "({a} // ({b} | np.uint64(1)))",
    "({a} % (({b} & np.uint64({mask})) | np.uint64(1)))",
    "np.uint64({signed})",
)
RING = ("+", "-", "*", "&", "|", "^")
TESTS = ("<", "<=", ">", ">=", "==", "!=")
SPECIAL = (0, 1, -1, 3, 1000, 2**31 - 1, -(2**31), 2**32 - 1, 2**32, -(2**32), 2**62, -(2**63))


class _Writer:
    def __init__(self, seed: int) -> None:
        self.random = Random(seed)

    def constant(self) -> int:
        if self.random.random() < 0.4:
            return self.random.choice(SPECIAL)
        bits = self.random.choice(BITS)
        return self.random.randrange(-(2**bits), 2**bits)

    def fields(self, depth: int) -> dict[str, object]:
        random = self.random
        positive = random.choice([2, 3, 7, 10, 4096, 2**33, 10**9 + 7, random.randrange(3, 2**63)])
        return {
            "turn": random.choice([1, 13, 31, 40]),
            "near": random.choice([0, 1, 7, 31]),
            "far": random.choice([32, 33, 45, 63]),
            "mask": 2 ** random.choice(BITS) - 1,
            "positive": positive,
            "divisor": random.choice([positive, -3, -10, -(2**40), -random.randrange(2, 2**63)]),
            "cond": self.condition(max(depth - 1, 0)),
            "signed": self.signed(max(depth - 1, 0)),
            "unsigned": self.unsigned(max(depth - 1, 0)),
        }

    def signed(self, depth: int) -> str:
        if depth == 0:
            leaf = self.random.choice(SIGNED_LEAVES)
            return leaf if self.random.random() < 0.75 else f"np.int64({self.constant()})"
        a, b = self.signed(depth - 1), self.signed(depth - 1)
        if self.random.random() < 0.35:
            return f"({a} {self.random.choice(RING)} {b})"
        return self.random.choice(SIGNED_FORMS).format(a=a, b=b, **self.fields(depth))

    def unsigned(self, depth: int) -> str:
        if depth == 0:
            leaf = self.random.choice(UNSIGNED_LEAVES)
            return leaf if self.random.random() < 0.75 else f"np.uint64({self.constant() % 2**64})"
        a, b = self.unsigned(depth - 1), self.unsigned(depth - 1)
        if self.random.random() < 0.35:
            return f"({a} {self.random.choice(RING)} {b})"
        return self.random.choice(UNSIGNED_FORMS).format(a=a, b=b, **self.fields(depth))

    def condition(self, depth: int) -> str:
        kind = self.random.choice([self.signed, self.unsigned])
        return f"({kind(depth)} {self.random.choice(TESTS)} {kind(depth)})"

    def statement(self, depth: int, indent: int) -> str:
        pad = "    " * indent
        choice = self.random.randrange(9 if depth else 7)
        if choice < 7:
            return f"{pad}{self.assignment(choice)}\n"
        inner = self.statement(depth - 1, indent + 1)
        if choice == 7:
            return f"{pad}if {self.condition(1)}:\n{inner}"
        trips = self.random.choice(["3", "np.int32(a & 7)", "i"])
        return f"{pad}for j in range({trips}):\n{inner}{pad}    a ^= j\n"

    def assignment(self, choice: int) -> str:
        if choice <= 1:
            return f"a = {self.signed(2)}"
        if choice <= 3:
            return f"h = {self.unsigned(2)}"
        if choice == 4:
            return f"x[i] = {self.signed(2)}"
        if choice == 5:
            return f"u[i] = {self.unsigned(2)} >> np.uint64(32)"
        value = self.signed(1) if self.random.random() < 0.5 else self.unsigned(1)
        return f"f[i] = np.float32({value})"


def random_wide_kernel(seed: int) -> str:
    """Source of a module whose `program` is a kernel."""
    writer = _Writer(seed)
    body = "".join(writer.statement(1, 2) for _ in range(writer.random.randint(2, 4)))
    returns, result = writer.random.choice([("int64", "a"), ("uint64", "h"), ("int64", "a + i")])
    start, seed_of_h = writer.constant(), writer.constant() % 2**64
    if result == "a + i":
        body, result = body + "        a += x[i]\n", "a"
    return HEADER.format(returns=returns, start=start, seed=seed_of_h, body=body, result=result)
