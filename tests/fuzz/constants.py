"""Random constant arrays as source text: in C and in Fortran order, slices, with steps that go
backwards, with axes of no element and of one.
"""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

import numpy as np

from tests.fuzz.places import Array, counted

DTYPES = ("int32", "int32", "int64", "float32", "float32", "uint8", "int16", "bool_", "uint32")
SHAPES = ((6,), (16,), (1,), (0,), (4, 4), (3, 5), (2, 8), (1, 6), (5, 1), (1, 1), (0, 3), (3, 0))
DEEP_SHAPES = ((2, 3, 4), (1, 3, 2), (3, 1, 4), (2, 2, 1), (2, 0, 3))

ORDERS = ("{x}", "{x}", "np.asfortranarray({x})", "{x}.T", "np.ascontiguousarray({x}.T)")
CUTS = (":", ":", ":", "::-1", "1:", ":-1", "::2", "1::2", "-2::-2", ":1", "0:0")


@dataclass(frozen=True, slots=True)
class Constant:
    """A constant array: what it is called, its source text, and what to look for in it."""

    array: Array
    text: str
    features: frozenset[str]


def random_constant(random: Random, name: str) -> Constant:
    """An array of up to 3 axes, in any layout that numpy has."""
    dtype = random.choice(DTYPES)
    shape = random.choice(SHAPES if random.random() < 0.8 else DEEP_SHAPES)
    text = random.choice(ORDERS).format(x=f"{_elements(random, dtype, shape)}.reshape{shape}")
    if len(shape) == 3 and random.random() < 0.5:
        text += f".transpose{tuple(random.sample(range(3), 3))}"
    if random.random() < 0.5:
        text += f"[{', '.join(random.choice(CUTS) for _ in shape)}]"
    value = eval(text, {"np": np})  # what numpy makes of the slices decides about the shape
    kind = "boolean" if dtype == "bool_" else dtype
    dims = tuple(counted(n) for n in value.shape)
    return Constant(Array(name, kind, dims, is_constant=True), text, _features(value))


def _elements(random: Random, dtype: str, shape: tuple[int, ...]) -> str:
    count = int(np.prod(shape))
    if dtype == "bool_":
        return f"(np.arange({count}) % {random.choice([2, 3])} == 0)"
    if dtype == "float32":
        return f"(np.arange({count}, dtype=np.float32) * {random.choice([1.25, -0.5, 3.0])} - 2)"
    step = random.choice([1, 7, 13, 100])
    start = 0 if dtype.startswith("u") else random.choice([0, 0, -20, -3])
    return f"(np.arange({count}) * {step} + {start}).astype(np.{dtype})"


def _features(value: np.ndarray) -> frozenset[str]:
    flags = value.flags
    layout = "C" if flags.c_contiguous else "F" if flags.f_contiguous else "A"
    found = {f"constant array, {layout} order"}
    if any(stride < 0 for stride in value.strides):
        found.add("constant array, backwards")
    if min(value.shape) < 2:
        found.add("constant array, axis of 0 or 1")
    return frozenset(found)
