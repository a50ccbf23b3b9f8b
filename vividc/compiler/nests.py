"""The nests of a kernel as programs of their own, for what is larger than a scratchpad."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final

from vividc.errors import KernelError, TimeLimit, warn
from vividc.host import time_limit
from vividc.machine.parallel import Parallel
from vividc.machine.params import DType
from vividc.program import CUT_SHORT, Program
from vividc.ssa.flow import find_loops
from vividc.ssa.ir import Function
from vividc.ssa.parallel.cut import cut_nest
from vividc.ssa.parallel.nests import nests_of

Compile = Callable[[Function, Mapping[str, float], float], Program]
"""Of a function with so many iterations of loops, by header, in so many seconds."""

_IN_BLOCK: Final = {2: 4.0, 3: 1.0}
"""Iterations of a nest's outermost loop that a block has, by the nest's depth, as arrays hardly fit
a scratchpad: rows of some hundred words (2.7 to 3.6 of them: jacobi-2d, blur), or one plane.
"""


def with_nests(
    program: Program,
    function: Function,
    spread: Parallel | None,
    compile_one: Compile,
) -> Program:
    """The program with its nests, if the kernel is a sequence of nests that can be cut.

    Parameters
    ----------
    spread
        The loop over `prange` that a launch spreads anyway: nests are of use only if they also cut
        the loops inside.
    """
    if any(param.dtype is DType.C64 for param in function.params):
        return program  # boxes of elements are moved word by word
    try:
        found = nests_of(function)
        cut = [cut_nest(nest.function, nest.header, found.order.keys) for nest in found.nests]
    except KernelError:
        return program
    if spread is not None and not all(parallel.blocked for _, parallel in cut):
        return program
    made: list[Program] = []
    for number, (nest, parallel) in enumerate(cut):
        share_s = time_limit.remaining_s() / (len(cut) - number)
        try:
            one = compile_one(nest, _trips(nest), share_s)
        except TimeLimit:
            text = f"{parallel.loc}: the nests of {program.name} {CUT_SHORT}"
            warn(text)
            return replace(program, warnings=(*program.warnings, text))
        made.append(replace(one, parallel=parallel, loops=()))
    return replace(program, nests=tuple(made), order=found.order)


def _trips(nest: Function) -> dict[str, float]:
    """What is expected of the outermost loop of a cut nest; nothing if it is the only one."""
    loops = find_loops(nest)
    outermost = max(loops, key=lambda loop: len(loop.blocks))
    depth = max(sum(one.header in other.blocks for other in loops) for one in loops)
    deepest = max(_IN_BLOCK)
    return {outermost.header: _IN_BLOCK[min(depth, deepest)]} if depth > 1 else {}
