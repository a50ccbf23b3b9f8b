"""Random integer kernels against numba, bit for bit; refusing is an answer, a wrong word is not."""

from __future__ import annotations

import importlib.util
from copy import deepcopy
from pathlib import Path

import numpy as np
import pytest

from tests.frontend.cfg_eval import run
from tests.frontend.random_kernels import random_kernel
from vividc.errors import KernelError, VividcWarning
from vividc.frontend import KernelFunction

FAST = range(12)
SLOW = range(100, 400)
RANGES = ((-(2**31), 2**31), (-20, 20), (0, 200))


def compiled(seed: int, folder: Path) -> KernelFunction:
    file = folder / f"program{seed}.py"
    file.write_text(random_kernel(seed), encoding="utf-8")
    spec = importlib.util.spec_from_file_location(f"program{seed}", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    kernel: KernelFunction = module.program
    return kernel


def check(seed: int, folder: Path) -> bool:
    """Whether the program was lowered; it must then agree with numba."""
    kernel = compiled(seed, folder)
    try:
        function = kernel.lower()
    except KernelError:  # a value that may not fit in a word
        return False
    except VividcWarning:  # numba makes a float64 of an int64 and a uint64
        return False
    for trial, (low, high) in enumerate(RANGES):
        rng = np.random.default_rng([seed, trial])
        x, y = (rng.integers(low, high, 16).astype(np.int32) for _ in range(2))
        u = rng.integers(0, 2 * high, 16).astype(np.uint32)
        args = (x, y, u, int(rng.integers(0, 16)), int(rng.integers(low, high)))
        expected, actual = deepcopy(args), deepcopy(args)
        assert kernel(*expected) == run(function, *actual, max_blocks=50_000)
        for one, other in zip(expected[:3], actual[:3], strict=True):
            np.testing.assert_array_equal(one, other)
    return True


def test_random_kernels_compute_what_numba_computes(tmp_path: Path) -> None:
    lowered = [check(seed, tmp_path) for seed in FAST]
    assert sum(lowered) >= len(lowered) // 2


@pytest.mark.slow
@pytest.mark.parametrize("seed", SLOW)
def test_more_random_kernels(seed: int, tmp_path: Path) -> None:
    check(seed, tmp_path)
