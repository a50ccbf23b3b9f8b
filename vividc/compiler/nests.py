"""The nests of a kernel as programs of their own, for what is larger than a scratchpad."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from vividc.errors import KernelError, TimeLimit, warn
from vividc.host import time_limit
from vividc.machine.parallel import Parallel
from vividc.machine.params import DType
from vividc.program import CUT_SHORT, Program
from vividc.ssa.ir import Function
from vividc.ssa.parallel.cut import cut_nest
from vividc.ssa.parallel.nests import nests_of

Compile = Callable[[Function, float], Program]
"""Of a function in so many seconds."""


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
            one = compile_one(nest, share_s)
        except TimeLimit:
            text = f"{parallel.loc}: the nests of {program.name} {CUT_SHORT}"
            warn(text)
            return replace(program, warnings=(*program.warnings, text))
        made.append(replace(one, parallel=parallel, loops=()))
    return replace(program, nests=tuple(made), order=found.order)
