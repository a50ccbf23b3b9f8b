"""Bounds of floats, and the shorter expansions of angles that have one."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.dfg.expand.vectorised import SPECIALS, evaluate_many
from vividc.dfg.check import check
from vividc.dfg.expand.expand import expand_math
from vividc.dfg.expand.magnitudes import magnitudes
from vividc.dfg.forms.text import parse
from vividc.dfg.interpret.interpreter import interpret_region
from vividc.dfg.ir import DFG
from vividc.machine.opcodes import Opcode
from vividc.machine.words import word_of

GRAPH = """dfg "clamped"
%0 = iv
%1 = live_in "&x"
%2 = load "x" %0 shift 2 base %1
%3 = const {high:#010x}
%4 = const {low:#010x}
%5 = fmin %2, %3
%6 = fmax %5, %4
%7 = {op} %6
%8 = store "x" %0, %7 shift 2 base %1 after %2
"""
CLAMP = 2


def clamped(op: Opcode, limit: float) -> DFG:
    return parse(GRAPH.format(op=op.value, high=word_of(limit), low=word_of(-limit)))


@pytest.mark.parametrize(
    ("op", "count"), [(Opcode.SIN, 22), (Opcode.COS, 22), (Opcode.TAN, 31)], ids=str
)
def test_a_bounded_angle_needs_no_large_reduction(op: Opcode, count: int) -> None:
    after = expand_math(clamped(op, 131071.0))
    assert check(after) == []
    assert len(after.operations) == CLAMP + 2 + count
    unbounded = expand_math(clamped(op, 131072.0))
    assert len(unbounded.operations) == CLAMP + 2 + count + 48


@pytest.mark.parametrize("op", [Opcode.SIN, Opcode.COS, Opcode.TAN], ids=lambda op: op.value)
def test_the_shorter_expansion_gives_the_same_bits(op: Opcode) -> None:
    rng = np.random.default_rng(2)
    inside = rng.uniform(-131071, 131071, 3000).astype(np.float32).view(np.uint32)
    small = rng.normal(0, 3, 3000).astype(np.float32).view(np.uint32)
    words = np.concatenate([inside, small, SPECIALS])
    short = expand_math(clamped(op, 131071.0))
    general = expand_math(clamped(op, 131072.0))
    results = []
    for dfg in (short, general):
        [result] = [edge.src for edge in dfg.edges if edge.dst == 8 and edge.port == 1]
        results.append(evaluate_many(dfg, result, {2: words}))
    finite = np.abs(words.view(np.float32)) <= 131071
    assert np.array_equal(results[0][finite], results[1][finite])


def test_a_function_expanded_before_still_bounds_the_angle() -> None:
    head = "\n".join(GRAPH.splitlines()[:4])
    after = expand_math(
        parse(f'{head}\n%3 = atan %2\n%4 = sin %3\n%5 = store "x" %0, %4 shift 2 base %1\n')
    )
    assert len(after.operations) == 2 + 28 + 22


@pytest.mark.parametrize(
    ("line", "bound"),
    [
        ("%5 = fmin %2, %3", math.inf),
        ("%5 = fabs %3", 3.0),
        ("%5 = frem %2, %3", 3.0),
        ("%5 = sin %2", 1.0),
        ("%5 = atan2 %2, %3", 4.0),
        ("%5 = fmul %3, %3", 9.0 * (1 + 2.0**-20)),
        ("%5 = fadd %3, %2", math.inf),
        ("%5 = mov %2", math.inf),
    ],
)
def test_bounds(line: str, bound: float) -> None:
    head = "\n".join(GRAPH.splitlines()[:4])
    dfg = parse(f'{head}\n%3 = const 0x40400000\n{line}\n%6 = store "x" %0, %5 shift 2 base %1\n')
    assert magnitudes(dfg)[5] == bound


def test_a_bound_covers_the_minimum_with_a_nan() -> None:
    head = "\n".join(GRAPH.splitlines()[:4])
    dfg = parse(
        f"{head}\n%3 = const 0x40400000\n%4 = const 0xc0a00000\n"
        "%5 = fmax %2, %4\n%6 = fmin %5, %3\n"
        '%7 = store "x" %0, %6 shift 2 base %1 after %2\n'
    )
    assert magnitudes(dfg)[6] == 5.0
    memory = np.array([0x7FC00000, word_of(1e9), word_of(-1e9)], np.uint32)
    interpret_region(dfg, "loop", 3, {"&x": 0}, memory)
    assert np.all(np.abs(memory.view(np.float32)) <= 5.0)
