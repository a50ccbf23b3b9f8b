"""C loops of every form, and random C programs: lowered and evaluated, against LLVM on the host."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

import vividc
from vividc.frontend.c.source import bodies
from vividc.ssa.interpret import interpret as run

FOLDER = Path(__file__).parent / "c"
LOOPS = [body.name for body in bodies((FOLDER / "loops.ll").read_text())]
RANDOM = [body.name for body in bodies((FOLDER / "random.ll").read_text())]
NUMBERS = ((0, 0), (1, 1), (5, 3), (12, 7), (-3, 9), (9, -2), (2, 5))


@cache
def loaded(file: str, name: str) -> vividc.LLKernel:
    types = {"arg0": "int32", "arg1": "int32", "arg2": "uint32", "arg3": "float32"}
    return vividc.load_ll(FOLDER / f"{file}.ll", name, types=types if file == "random" else None)


@pytest.mark.parametrize("name", LOOPS)
def test_loops(name: str) -> None:
    kernel = loaded("loops", name)
    function = kernel.lower()
    for n, m in NUMBERS:
        ours = np.random.default_rng(5).integers(0, 9, 16).astype(np.int32)
        host = ours.copy()
        assert run(function, ours, n, m) == kernel(host, n, m)
        np.testing.assert_array_equal(ours, host)


COUNTED = {"up", "up_by_three", "until", "last_value", "before_last", "clear"}
COUNTED |= {"wide_counter", "unsigned_count", "move_down"}


@pytest.mark.parametrize("name", sorted(COUNTED))
def test_loops_test_before_their_first_iteration(name: str) -> None:
    blocks = loaded("loops", name).lower().blocks
    at_end = [block for block in blocks if block.name in block.branch.successors]
    assert not at_end


@pytest.mark.parametrize("name", RANDOM)
def test_random_programs(name: str) -> None:
    kernel = loaded("random", name)
    function = kernel.lower()
    for n, m in NUMBERS[:4]:
        ours, host = arrays(), arrays()
        assert run(function, *ours, n, m) == kernel(*host, n, m)
        for mine, theirs in zip(ours, host, strict=True):
            np.testing.assert_array_equal(mine.view(np.uint32), theirs.view(np.uint32))


def arrays() -> tuple[np.ndarray, ...]:
    rng = np.random.default_rng(5)
    return (
        rng.integers(-50, 50, 16, dtype=np.int32),
        rng.integers(-(2**31), 2**31, 16).astype(np.int32),
        rng.integers(0, 2**32, 16, dtype=np.uint32),
        rng.standard_normal(16).astype(np.float32),
    )
