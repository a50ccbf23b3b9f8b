"""Random chains side by side in float16 and float8: packed, they leave the words of numba."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path
from random import Random

import numpy as np
import pytest

from tests.fuzz.witnesses import load, run_regions
from tests.marks import with_slow
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.pipeline import PassOptions, optimize_kernel
from vividc.ssa.check import check_function
from vividc.ssa.formats.pack_lanes import pack_lanes
from vividc.ssa.ir import Function
from vividc.ssa.rewrite.normalize import normalize

HEAD = """\
import numpy as np
import vividc
from vividc import lang


@vividc.kernel("void(float32[::1], float16[::1], uint8[::1], float32[::1], int32, int32)")
def program(x, h, q, out, n, m):
    const = lang.{cast}(0.75)
    for i in range(n):
"""
FORMS = {
    "add": "c{t} + {u}",
    "sub": "{v} - c{t}",
    "mul": "c{t} * {u}",
    "fma": "lang.fma(c{t}, {u}, {v})",
    "neg": "-c{t}",
    "abs": "abs(c{t})",
    "select": "c{t} if {u} < {v} else {u}",
    "max": "max(c{t}, {u})",
    "cross": "c{t} + c{next}",
}
SPECIAL = [0.0, -0.0, np.nan, np.inf, 1e-7, 448.0, 65504.0, -1.0]
ROWS, LENGTH = 5, 32
LONG = {1, 3, 5, 9}
"""Seeds whose programs take longest to compile."""


def _source(random: Random) -> str:
    """Chains that are alike but for a few steps."""
    cast, width = random.choice(["fp16", "fp8", "e5m2"]), random.choice([2, 3, 4, 5, 8])
    lines, source = [], random.choice(["x", "x", "h"])
    for t in range(width):
        other = t if random.random() < 0.8 else 0
        lines += [f"        a{t} = lang.{cast}({source}[(i * {width} + {t}) % 32])"]
        lines += [f"        b{t} = lang.{cast}(x[(i + {other}) % 32])", f"        c{t} = a{t}"]
    if random.random() < 0.7:
        lines.append("        for j in range(m):")
    indent = "            " if "for" in lines[-1] else "        "
    for _ in range(random.randint(1, 4)):
        form, u, v = random.choice(list(FORMS)), random.randrange(3), random.randrange(4)
        for t in range(width):
            read = (f"a{t}", f"b{t}", f"c{t}", "const")
            own = form if random.random() < 0.95 else "mul"
            text = FORMS[own].format(t=t, u=read[u], v=read[v], next=(t + 1) % width)
            lines.append(f"{indent}c{t} = {text}")
    for t in range(width):
        where = f"[(i * {width} + {t}) % 32 + 32 * i]"
        stores = (f"out{where} = np.float32(c{t})", f"q{where} = lang.bits_of(c{t}) & 255")
        lines.append(f"        {random.choice(stores)}")
    return HEAD.format(cast=cast) + "\n".join(lines) + "\n"


def _arguments(seed: int) -> list[object]:
    rng = np.random.default_rng(seed)
    x = np.concatenate([2 * rng.standard_normal(24), SPECIAL]).astype(np.float32)
    h = rng.standard_normal(LENGTH).astype(np.float16)
    size = ROWS * LENGTH
    results = [np.zeros(size, np.uint8), np.zeros(size, np.float32)]
    return [x, h, *results, np.int32(ROWS), np.int32(3)]


def _words(function: Function, args: list[object]) -> list[object]:
    lowered = optimize_kernel(build_kernel(normalize(function)), PassOptions(contract=False))
    mine = deepcopy(args)
    run_regions(lowered, mine)
    return mine


@pytest.mark.parametrize("seed", with_slow(range(10), LONG))
def test_packing_keeps_every_word(seed: int, tmp_path: Path) -> None:
    kernel = load(_source(Random(seed)), tmp_path).program
    args = _arguments(seed)
    expected = deepcopy(args)
    kernel(*expected)
    function = normalize(kernel.lower())
    packed = pack_lanes(function)
    assert check_function(packed) == []
    for form in (function, packed):
        for got, wanted in zip(_words(form, args), expected, strict=True):
            assert np.array_equal(got, wanted, equal_nan=got.dtype.kind == "f")


def test_some_of_the_programs_are_packed(tmp_path: Path) -> None:
    packed = 0
    for seed in range(5):
        function = normalize(load(_source(Random(seed)), tmp_path).program.lower())
        packed += pack_lanes(function) is not function
    assert packed >= 2
