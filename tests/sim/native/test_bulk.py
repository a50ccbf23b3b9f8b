"""Loops by tables give what the reference engine gives: memory, time, every count, errors."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from tests.program.hand_kernels import dot, fabric, pairs, positive, saxpy
from tests.programs import WORDS, programs
from tests.sim.native.agreement import assert_engines_agree, launch
from tests.sim.native.mutations import mutated
from tests.sim.test_against_interpreter import FABRICS, compiled
from vividc.errors import BundleError
from vividc.gemm import GemmProgram, gemm_program
from vividc.gemm.program import Operands
from vividc.gemm.systolic import STREAMS, Precision, Stream
from vividc.program import Program
from vividc.sim import Launch
from vividc.sim.native import engine
from vividc.sim.native.bulk import tables as bulk_tables
from vividc.sim.native.code import compiled as native_code


@pytest.fixture(autouse=True)
def all_loops_by_tables(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bulk_tables, "BULK_OPS", 0)
    monkeypatch.setattr(bulk_tables, "ROWS", 1)  # the window moves in every body


def floats(count: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(count).astype(np.float32)


def demand_tables(program: Program) -> None:
    assert any(tables is not None for tables in native_code(program).plan.tables)


@pytest.mark.parametrize("n", [-1, 0, 1, 2, 5, 100])
def test_counted_loops(n: int) -> None:
    x, y = floats(max(n, 1)), floats(max(n, 1), 1)
    program = saxpy(fabric())
    demand_tables(program)
    assert_engines_agree(program, launch(program, x, y, n))
    program = dot(fabric(latencies="{fma: 4}"))
    assert_engines_agree(program, launch(program, x, y, n))


def test_faults_limits_and_bank_conflicts() -> None:
    program = saxpy(fabric())
    assert_engines_agree(program, *(launch(program, floats(n), floats(8), 8) for n in range(1, 9)))
    limited = (launch(program, floats(8), floats(8), 8, cycle_limit=n) for n in range(0, 60, 4))
    assert_engines_agree(program, *limited)
    program = pairs(fabric(), 8)
    x = np.arange(18, dtype=np.int32)
    assert_engines_agree(program, launch(program, x, np.zeros(10, np.int32), 10))
    program = positive(fabric())
    x = np.array([3, -1, 0, 2, -5], np.int32)
    assert_engines_agree(program, launch(program, x, np.full(5, 9, np.int32), 5))


@pytest.mark.parametrize("name", sorted(FABRICS))
@settings(
    max_examples=12,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(programs())
def test_random_programs(name: str, source: tuple[object, ...]) -> None:
    program, _ = compiled(source, FABRICS[name])
    assert_engines_agree(program, launch(program, np.arange(WORDS, dtype=np.int32)))


def product(
    depth: int, blocks: int, *, relu: bool, precision: Precision = "f32"
) -> tuple[GemmProgram, Launch]:
    made = gemm_program("vivid-8x8", depth, relu=relu, precision=precision)
    size = made.layout.room * STREAMS
    values = floats(size, 3).reshape(-1, STREAMS)
    if precision == "f32":
        values[5, Stream.A], values[9, Stream.B] = np.nan, np.inf
    else:
        codes = np.random.default_rng(4).integers(0, 256, 4 * size, np.uint8)
        values = codes.view(np.float32).reshape(-1, STREAMS)
    given = Operands(Stream.A, Stream.C, depth, 7, blocks, range(1))
    return made, launch(made.program, *made.launch(values, given))


@pytest.mark.parametrize(("depth", "blocks"), [(1, 3), (5, 1), (9, 7), (14, 40)])
@pytest.mark.parametrize("relu", [False, True])
def test_products(depth: int, blocks: int, relu: bool) -> None:
    made, given = product(depth, blocks, relu=relu)
    demand_tables(made.program)
    assert_engines_agree(made.program, given)


@pytest.mark.parametrize("precision", ["f16", "e4m3", "e5m2"])
def test_products_of_narrow_numbers(precision: Precision) -> None:
    made, given = product(9, 30, relu=False, precision=precision)
    demand_tables(made.program)
    assert_engines_agree(made.program, given)


def test_a_suspended_product_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine, "CYCLES_A_CALL", 40)
    made, given = product(6, 20, relu=True)
    assert_engines_agree(made.program, given)


def test_neighbours_share_entries() -> None:
    made, _ = product(14, 1, relu=False)
    (tables,) = [t for t in native_code(made.program).plan.tables if t is not None]
    entries = [
        int(tables.words[section.entries - 1])
        for section in tables.sections
        if section.variant.op in bulk_tables.VECTORS
    ]
    array = made.layout.rows * made.layout.cols
    assert sum(entries) < array * made.layout.depth / 2


def test_mutated_products() -> None:
    made, given = product(2, 5, relu=True)
    random, ran = Random(1), 0
    for _ in range(12):
        changed = mutated(made.program, random)
        try:
            changed.entries  # noqa: B018 - decoding tells whether a PE can do it
        except BundleError:
            continue
        assert_engines_agree(changed, given)
        ran += 1
    assert ran > 6
