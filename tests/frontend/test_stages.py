"""Between any two stages of the frontend: well formed, read back as text, the same results."""

from __future__ import annotations

import importlib
import random
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.c_kernels import WORKLOADS as C_KERNELS
from benchmarks.workloads import Workload
from tests.frontend import test_wide, wide_kernels
from vividc.frontend import KernelFunction, kernel
from vividc.frontend.narrow.narrow import Narrowed
from vividc.frontend.stages import STRAIGHTENING, Pointers
from vividc.host.watch import Watch, name_of, watching
from vividc.ssa.check import check_function
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Function
from vividc.ssa.text import parse, to_text

NAMES = [item.name for item in test_wide.KERNELS]


class Seen(list[tuple[str, Function]]):
    """What each stage left."""

    def __call__(self, name: str, made: object) -> None:
        function = made.function if isinstance(made, Pointers | Narrowed) else made
        assert isinstance(function, Function)
        self.append((name, function))

    @property
    def resolved(self) -> list[tuple[str, Function]]:
        """From where accesses name their arrays, with the parameters that the last ones have."""
        first = [name for name, _ in self].index(name_of(STRAIGHTENING[0]))
        last = self[-1][1]
        return [
            (name, replace(function, params=last.params, returns=last.returns))
            for name, function in self[first:]
        ]


def stages_of(tested: KernelFunction) -> Seen:
    seen = Seen()
    with watching(Watch(seen)):
        tested.lower()
    assert seen[0][1].is_llvm
    assert not seen[-1][1].is_llvm
    return seen


def assert_well_formed(seen: Seen) -> None:
    for name, function in seen:
        assert check_function(function) == [], name
        assert parse(to_text(function)) == function, name


@pytest.mark.parametrize("name", NAMES)
def test_integers_of_64_bits(name: str) -> None:
    tested = getattr(importlib.reload(wide_kernels), name)
    seen = stages_of(tested)
    assert_well_formed(seen)
    rng = random.Random(name)
    for _ in range(5):
        args = [test_wide.argument(rng, tested, at) for at in range(len(tested.params))]
        if name.startswith("divides") and args[-1] == 0:
            continue
        expected = tested(*args)
        for stage, function in seen.resolved:
            assert interpret(function, *args, max_blocks=200_000) == expected, (stage, args)


@pytest.mark.parametrize("workload", C_KERNELS, ids=lambda one: one.name)
def test_functions_of_c(workload: Workload) -> None:
    seen = Seen()
    with watching(Watch(seen)):
        workload.kernel().lower()
    assert_well_formed(seen)


def test_memory_flags_and_small_integers() -> None:
    @kernel("int32(int8[::1], bool[::1], int16[:, ::1], float32[::1])")
    def mixed(x, on, table, y):
        total = 0
        own = np.zeros(4, np.int32)
        for i in range(len(x)):
            if on[i]:
                total += x[i] * table[i & 1, i & 3]
                own[i & 3] += x[i]
            y[i] = np.float32(total + own[i & 3])
            table[i & 1, 0] = np.int16(total)
        return np.int32(total)

    seen = stages_of(mixed)
    assert_well_formed(seen)

    def given() -> tuple[np.ndarray, ...]:
        rng = np.random.default_rng(3)
        return (
            rng.integers(-128, 128, 9).astype(np.int8),
            rng.integers(0, 2, 9).astype(np.bool_),
            rng.integers(-(2**15), 2**15, (2, 4)).astype(np.int16),
            np.zeros(9, np.float32),
        )

    expected = given()
    returned = mixed(*expected)
    for stage, function in seen.resolved:
        args = given()
        assert interpret(function, *args) == returned, stage
        for actual, wanted in zip(args, expected, strict=True):
            np.testing.assert_array_equal(actual, wanted, err_msg=stage)
