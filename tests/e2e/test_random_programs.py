"""Random structured programs through mapper, words and engine: memory as in Python, on odd little
fabrics.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import Phase, given, settings

import vividc
from tests.programs import WORDS, lower, programs, run
from vividc import arch
from vividc.compiler.regions.map_regions import map_kernel
from vividc.compiler.stage import CompileOptions
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.pipeline import optimize_kernel
from vividc.program import encode

# Shrinking a program compiles it hundreds of times; the failing program itself says enough.
PHASES = (Phase.explicit, Phase.reuse, Phase.generate)


def check_program(program: tuple[object, ...], fabric: str) -> None:
    """Compiles and simulates `program`, and compares the array with its direct meaning."""
    machine = arch.load(fabric)
    kernel = optimize_kernel(build_kernel(lower(program)))
    mapped, results = map_kernel(kernel, machine, CompileOptions(time_limit_s=60.0))
    mappings = {i: r.mapping for i, r in results.items() if r.mapping is not None}
    words = encode(mapped, machine, mappings, reports=results)
    memory = np.arange(WORDS, dtype=np.int32)
    vividc.simulate(words, memory, cycle_limit=200_000)
    expected = list(range(WORDS))
    run(program, expected)
    assert [int(word) for word in memory.view(np.uint32)] == expected


@settings(max_examples=25, phases=PHASES)
@given(programs())
@pytest.mark.parametrize("fabric", ["vivid-tile", "mesh-2x2"])
def test_words_mean_what_the_program_means(fabric: str, program: tuple[object, ...]) -> None:
    check_program(program, fabric)


@pytest.mark.slow
@settings(max_examples=500, phases=PHASES)
@given(programs())
@pytest.mark.parametrize("fabric", ["vivid-tile", "vivid-tile-unit", "mesh-2x3", "torus-3x3"])
def test_words_mean_what_many_programs_mean(fabric: str, program: tuple[object, ...]) -> None:
    check_program(program, fabric)
