"""Every elementary function of floats: its operations and its error, as docs/math.md states them,
and its special values.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.dfg.expand.vectorised import (
    SPECIALS,
    by_semantics,
    expanded,
    graph,
    interpreted,
    random_words,
)
from vividc.dfg.check import check
from vividc.dfg.expand.expand import expand_math
from vividc.machine.opcodes import OPCODES, Opcode

PAGE = Path(__file__).resolve().parents[3] / "docs" / "math.md"
ROW = re.compile(r"^\| `(\w+)` \| .*? \| (\d+) \| ([\d.]+) \|", re.MULTILINE)
TABLE = {Opcode(op): (int(n), float(ulp)) for op, n, ulp in ROW.findall(PAGE.read_text())}
EXACT: dict[Opcode, Callable[..., np.ndarray]] = {
    Opcode.EXPM1: np.expm1,
    Opcode.LOG: np.log,
    Opcode.LOG2: np.log2,
    Opcode.LOG10: np.log10,
    Opcode.LOG1P: np.log1p,
    Opcode.POW: np.power,
    Opcode.SIN: np.sin,
    Opcode.COS: np.cos,
    Opcode.TAN: np.tan,
    Opcode.ASIN: np.arcsin,
    Opcode.ACOS: np.arccos,
    Opcode.ATAN: np.arctan,
    Opcode.ATAN2: np.arctan2,
    Opcode.SINH: np.sinh,
    Opcode.COSH: np.cosh,
    Opcode.TANH: np.tanh,
    Opcode.HYPOT: np.hypot,
    Opcode.TRUNC: np.trunc,
    Opcode.RINT: np.rint,
    Opcode.FREM: np.fmod,
}
"""In binary64; `exp`, `exp2`, `fdiv`, `sqrt`, `floor` and `ceil` have tests of their own."""
UNARY = [op for op in EXACT if OPCODES[op].arity == 1]
BINARY = [op for op in EXACT if OPCODES[op].arity > 1]
NAN = 0x7FC00000
CHUNK = 1 << 19


def errors(op: Opcode, results: np.ndarray, *operands: np.ndarray) -> np.ndarray:
    """Errors in ulp. NaNs, infinities and the sign of every result must be exact; an overflow may
    come early or late by the error itself.
    """
    with np.errstate(all="ignore"):
        exact = EXACT[op](*(words.view(np.float32).astype(np.float64) for words in operands))
        rounded = exact.astype(np.float32)
    ours = results.view(np.float32).astype(np.float64)
    nan = np.isnan(exact)
    assert np.all(results[nan] == NAN)
    assert not np.isnan(ours[~nan]).any()
    assert np.array_equal(np.signbit(ours[~nan]), np.signbit(exact[~nan]))
    limit = float(np.finfo(np.float32).max) * (1 + 4 * 2.0**-24)
    edge = np.abs(exact) > limit
    assert np.array_equal(ours[edge & ~nan], rounded[edge & ~nan])
    inside = ~nan & ~edge & np.isfinite(ours)
    assert np.all(np.abs(exact[~nan & ~edge & np.isinf(ours)]) > limit * (1 - 2.0**-20))
    exponent = np.maximum(np.frexp(exact[inside])[1], -125)
    return np.abs(ours[inside] - exact[inside]) / np.ldexp(1.0, exponent - 24)


def assert_within_bound(op: Opcode, *operands: np.ndarray) -> None:
    found = errors(op, expanded(op, *operands), *operands)
    assert found.max(initial=0.0) <= TABLE[op][1]


def around(*numbers: float) -> np.ndarray:
    """Words beside these numbers and their negatives."""
    words = np.array(numbers, np.float32).view(np.uint32)
    near = (words[:, None] + np.arange(-30, 31)).astype(np.uint32).ravel()
    return np.concatenate([near, near ^ np.uint32(0x80000000)])


def unary_sample() -> np.ndarray:
    """Every 131,071st word, words of moderate numbers, and those beside the ends of intervals."""
    rng = np.random.default_rng(3)
    strided = np.arange(0, 1 << 32, 131071, dtype=np.uint64).astype(np.uint32)
    moderate = rng.normal(0, 4, 20000).astype(np.float32).view(np.uint32)
    multiples = (np.arange(1, 2000) * (np.pi / 4)).astype(np.float32).view(np.uint32)
    ends = around(
        *(0.5, 1.0, 2.0, 0.70710678, 1.41421356, 0.34657359, 88.37, 89.41, 17.3, 20.0),
        *(2.0**17, 2.0**22, 2.0**23, 2.0**24, 1.17549435e-38, 0.41421356, 9.01, 10.0),
    )
    return np.concatenate([SPECIALS, strided, moderate, multiples, ends])


def pairs(op: Opcode, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Words of all kinds, words of like exponents, and exponents that make a power a number."""
    rng = np.random.default_rng(seed)
    anything = random_words(count, seed), random_words(count, seed + 1)
    near = rng.integers(0x3D000000, 0x43000000, (2, count)) | rng.integers(0, 2, (2, count)) << 31
    near = near.astype(np.uint32)
    like = anything[0], (anything[0] + rng.integers(-(1 << 25), 1 << 25, count)).astype(np.uint32)
    both = [anything, (near[0], near[1]), like, (near[0], anything[1]), (anything[0], near[1])]
    if op is Opcode.POW:
        x = np.abs(np.concatenate([anything[0], near[0]]).view(np.float32))
        with np.errstate(all="ignore"):
            y = rng.uniform(-152, 129, 2 * count) / np.log2(x.astype(np.float64))
        both.append((x.view(np.uint32), y.astype(np.float32).view(np.uint32)))
        whole = rng.integers(-9, 10, count).astype(np.float32).view(np.uint32)
        both.append((anything[0], whole))
    return np.concatenate([a for a, _ in both]), np.concatenate([d for _, d in both])


