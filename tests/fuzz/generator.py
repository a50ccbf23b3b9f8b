"""Random well-typed kernels as source text: they terminate, stay within their arrays, and never
overflow 64 signed bits.
"""

from __future__ import annotations

import re
from random import Random

from tests.fuzz.aggregates import AGGREGATES, METHODS
from tests.fuzz.constants import Constant, random_constant
from tests.fuzz.lists import with_list
from tests.fuzz.places import Array, Places
from tests.fuzz.returned import returned
from tests.fuzz.statements import Program

DTYPES = (
    "int32",
    "int32",
    "float32",
    "uint8",
    "int8",
    "uint16",
    "int16",
    "boolean",
    "uint32",
)
SHAPES = (("L",), ("L",), ("L",), ("L", "M"), ("M", "L"), ("L", "L"), ("M", "K"), ("L", "M", "K"))
SMALL_SHAPES = (("M",), ("M",), ("M", "M"), ("M", "K"), ("K", "M"), ("M", "K", "M"))
DEEP_SHAPES = (("M", "K", "M", "K"), ("K", "M", "L", "M"), ("K", "K", "K", "M", "K"))
OWN = (
    Array("own", "int32", ("OWN",)),
    Array("own", "int32", ("OWN",)),
    Array("tiny", "uint8", ("FOUR", "FOUR")),
    Array("half", "int16", ("FOUR",)),
    Array("flag", "boolean", ("OWN",)),
    Array("sums", "float32", ("FOUR", "OWN")),
)
"""Arrays that kernels allocate."""

SCALARS = {
    "n": "int32",
    "m": "uint32",
    "m8": "uint8",
    "m16": "uint16",
    "n16": "int16",
    "p": "int64",
    "q": "int8",
    "r": "uint64",
    "w": "float32",
    "o": "boolean",
    "nL": "int32",
    "nM": "int32",
    "nK": "int32",
}
RETURNS = ("int32", "int32", "int8", "uint8", "int16", "uint16", "uint32", "float32", "boolean")
WIDE_RETURNS = ("int64", "uint64", *RETURNS)
HEADER = """import math
import numpy as np
from vividc.frontend import kernel
"""
TABLES = {
    "TABLE": "np.array([3, -1, 4, 4, -5, 9, 2, 1, 6, 2**31 - 1, 3, 5, -8, 9, 7, -2**31], np.int32)",
    "SMALL": "(7, -3, 12, 5)",
}
HELPERS = ("mix", "pair", "blend")
"""Kernels of `called`."""

STARTS = {
    "s": "s = np.int32(1)",
    "t": "t = np.int64(p)",
    "h": "h = np.uint64(r)",
    "z": "z = np.float32(0.5)",
    "k": "k = 0",
    "y": "y = np.uint8(200)",
    "f": "f = False",
    "own": "own = np.zeros(16, np.int32)",
    "tiny": "tiny = np.zeros((4, 4), np.uint8)",
    "half": "half = np.full(4, -3, np.int16)",
    "flag": "flag = np.zeros(16, np.bool_)",
    "sums": "sums = np.ones((4, 16), np.float32)",
}


def random_source(seed: int) -> str:
    """Source of a module whose `program` is a kernel. `SHAPES` names the dimensions of its arrays;
    `FIXED` says whether they have the lengths of `places.FIXED` or any.
    """
    random = Random(seed)
    is_fixed, is_wide = random.random() < 0.3, random.random() < 0.35
    shapes = SHAPES if random.random() < 0.7 else SMALL_SHAPES
    names = "abcde"[: random.randint(1, 4)]
    params = [Array(name, random.choice(DTYPES), random.choice(shapes)) for name in names]
    deep = Random(~seed)
    if deep.random() < _DEEP:
        params[0] = Array("a", params[0].dtype, deep.choice(DEEP_SHAPES))
    if random.random() < 0.3:
        params.append(Array("g", "float32", random.choice(shapes)))
    own = [random.choice(OWN)] if random.random() < 0.3 else []
    constants = [random_constant(random, f"G{k}") for k in range(_constants(random))]
    program = Program(
        random,
        [*params, *own, *(constant.array for constant in constants)],
        Places(random, params, is_fixed),
        random.choice(WIDE_RETURNS if is_wide else RETURNS),
        is_wide,
        inexact={"g"},
    )
    _with_arrays(program)
    body = _body(program)
    with_one = Random(f"list {seed}")
    if with_one.random() < _LISTS:
        body = with_list(with_one, body)
    other = Random(-seed)  # the programs of before stay as they were
    if body.count("return ") == 1 and other.random() < _RETURNING:
        arrays = [a for a in (*params, *own) if a.name != "g" and _uses(body, a.name)]
        head, result = body.rsplit("    return ", 1)
        body = head + returned(other, arrays, result.strip())
        program.returns = ""
    return _module(program, params, constants, body)


