"""Intervals hold every value that the machine can compute from values of their operands."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import prange

import vividc
from vividc.machine.opcodes import OPCODES, Opcode
from vividc.machine.parallel import Access, Parallel, Term, is_well_formed
from vividc.machine.semantics import SEMANTICS, evaluate
from vividc.machine.words import WORD_MASK, signed
from vividc.sim.footprint.footprint import Touch, chunk_inputs, loop_bounds, touched
from vividc.ssa.parallel.cut import cut_parallel_loop

OPS = [
    op
    for op in SEMANTICS
    if op.value
    in ("add", "sub", "mul", "mulhu", "and", "shl", "lshr", "ashr", "smin", "smax", "xor", "or")
    or op.value.startswith("icmp")
]
EDGES = [0, 1, -1, 5, 31, 32, 1000, 2**31 - 1, -(2**31), 2**16]
WORDS = st.one_of(st.sampled_from(EDGES), st.integers(-(2**31), 2**31 - 1), st.integers(-40, 40))
SIZE = 1 << 33


def reach(terms: tuple[Term, ...], first: int, last: int, **inputs: int) -> Touch:
    """What an access to byte `terms[-1]` touches, moved so that no byte is below 0."""
    parallel = Parallel(terms, 0, 0, (Access("x", False, len(terms) - 1, 0, 1 << 31, 1),))
    return touched(parallel, inputs, {"x": SIZE}, first, last)["x"]


@given(st.sampled_from(OPS), WORDS, WORDS, WORDS, st.integers(0, 3))
def test_an_operation_stays_in_its_interval(op: Opcode, a: int, b: int, c: int, at: int) -> None:
    """One operand runs through an interval, the other has one value."""
    low, high = sorted((a, b))
    terms = (Term("index"), Term("const", word=c), Term(op.value, (0, 1) if at % 2 else (1, 0)))
    touch = reach(terms, low, high + 1)
    for value in {low, high, (low + high) // 2, min(low + at, high), max(high - at, low)}:
        pair = (value, c) if at % 2 else (c, value)
        word = signed(evaluate(op, [item & WORD_MASK for item in pair]))
        assert touch.loads is not None
        assert touch.loads == (0, SIZE) or touch.loads[0] <= word + 2**31 < touch.loads[1]


@given(WORDS, WORDS, st.integers(1, 100), st.sampled_from(["sdiv", "udiv", "srem", "urem"]))
def test_divisions_stay_in_their_interval(a: int, b: int, by: int, op: str) -> None:
    low, high = sorted((a, b))
    terms = (Term("index"), Term("const", word=by), Term(op, (0, 1)))
    touch = reach(terms, low, high + 1)
    for value in {low, high, (low + high) // 2}:
        dividend = value & WORD_MASK if op[0] == "u" else value
        quotient = abs(dividend) // by * (1 if dividend >= 0 else -1)
        word = signed((quotient if op.endswith("div") else dividend - quotient * by) & WORD_MASK)
        assert touch.loads is not None
        assert touch.loads == (0, SIZE) or touch.loads[0] <= word + 2**31 < touch.loads[1]


@pytest.mark.parametrize(
    ("clamp", "expected"),
    [("lt", (0, 4)), ("le", (0, 5)), ("gt", (6, 9)), ("ge", (5, 9)), ("eq", (5, 5))],
)
def test_clamps(clamp: str, expected: tuple[int, int]) -> None:
    terms = (Term("index"), Term("const", word=5), Term(clamp, (0, 1)))
    base = 2**31
    assert reach(terms, 0, 10).loads == (base + expected[0], base + expected[1] + 1)


def test_what_cannot_happen_touches_nothing() -> None:
    terms = (Term("index"), Term("const", word=50), Term("gt", (0, 1)))
    assert reach(terms, 0, 10).loads is None


def test_loops_run_between_their_bounds() -> None:
    base = 2**31
    table = (Term("const", word=3), Term("input", key="n"), Term("const", word=1))
    assert reach((*table, Term("counter", (0, 1, 2))), 0, 1, n=10).loads == (base + 3, base + 11)
    steps = (Term("const", word=3), Term("const", word=-2), Term("const", word=4))
    assert reach((*steps, Term("steps", (0, 1, 2))), 0, 1).loads == (base - 3, base + 4)


def test_accesses_are_cut_at_the_array() -> None:
    parallel = Parallel(
        (Term("index"),), 0, 0, (Access("x", False, 0, 2, -4, 4), Access("x", True, 0, 2, 0, 4))
    )
    found = touched(parallel, {}, {"x": 40, "y": 8}, 0, 4)
    assert (found["x"].loads, found["x"].stores, found["x"].hull) == ((0, 12), (0, 16), (0, 16))
    assert found["y"] == Touch()


def test_bounds_and_starts_of_chunks() -> None:
    terms = (Term("const", word=1), Term("input", key="n"))
    parallel = Parallel(terms, 0, 1, ())
    assert loop_bounds(parallel, {"n": 7}) == (1, 7)
    assert loop_bounds(parallel, {"n": 2**32 - 3}) == (1, 1)
    assert chunk_inputs(parallel, -1, 5, (), True) == {
        "prange.first": WORD_MASK,
        "prange.last": 5,
    }


def test_a_table_out_of_order_is_noticed() -> None:
    assert is_well_formed((Term("index"), Term("add", (0, 0))))
    assert not is_well_formed((Term("add", (0, 0)),))
    assert not is_well_formed((Term("index"), Term("add", (0,))))
    assert not is_well_formed((Term("index"), Term("run", (0,))))
    assert OPCODES[Opcode.ADD].arity == 2


@vividc.kernel("void(int32[::1], int32[::1], int32)")
def backwards(x, y, n):
    for i in prange(n):
        y[n - 1 - i] = x[len(x) - 1 - i]


def test_reversed_arrays_are_cut() -> None:
    _, parallel = cut_parallel_loop(backwards.lower(spread=True), backwards.prange_lines)
    inputs = {"n": 100, "x.shape0": 300, "y.shape0": 200}
    found = touched(parallel, inputs, {"x": 1200, "y": 800}, 10, 20)
    assert found["y"].stores == (4 * 80, 4 * 90)
    assert found["x"].loads == (4 * 280, 4 * 290)
