"""Random kernels: the engine, running words, leaves the memory that the DFG interpreter leaves."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings

from tests.programs import WORDS, lower, programs
from tests.sim.one_pe import map_region, one_pe
from vividc import simulate
from vividc.arch import Fabric
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.interpret.interpreter import interpret
from vividc.program import Program, encode

FABRICS = {
    "unit": one_pe("{}", 1),
    "deep": one_pe("{load: 3, int: 2, compare: 2, select: 2}", 3),
}


def compiled(source: tuple[object, ...], fabric: Fabric) -> tuple[Program, list[int]]:
    """The program on `fabric`, and the array the interpreter leaves."""
    kernel = build_kernel(lower(source))
    expected = np.arange(WORDS, dtype=np.uint32)
    interpret(kernel, expected, {"&a": 0, "a.shape0": WORDS}, iteration_limit=100_000)
    mappings = {i: map_region(region, fabric) for i, region in enumerate(kernel.regions)}
    return encode(kernel, fabric, mappings), expected.tolist()


def check(source: tuple[object, ...], fabric: Fabric) -> None:
    """Engine and interpreter agree on the memory, and the regions' cycles add up."""
    program, expected = compiled(source, fabric)
    array = np.arange(WORDS, dtype=np.int32)
    result = simulate(program, array, cycle_limit=1_000_000)
    assert array.view(np.uint32).tolist() == expected
    regions = result.stats["regions"]
    assert result.cycles == result.stats["switch_cycles"] + sum(r["cycles"] for r in regions)


@pytest.mark.parametrize("name", sorted(FABRICS))
@settings(max_examples=12)
@given(programs())
def test_memory_after_random_programs(name: str, source: tuple[object, ...]) -> None:
    check(source, FABRICS[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(FABRICS))
@settings(max_examples=600)
@given(programs())
def test_memory_after_many_random_programs(name: str, source: tuple[object, ...]) -> None:
    check(source, FABRICS[name])
