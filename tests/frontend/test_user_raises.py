"""What a kernel raises is raised by whoever runs it, with what was stored before."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import vividc
from tests.frontend.raising_kernels import checked, helper, roots, through_a_helper
from tests.fuzz.witnesses import run_regions, words_in_blocks
from vividc.dfg.cut.build import build_kernel
from vividc.errors import SimulationError, SourceLoc
from vividc.program import from_bytes
from vividc.ssa.interpret import interpret
from vividc.ssa.rewrite.normalize import normalize
from vividc.ssa.text import parse, to_text


@pytest.mark.parametrize(
    ("function", "kind", "text", "home"),
    [
        (roots, ValueError, "a negative number, at x", roots),
        (checked, AssertionError, "too many", checked),
        (through_a_helper, OverflowError, "OverflowError", helper),
    ],
)
def test_all_witnesses_raise(
    function: Callable[..., object], kind: type[Exception], text: str, home: Callable[..., object]
) -> None:
    kernel = vividc.kernel("(float32[::1], int32)")(function)
    lowered = kernel.lower()
    assert parse(to_text(lowered)) == lowered
    program = words_in_blocks(lowered)
    assert from_bytes(program.to_bytes()) == program
    graphs = build_kernel(normalize(lowered))
    for n, bad in ((3, False), (5, True)):
        start = np.array([1, 4, 9, 16, -1, 2], np.float32)

        def simulated(x: np.ndarray, n: np.int32) -> object:
            return vividc.simulate(program, x, n).value

        def by_graphs(x: np.ndarray, n: np.int32) -> object:
            return run_regions(graphs, [x, n])

        def by_ssa(x: np.ndarray, n: np.int32) -> object:
            return interpret(lowered, x, n)

        theirs = start.copy()
        if not bad:
            expected = kernel(theirs, np.int32(n))
        else:
            with pytest.raises(kind):
                kernel(theirs, np.int32(n))
        for run in (simulated, by_graphs, by_ssa):
            mine = start.copy()
            if not bad:
                value = run(mine, np.int32(n))
                assert (value is None) is (expected is None)
                assert value is None or np.allclose(value, expected)
            else:
                with pytest.raises(kind, match=text) as caught:
                    run(mine, np.int32(n))
                assert isinstance(caught.value, SimulationError)
                assert isinstance(caught.value.loc, SourceLoc)
                assert caught.value.loc.line > home.__code__.co_firstlineno
            assert np.allclose(mine, theirs)


def test_a_raise_that_cannot_happen_costs_nothing() -> None:
    def first(x, n):
        if len(x) < 0:
            raise ValueError("never")
        return x[0]

    assert vividc.kernel("float32(float32[::1], int32)")(first).lower().results is None
