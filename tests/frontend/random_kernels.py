"""Random integer kernels: nested loops, branches, mixed widths and signs."""

from __future__ import annotations

from random import Random

HEADER = """import numpy as np
from vividc.frontend import kernel


@kernel("int32(int32[::1], int32[::1], uint32[::1], int32, int64)")
def program(x, y, u, n, m):
    acc = 0
    total = 0
    last = 0
    for i in range({trip}):
{body}    return np.int32({result})
"""

LEAVES = ("x[i]", "y[i]", "u[i]", "i", "n", "m", "acc", "total", "last", "x[i - 1]", "y[-i]")
CONSTANTS = (0, 1, -1, 7, 255, 65535, 1 << 20, 2**31 - 1, -(2**31), 4294967295)
FORMS = (
    "np.int32({a})",
    "np.uint32({a})",
    "({a} << {shift})",
    "({a} >> {shift})",
    "(np.int32({a}) // {power})",
    "(np.int32({a}) % {power})",
    "(np.int32({a}) // np.int32({b}))",
    "(np.int32({a}) % np.int32({b}))",
    "(np.uint32({a}) % np.uint32({b}))",
    "(np.uint32({a}) // {power})",
    "np.int8({a})",
    "np.uint16({a})",
    "(np.int32({a}) >> (np.int32({b}) & 31))",
    "min(np.int32({a}), np.int32({b}))",
    "max(np.int32({a}), np.int32({b}))",
    "abs(np.int32({a}))",
    "({a} & 65535)",
    "({a} if {cond} else {b})",
)
RING = ("+", "-", "*", "&", "|", "^")
TESTS = ("<", "<=", ">", ">=", "==", "!=")
TRIPS = ("n", "1, n", "x.shape[0]", "15, -1, -1", "0, 14, 3")
INNER = ("i", "3", "n", "1, 9, 2", "8, i, -1")


def random_kernel(seed: int) -> str:
    """Source of a module whose `program` is a kernel."""
    random = Random(seed)
    body = "".join(_statement(random, 2, 2) for _ in range(random.randint(1, 4)))
    result = random.choice(["acc", "total", "last"])
    return HEADER.format(trip=random.choice(TRIPS), body=body, result=result)


def _expression(random: Random, depth: int) -> str:
    if depth == 0:
        return random.choice(LEAVES) if random.random() < 0.7 else str(random.choice(CONSTANTS))
    a, b = _expression(random, depth - 1), _expression(random, depth - 1)
    if random.random() < 0.5:
        return f"({a} {random.choice(RING)} {b})"
    return random.choice(FORMS).format(
        a=a,
        b=b,
        cond=_condition(random, depth - 1),
        shift=random.choice([0, 1, 5, 16, 31, 33]),
        power=random.choice([1, 2, 4, 1024, 3, 10, -7, 641, 2**31 - 1]),
    )


def _condition(random: Random, depth: int) -> str:
    cast = random.choice(["np.int32", "np.uint32"])
    a, b = _expression(random, depth), _expression(random, depth)
    return f"({cast}({a}) {random.choice(TESTS)} {cast}({b}))"


def _statement(random: Random, depth: int, indent: int) -> str:
    pad = "    " * indent
    kind = random.randint(0, 8) if depth else random.randint(0, 4)
    if kind <= 1:
        return f"{pad}acc = {_expression(random, 2)}\n"
    if kind <= 3:
        index = random.choice(["i", "15 - i", "acc & 15"])
        return f"{pad}{random.choice('xyu')}[{index}] = {_expression(random, 2)}\n"
    if kind == 4:
        return f"{pad}total += {_expression(random, 1)}\n"
    inner = _statement(random, depth - 1, indent + 1)
    if kind <= 6:
        return f"{pad}if {_condition(random, 1)}:\n{inner}"
    if kind == 7:
        return f"{pad}for j in range({random.choice(INNER)}):\n{pad}    last = j\n{inner}"
    leave = random.choice(["continue", "break"])
    return f"{pad}if {_condition(random, 1)}:\n{pad}    {leave}\n"
