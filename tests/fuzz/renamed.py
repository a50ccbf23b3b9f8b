"""`python -m tests.fuzz.renamed`: random programs whose variables are one array here and another
there, against numba; exit code 1 on a find.

Names are exchanged, given to other arrays and to new ones, in loops and branches; what they name is
stored to and read in between, and returned at the end. Nothing is mapped: what is lowered is
interpreted.
"""

from __future__ import annotations

from random import Random

from tests.fuzz.slices import command

NAMES = "pqr"
_STARTS = ("a", "b", "a.copy()", "a + b", "np.zeros((6, 6), np.float32)", "a[1:].copy()")
_NAMED = (
    *("{0}, {1} = {1}, {0}", "{0}, {1}, {2} = {1}, {2}, {0}", "{0}, {1} = {1}, {0} + {1}"),
    *("{0} = {1}", "{0} = {1}.copy()", "{0} = {1} * np.float32(0.5)", "{0} = np.zeros_like({1})"),
)
_STORED = (
    *("{0}[0] += {1}[1]", "{0}[n - 1, 1:] = {1}[1, 1:] - {2}[0, :-1]", "{0} += 1.0", "{0} *= {0}"),
    *("{0}[1, {i} % 5] += {1}[{i} % 5, 2]", "{0}[:] = 2.0", "{0}[0, {i} % 6] = {2}.sum()"),
)
_TESTS = ("{0}[1, 2] > {1}[2, 1]", "n > {k}", "{i} == {k}", "{0}[{i} % 5, 0] < 1.0")
_HEADS = ("for {0} in range(n):", "for {0} in range({1}):", "for {0} in range({2}, n):")


def random_source(random: Random) -> str:
    """A kernel `program(a, b, n)`."""
    lines = ["def program(a, b, n):", "    i = n"]
    lines += [f"    {name} = {random.choice(_STARTS)}" for name in NAMES]
    lines += _block(random, 2, "i", 1)
    returned = random.choice(["p", "q, p", "(r, p[1:])", "p.sum() + q.sum()", "p, q, r"])
    return "import numpy as np\n\n\n" + "\n".join([*lines, f"    return {returned}"]) + "\n"


def _block(random: Random, depth: int, counter: str, indent: int) -> list[str]:
    lines: list[str] = []
    for _ in range(random.randint(1, 4)):
        lines += _statement(random, depth, counter, indent)
    return lines


def _statement(random: Random, depth: int, counter: str, indent: int) -> list[str]:
    pad, kind = "    " * indent, random.random()
    names = random.sample(NAMES, len(NAMES))
    constant = random.randrange(4)
    if depth and kind < 0.3:
        inner = "jk"[depth - 1]
        head = random.choice(_HEADS).format(inner, constant, random.choice([0, 1, counter]))
        lines = [pad + head, *_block(random, depth - 1, inner, indent + 1)]
        if random.random() < 0.2:
            test = random.choice(_TESTS).format(*names, i=inner, k=constant)
            lines += [f"{pad}    if {test}:", f"{pad}        break"]
        return lines
    if depth and kind < 0.45:
        test = random.choice(_TESTS).format(*names, i=counter, k=constant)
        lines = [f"{pad}if {test}:", *_block(random, depth - 1, counter, indent + 1)]
        if random.random() < 0.4:
            lines += [f"{pad}else:", *_block(random, depth - 1, counter, indent + 1)]
        return lines
    form = random.choice(_NAMED if kind < 0.75 else _STORED)
    return [pad + form.format(*names, i=counter)]


if __name__ == "__main__":
    command(random_source, "programs whose names change")()