_DEEP = 0.1
"""Share of the programs that have an array of four or five dimensions."""
_LISTS = 0.1
"""Share of the programs that have a list which grows."""
_RETURNING = 0.2
"""Share of the programs that return arrays and tuples."""
OFTEN = 0.5
"""Where so many statements are about whole arrays, loops are fewer: the program stays small."""


def _constants(random: Random) -> int:
    return random.choice([0, 1, 1, 2])


def _with_arrays(program: Program) -> None:
    """What the program has beside scalars and elements: everything, or some of it."""
    random = program.random
    if random.random() < 0.15:
        return
    program.whole = random.choice([0.0, 0.3, 0.5, 0.7])
    program.more = AGGREGATES * random.choice([0, 1, 3]) + METHODS * random.choice([0, 1, 3])


def _body(program: Program) -> str:
    random, text = program.random, ""
    if random.random() < 0.2:
        text += program.statement(1, 1)
    depth = random.choice([1, 1, 2, 2, 2, 3] if program.whole < OFTEN else [0, 1, 1, 2])
    text += program.loop_over(depth, 1)
    for _ in range(random.choice([0, 0, 1, 2] if program.whole < OFTEN else [1, 2, 3])):
        text += program.statement(random.choice([0, 2]), 1)
    return f"{text}    return {program.result()}\n"


def _module(program: Program, params: list[Array], constants: list[Constant], body: str) -> str:
    starts = [name for name in STARTS if _uses(body, name)]
    body = "".join(f"    {STARTS[name]}\n" for name in starts) + body
    used = [array for array in params if _uses(body, array.name)]
    scalars = [name for name in SCALARS if _uses(body, name)]
    types = [f"{a.dtype}[{':, ' * (len(a.dims) - 1)}::1]" for a in used]
    types += [SCALARS[name] for name in scalars]
    parameters = ", ".join([a.name for a in used] + scalars)
    result = program.returns or ("" if types else "void")  # "(,)" would be no signature
    signature = f"{result}({', '.join(types)}{',' if not result else ''})"
    tables = TABLES | {constant.array.name: constant.text for constant in constants}
    head = "".join(f"{k} = {v}\n" for k, v in tables.items() if _uses(body, k))
    called = [name for name in HELPERS if _uses(body, name)]
    imports = f"from tests.fuzz.called import {', '.join(called)}\n" if called else ""
    kernel = f'\n\n@kernel("{signature}")\ndef program({parameters}):\n{body}'
    named = [constant for constant in constants if _uses(body, constant.array.name)]
    features = set().union(*(constant.features for constant in named))
    if named and program.random.random() < 0.4:
        features.add("constant array of a closure")
        kernel = (
            f"\n\ndef made():{_indented(head + kernel)}    return program\n\n\nprogram = made()\n"
        )
        head = ""
    text = f"# {', '.join(sorted(features))}\n{HEADER}{imports}"
    text += f"\nSHAPES = { {a.name: a.dims for a in used} }\n"
    text += f"FIXED = {program.places.is_fixed}\n"
    return text + head + kernel


def _indented(text: str) -> str:
    return "\n" + "".join(f"    {line}\n" if line else "\n" for line in text.splitlines())


def _uses(body: str, name: str) -> bool:
    return re.search(rf"\b{name}\b", body) is not None
