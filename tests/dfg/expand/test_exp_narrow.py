"""exp and exp2 in float16 and float8, over every number of the format."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.dfg.expand.vectorised import graph
from vividc.dfg.expand.expand import expand_math, expansion_pass
from vividc.dfg.interpret.interpreter import interpret_region
from vividc.errors import ArgumentError
from vividc.formats import to_floats
from vividc.machine.opcodes import Opcode
from vividc.ssa.formats.precision import FORMAT_NAMES, parse_precision

# Largest errors: in units in the last place of normal results, in the least number below them.
BOUNDS = {"fp16": (0.75, 0.55), "fp8": (0.84, 4.4), "e5m2": (0.65, 2.3)}
OPERATIONS = {"fp16": 12, "fp8": 5, "e5m2": 5}
EXACT = {Opcode.EXP: np.exp, Opcode.EXP2: np.exp2}
SPECIALS = [np.nan, np.inf, -np.inf, 3e38, -3e38, 1e-40, -1e-40, 0.0, -0.0]


def _values(op: Opcode, name: str, x: np.ndarray) -> np.ndarray:
    """The expansion by the interpreter."""
    dfg = expansion_pass(parse_precision({"all": name}))(graph(op))
    memory = x.astype(np.float32).view(np.uint32).copy()
    interpret_region(dfg, "loop", len(memory), {"&x": 0}, memory)
    return memory.view(np.float32).astype(np.float64)


def _arguments(name: str) -> np.ndarray:
    """Every number of the format, some between them, and what is special."""
    fmt = FORMAT_NAMES[name]
    assert fmt is not None
    numbers = to_floats(fmt, np.arange(1 << fmt.bits, dtype=fmt.dtype))
    between = np.linspace(math.log(fmt.min_subnormal) - 2, math.log(fmt.max_finite) + 2, 2000)
    return np.concatenate([numbers, between, SPECIALS]).astype(np.float32)


@pytest.mark.parametrize("name", BOUNDS)
@pytest.mark.parametrize("op", EXACT)
def test_every_argument_is_within_the_bound(op: Opcode, name: str) -> None:
    fmt = FORMAT_NAMES[name]
    assert fmt is not None
    x = _arguments(name)
    got = _values(op, name, x)
    with np.errstate(over="ignore"):
        exact = EXACT[op](x.astype(np.float64))
    assert np.array_equal(np.isnan(got), np.isnan(x))
    beyond = exact > fmt.max_finite * (1 + 2.0 ** -(fmt.mantissa_bits + 1))
    assert np.array_equal(got[beyond], np.full(beyond.sum(), _overflow(name)))
    normal = (exact >= fmt.min_normal) & (exact <= fmt.max_finite) & np.isfinite(got)
    ulp = np.exp2(np.floor(np.log2(exact[normal])) - fmt.mantissa_bits)
    assert (np.abs(got[normal] - exact[normal]) / ulp).max() <= BOUNDS[name][0]
    small = exact < fmt.min_normal
    assert (np.abs(got[small] - exact[small]) / fmt.min_subnormal).max() <= BOUNDS[name][1]
    assert np.all(got[x == 0] == 1)


@pytest.mark.parametrize("name", BOUNDS)
def test_results_are_numbers_of_the_format_and_rise(name: str) -> None:
    fmt = FORMAT_NAMES[name]
    assert fmt is not None
    x = np.sort(_arguments(name)[:-9])
    got = _values(Opcode.EXP, name, x[~np.isnan(x)])
    numbers = to_floats(fmt, np.arange(1 << fmt.bits, dtype=fmt.dtype))
    assert np.isin(got, numbers).all()
    assert np.all(got[1:] >= got[:-1])


@pytest.mark.parametrize("name", OPERATIONS)
def test_fewer_bits_take_fewer_operations(name: str) -> None:
    rest = len(graph(Opcode.EXP).operations) - 1
    policy = parse_precision({"exp": name})
    assert len(expansion_pass(policy)(graph(Opcode.EXP)).operations) - rest == OPERATIONS[name]
    assert len(expand_math(graph(Opcode.EXP)).operations) - rest == 14


def test_all_is_each_function_that_is_not_named() -> None:
    rest = (("exp2", "fp16"), ("fma", "fp8"))
    assert parse_precision({"all": "fp8", "exp2": "fp16"}) == (("exp", "fp8"), *rest)
    assert parse_precision({"all": "fp8", "exp2": "fp16", "exp": "fp32"}) == rest
    assert parse_precision({"exp": "fp32"}) == parse_precision(None) == ()


@pytest.mark.parametrize(
    ("wanted", "names"),
    [({"erf": "fp8"}, "exp, exp2"), ({"exp": "fp4"}, "fp16, fp8, e5m2"), ("fp8", "exp")],
)
def test_an_unknown_function_or_format_is_told_what_there_is(wanted: object, names: str) -> None:
    with pytest.raises(ArgumentError) as caught:
        parse_precision(wanted)  # type: ignore[arg-type]
    assert names in str(caught.value.hint)


def _overflow(name: str) -> float:
    return 448.0 if name == "fp8" else math.inf
