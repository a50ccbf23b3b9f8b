"""Random programs mean the same as regions as they do in Python, before and after the passes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given, settings

from tests.programs import (
    WORDS,
    Assign,
    If,
    Jump,
    Load,
    Store,
    While,
    lower,
    programs,
    run,
)
from vividc.dfg.check import check
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.interpret.interpreter import interpret
from vividc.dfg.regions import Kernel
from vividc.ssa.flow import find_loops


def memory_after(kernel: Kernel, words: int = WORDS) -> list[int]:
    """The array after interpreting `kernel` from 0, 1, 2, ..."""
    memory = np.arange(words, dtype=np.uint32)
    interpret(kernel, memory, {"&a": 0, "a.shape0": words}, iteration_limit=100_000)
    return [int(word) for word in memory]


def meaning(program: tuple[object, ...], words: int = WORDS) -> list[int]:
    """The array after running `program` directly."""
    memory = list(range(words))
    run(program, memory)
    return memory


@settings(max_examples=200)
@given(programs())
def test_regions_mean_what_the_program_means(program: tuple[object, ...]) -> None:
    kernel = build_kernel(lower(program))
    for region in kernel.regions:
        assert check(region.dfg) == []
    assert memory_after(kernel) == meaning(program)


@settings(max_examples=100)
@given(programs())
def test_loops_that_run_block_by_block_mean_the_same(program: tuple[object, ...]) -> None:
    function = lower(program)
    headers = frozenset(loop.header for loop in find_loops(function))
    kernel = build_kernel(replace(function, sequential=headers))
    assert {region.kind for region in kernel.regions} == {"straight"}
    assert memory_after(kernel) == meaning(program)


def test_a_store_and_a_later_break_on_another_path_do_not_wait_for_each_other() -> None:
    """The store waits for the exit; the load that decides it must not wait for the store."""
    body = (
        Jump("break", 0, 1),
        If(1, 2, (Store(0, 1),), (Load(2, 0), Jump("break", 2, 1))),
    )
    program = (While(1, 0, 4, (Assign(0, "sub", 0, 1, 1), *body)),)
    kernel = build_kernel(lower(program))
    for region in kernel.regions:
        assert check(region.dfg) == []
    assert memory_after(kernel) == meaning(program)
