"""Constant subscripts of parameters: found, kept through LLVM, and true."""

from __future__ import annotations

import copy
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.frontend import subscript_kernels as k
from vividc.frontend import KernelFunction
from vividc.ssa.interpret import interpret as run

Load = Callable[[str, str], KernelFunction]


@pytest.fixture
def load(tmp_path: Path) -> Load:
    """Makes a kernel of a module's source."""

    def make(source: str, name: str) -> KernelFunction:
        path = tmp_path / f"{name}.py"
        path.write_text(source)
        scope: dict[str, object] = {"__name__": name}
        exec(compile(source, str(path), "exec"), scope)
        found = scope["program"]
        assert isinstance(found, KernelFunction)
        return found

    return make


def marks(kernel: KernelFunction) -> set[tuple[str, tuple[int | None, ...]]]:
    accesses = (i for block in kernel.lower().blocks for i in block.instrs if i.array)
    return {(i.array, i.subscript) for i in accesses if i.subscript}


def test_constants_of_a_subscript_are_known() -> None:
    assert marks(k.columns) == {
        ("a", (None, 1)),
        ("a", (0, 2)),
        ("a", (None, 2)),
        ("b", (None, 0)),
        ("b", (None, 2)),
    }
    assert marks(k.planes) == {("a", (0, None, 1)), ("a", (1, None, 1)), ("a", (0, 0, None))}


@pytest.mark.parametrize("kernel", [k.others, k.overlapping_rows])
def test_views_helpers_and_flat_indices_tell_nothing(kernel: KernelFunction) -> None:
    """But for an element that a parameter's own subscripts select."""
    assert marks(kernel) <= {("a", (None, 0))}


def check(kernel: KernelFunction, *args: object) -> None:
    """Against numba; `run` checks each marked access's element."""
    expected, actual = copy.deepcopy(args), copy.deepcopy(args)
    assert run(kernel.lower(), *actual) == kernel(*expected)
    for one, other in zip(expected, actual, strict=True):
        assert np.array_equal(one, other)


def test_marked_kernels_against_numba() -> None:
    a = np.arange(12, dtype=np.int32).reshape(4, 3)
    check(k.columns, a, a[::-1].copy())
    check(k.planes, np.arange(27, dtype=np.int32).reshape(3, 3, 3))
    check(k.others, a, np.arange(9, dtype=np.int32), np.int32(1))


@pytest.mark.parametrize("seed", range(16))
def test_random_marks_are_true(load: Load, seed: int) -> None:
    kernel = load(k.random_program(seed), "program")
    check(kernel, *k.arguments(seed, 3 + seed % 2))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(16, 1000))
def test_many_random_marks_are_true(load: Load, seed: int) -> None:
    kernel = load(k.random_program(seed), "program")
    check(kernel, *k.arguments(seed, 3 + seed % 2))