def test_the_page_has_every_elementary_function_of_floats() -> None:
    assert set(TABLE) == set(EXACT) | {
        *(Opcode.EXP, Opcode.EXP2, Opcode.FDIV, Opcode.SQRT, Opcode.FLOOR, Opcode.CEIL)
    }


@pytest.mark.parametrize("op", TABLE, ids=lambda op: op.value)
def test_operations(op: Opcode) -> None:
    after = expand_math(graph(op, 1))
    assert check(after) == []
    assert len(after.operations) == 1 + OPCODES[op].arity + TABLE[op][0]


@pytest.mark.parametrize("op", UNARY, ids=lambda op: op.value)
def test_the_error_bound_holds_on_a_sample(op: Opcode) -> None:
    assert_within_bound(op, unary_sample())


@pytest.mark.parametrize("op", BINARY, ids=lambda op: op.value)
def test_the_error_bound_holds_on_random_pairs(op: Opcode) -> None:
    assert_within_bound(op, *pairs(op, 20000, 5))


@pytest.mark.parametrize("op", BINARY, ids=lambda op: op.value)
def test_special_pairs(op: Opcode) -> None:
    halves = np.array([1.5, 2.0, 3.0, 5.0, 2.0**24 - 1, 2.0**24, 2.0**31], np.float32)
    words = np.concatenate([SPECIALS, halves.view(np.uint32), (-halves).view(np.uint32)])
    a, d = (grid.ravel() for grid in np.meshgrid(words, words))
    assert_within_bound(op, a, d)
    ours, exact = expanded(op, a, d), by_semantics(op, a, d)
    special = (exact & np.uint32(0x7FFFFFFF) == 0) | (exact & np.uint32(0x7F800000) == 0x7F800000)
    unrounded = np.abs(ours.view(np.int32) - exact.view(np.int32)) <= 4
    assert np.all((ours == exact) | ~special | unrounded)


@pytest.mark.parametrize("op", EXACT, ids=lambda op: op.value)
def test_the_numpy_evaluation_is_the_interpreters(op: Opcode) -> None:
    operands = [np.concatenate([SPECIALS, random_words(40, seed)]) for seed in (1, 2)]
    operands = operands[: OPCODES[op].arity]
    assert np.array_equal(interpreted(op, *operands), expanded(op, *operands))


@pytest.mark.parametrize("op", EXACT, ids=lambda op: op.value)
def test_the_table_of_semantics_rounds_the_exact_value(op: Opcode) -> None:
    operands = [np.concatenate([SPECIALS, random_words(400, seed)]) for seed in (7, 8)]
    operands = operands[: OPCODES[op].arity]
    assert errors(op, by_semantics(op, *operands), *operands).max() <= 0.5 + 2.0**-20


@pytest.mark.slow
@pytest.mark.parametrize("op", UNARY, ids=lambda op: op.value)
def test_the_error_bound_holds_over_a_dense_sweep(op: Opcode) -> None:
    for start in range(0, 1 << 32, 1021 * CHUNK):
        stop = min(start + 1021 * CHUNK, 1 << 32)
        words = np.arange(start, stop, 1021, dtype=np.uint64).astype(np.uint32)
        assert_within_bound(op, words)


@pytest.mark.slow
@pytest.mark.parametrize("op", BINARY, ids=lambda op: op.value)
def test_the_error_bound_holds_on_many_pairs(op: Opcode) -> None:
    for seed in range(10, 20, 2):
        assert_within_bound(op, *pairs(op, CHUNK, seed))
