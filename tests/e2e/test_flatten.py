"""Flattened kernels through mapper, words and engine: memory as numba leaves it."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

import vividc
from tests.e2e import nest_kernels
from vividc import arch
from vividc.compiler.regions.map_regions import map_kernel
from vividc.compiler.stage import CompileOptions
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.pipeline import optimize_kernel
from vividc.mapper import MapResult
from vividc.program import Program, encode
from vividc.ssa.flow import find_loops
from vividc.ssa.ir import Function
from vividc.ssa.loops.flatten.flatten import flatten

Arguments = tuple[object, ...]
SHAPES = ((0, 0), (0, 3), (3, 0), (1, 1), (2, 3), (5, 2), (4, 7))


def array(*shape: int) -> np.ndarray:
    return np.random.default_rng(5).integers(-50, 50, shape, dtype=np.int32)


MAKERS: dict[str, Callable[[int, int], Arguments]] = {
    "scale": lambda n, m: (array(n, m), np.int32(7)),
    "add_inside": lambda n, m: (array(n, m), array(m)),
    "scan_rows": lambda n, m: (array(n, m),),
    "scan_columns": lambda n, m: (array(n, m),),
    "columns_first": lambda n, m: (array(n, m),),
    "row_sums_in_memory": lambda n, m: (array(n, m), array(n)),
    "weighted_rows": lambda n, m: (array(n, m), array(m), array(n)),
    "stairs": lambda n, m: (array(n + 1), np.int32(n)),
    "first_large": lambda n, m: (array(n, m), np.int32(35)),
    "product": lambda n, m: (array(n, m), array(m, 3), array(n, 3)),
    "smooth": lambda n, m: (array(n, m), array(n, m), np.int32(2)),
}
II = {
    "scale": 1,  # the index is the iteration index
    "add_inside": 2,  # the counter of the row: compare, select
    "weighted_rows": 2,
    "columns_first": 2,
}


def flattened(function: Function, times: int) -> Function:
    """`function` with each outer loop flattened, up to `times` deep."""
    for _ in range(times):
        for loop in find_loops(function):
            function = flatten(function, loop.header) or function
    return function


@cache
def compiled(name: str, times: int = 1) -> tuple[Program, dict[int, MapResult]]:
    machine = arch.load("vivid-tile")
    function = flattened(getattr(nest_kernels, name).lower(), times)
    mapped, results = map_kernel(optimize_kernel(build_kernel(function)), machine, CompileOptions())
    mappings = {i: r.mapping for i, r in results.items() if r.mapping is not None}
    return encode(mapped, machine, mappings, reports=results), results


def assert_as_numba(kernel: vividc.KernelFunction, program: Program, arguments: Arguments) -> None:
    by_array = tuple(a.copy() if isinstance(a, np.ndarray) else a for a in arguments)
    by_numba = tuple(a.copy() if isinstance(a, np.ndarray) else a for a in arguments)
    result = vividc.simulate(program, *by_array)
    assert result.value == kernel(*by_numba)
    for mine, theirs in zip(by_array, by_numba, strict=True):
        np.testing.assert_array_equal(mine, theirs)


@pytest.mark.parametrize("name", MAKERS)
def test_a_flattened_kernel_is_right_for_any_lengths(name: str) -> None:
    program, _ = compiled(name)
    for shape in SHAPES:
        assert_as_numba(getattr(nest_kernels, name), program, MAKERS[name](*shape))


@pytest.mark.parametrize("name", ["product", "smooth"])
def test_three_loops_become_one(name: str) -> None:
    program, _ = compiled(name, 2)
    for shape in SHAPES:
        assert_as_numba(getattr(nest_kernels, name), program, MAKERS[name](*shape))


@pytest.mark.parametrize("name", II)
def test_what_a_flattened_loop_costs(name: str) -> None:
    program, results = compiled(name)
    loops = [i for i, region in enumerate(program.regions) if region.kind == "loop"]
    assert [results[i].ii for i in loops] == [II[name]]
