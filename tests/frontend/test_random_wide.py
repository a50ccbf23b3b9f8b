"""Random kernels on 64-bit integers against numba, bit for bit: the lowered function, and the
regions after all passes.
"""

from __future__ import annotations

import importlib.util
from copy import deepcopy
from pathlib import Path

import numpy as np
import pytest

from tests.frontend.random_wide import random_wide_kernel
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.interpret.interpreter import interpret
from vividc.dfg.pipeline import optimize_kernel
from vividc.errors import KernelError
from vividc.frontend import KernelFunction
from vividc.machine.params import DType, joined
from vividc.ssa.interpret import interpret as run

FAST = range(14)
SLOW = (*range(14, 24), *range(1000, 1400))
LENGTH = 6
TRIALS = 4
EDGES = (0, 1, 2**31, 2**32, 2**63, 2**64)


def compiled(seed: int, folder: Path) -> KernelFunction:
    file = folder / f"wide{seed}.py"
    file.write_text(random_wide_kernel(seed), encoding="utf-8")
    spec = importlib.util.spec_from_file_location(f"wide{seed}", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    kernel: KernelFunction = module.program
    return kernel


def integers(rng: np.random.Generator, count: int) -> list[int]:
    """Integers of 64 bits of all magnitudes, and next to powers of two."""
    found = []
    for _ in range(count):
        if rng.random() < 0.3:
            value = int(rng.choice(np.array(EDGES, object))) + int(rng.integers(-2, 3))
        else:
            value = int(rng.integers(0, 2**63)) >> int(rng.integers(0, 63))
        found.append((value if rng.random() < 0.5 else -value) % 2**64)
    return found


def arguments(seed: int, trial: int) -> tuple[object, ...]:
    rng = np.random.default_rng([seed, trial])
    x = np.array([value % 2**32 for value in integers(rng, LENGTH)], np.uint32).view(np.int32)
    u = np.array([value % 2**32 for value in integers(rng, LENGTH)], np.uint32)
    p, q = integers(rng, 2)
    if trial == 0:
        p = int(rng.integers(-50, 50)) % 2**64
    return x, u, np.zeros(LENGTH, np.float32), p - (p >> 63 << 64), q


def check(seed: int, folder: Path) -> bool:
    """Whether the program was lowered; it must then agree with numba."""
    kernel = compiled(seed, folder)
    try:
        function = kernel.lower()
    except KernelError:  # a division of words by other than a power of two
        return False
    regions = optimize_kernel(build_kernel(function))
    for trial in range(TRIALS):
        args = arguments(seed, trial)
        expected, lowered, interpreted = deepcopy(args), deepcopy(args), deepcopy(args)
        value = kernel(*expected)
        assert run(function, *lowered, max_blocks=50_000) == value
        assert interpreted_value(regions, interpreted) == value
        for actual in (lowered, interpreted):
            for one, other in zip(expected[:3], actual[:3], strict=True):
                np.testing.assert_array_equal(one, other)
    return True


def interpreted_value(regions: object, args: tuple[object, ...]) -> int:
    """The DFG interpreter's result; arrays are updated in place."""
    x, u, f, p, q = args
    memory = np.concatenate([array.view(np.uint32) for array in (x, u, f)])
    inputs = {"p": p, "p.high": p >> 32, "q": q, "q.high": q >> 32}
    inputs |= {"&x": 0, "&u": 4 * LENGTH, "&f": 8 * LENGTH}
    inputs |= {f"{name}.shape0": LENGTH for name in "xuf"}
    words = {key: word & 0xFFFFFFFF for key, word in inputs.items()}
    result = interpret(regions, memory, words)
    for array, part in zip((x, u, f), np.split(memory, 3), strict=True):
        array[:] = part.view(array.dtype)
    assert result.value is not None
    whole = result.value
    return whole - 2**64 if regions.returns is DType.I64 and whole >> 63 else whole


def test_random_wide_kernels_compute_what_numba_computes(tmp_path: Path) -> None:
    lowered = [check(seed, tmp_path) for seed in FAST]
    assert sum(lowered) >= len(lowered) * 2 // 3


@pytest.mark.slow
@pytest.mark.parametrize("seed", SLOW)
def test_more_random_wide_kernels(seed: int, tmp_path: Path) -> None:
    check(seed, tmp_path)


@pytest.mark.parametrize(
    ("dtype", "low", "high", "whole"),
    [
        (DType.I64, 5, None, 5),
        (DType.I64, 0x80000000, None, 0xFFFFFFFF80000000),
        (DType.U64, 0x80000000, None, 0x80000000),
        (DType.I64, 1, 2, 0x200000001),
        (DType.U32, 0x80000000, None, 0x80000000),
    ],
)
def test_a_returned_word_is_extended_as_its_type_says(
    dtype: DType, low: int, high: int | None, whole: int
) -> None:
    assert joined(dtype, low, high) == whole
