"""Products and sums become one operation before a function is transformed, as in its graphs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import vividc
from tests.fuzz.witnesses import run_regions
from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.pipeline import PassOptions, optimize_kernel
from vividc.machine.opcodes import Opcode
from vividc.ssa.ir import Function
from vividc.ssa.rewrite.contract import contract
from vividc.ssa.rewrite.normalize import normalize


@vividc.kernel("void(float32[::1], float32[::1], float32, float32)")
def sums(x, y, a, b):
    for i in range(len(x)):
        p = x[i] * a
        y[i] = x[i] * x[i] + a * b + p - x[i] * np.float32(3.0) - p * p


@vividc.kernel("void(float32[::1], float32[::1], float32, float32)")
def arms(x, y, a, b):
    for i in range(len(x)):
        p = x[i] * a
        q = p + b
        if x[i] > b:
            q = np.float32(2.0) - x[i] * b
        y[i] = q


def operations(function: Function, op: Opcode) -> int:
    return sum(instr.op is op for block in function.blocks for instr in block.instrs)


@pytest.mark.parametrize("kernel", [sums, arms])
def test_the_words_are_those_of_contraction_in_the_graphs(kernel: Any) -> None:
    function = kernel.lower()
    fused = contract(function)
    assert operations(fused, Opcode.FMA) >= 1
    rng = np.random.default_rng(4)
    x = rng.standard_normal(40).astype(np.float32)
    words = []
    for form, options in ((function, PassOptions()), (fused, PassOptions(contract=False))):
        args = [x.copy(), np.zeros_like(x), np.float32(1.1), np.float32(0.3)]
        run_regions(optimize_kernel(build_kernel(normalize(form)), options), args)
        words.append(args[1].tobytes())
    assert words[0] == words[1]


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, contract, same=False)
