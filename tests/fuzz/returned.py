"""What a random kernel returns besides a number: arrays that it makes, parts of its parameters,
tuples of them and of numbers, and one of several arrays by a condition.
"""

from __future__ import annotations

from random import Random

from tests.fuzz.places import Array

CUTS = ("", "[1:]", "[::-1]", "[::2]", "[:-1]", "[s & 3:]", "[:s & 3]")
"""Slices; `s` is an integer that only the run knows."""
MAKERS = (
    "{a}.copy()",
    "{a} + {a}",
    "np.zeros_like({a})",
    "np.maximum({a}, {a}[..., ::-1])",
    "{a}[::2].copy()",
    "np.arange({n})",
    "np.full(({n}, 3), s & 7)",
)


def returned(random: Random, arrays: list[Array], result: str) -> str:
    """The last lines of a kernel: one statement or more, which may return before the last."""
    if not arrays:
        return f"    return {result}, np.arange(4)\n"
    array = random.choice(arrays)
    if random.random() < 0.2:
        text = random.choice(["raise ValueError", 'raise OverflowError("too many")'])
        head = f"    if s & {random.choice([1, 3, 7])} == 0:\n        {text}\n"
        return f"{head}    return {_array(random, array)}\n"
    kind = random.random()
    if kind < 0.25:
        return f"    return {_array(random, array)}\n"
    if kind < 0.4:
        maker = random.choice(MAKERS[:2]).format(a=array.name)
        early = random.choice(MAKERS[:2]).format(a=array.name)
        return f"    if s & 1 == 0:\n        return {early}\n    return {maker}\n"
    if kind < 0.5:
        text = "    if s & 1 == 0:\n        return None\n"
        return f"{text}    return {_array(random, array)}\n"
    parts = [_array(random, random.choice(arrays)) for _ in range(random.randint(1, 3))]
    parts.insert(random.randint(0, len(parts)), result)
    if random.random() < 0.2:
        parts[0] = f"({parts[0]}, None)"
    return f"    return {', '.join(parts)}\n"


def _array(random: Random, array: Array) -> str:
    """A part of an array, or one that is made of it."""
    if random.random() < 0.5:
        return array.name + random.choice(CUTS)
    count = random.choice(["s & 3", f"len({array.name})", "4"])
    return random.choice(MAKERS).format(a=array.name, n=count)
