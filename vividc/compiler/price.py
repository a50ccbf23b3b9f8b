"""What a term of a program's matrix products costs a tile: measured on a launch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from vividc.arch import Accelerator
from vividc.errors import ArgumentError
from vividc.gemm.kernels.choice import assumed_arrays, assumed_words
from vividc.gemm.kernels.sequence import Launch, Unfit
from vividc.launch import Job, nests_job, spread
from vividc.machine.parallel import Order
from vividc.machine.product import AUTO, ENDLESS, Products
from vividc.program import Program

_SIZES: Final = (32, 32, 32)
"""Rows, columns and inner indices of the launch where they are not known: pitches of so many words
meet in banks, as those of most matrices do.
"""
_MOST_TERMS: Final = 1 << 22
"""More take seconds to measure."""


def priced(program: Program, machine: Accelerator, *, is_nest: bool = False) -> Program:
    """A program, perhaps a nest of another, that knows what its products cost in GPU-like mode, if
    a launch may choose: with the stalls in banks and the starts of loops, which an estimate does
    not see.
    """
    products = program.products
    if products is None or products.mode != AUTO:
        return program
    cost = _measured(program, products, machine, is_nest)
    return replace(program, products=replace(products, cycles_a_term=cost))


def _measured(program: Program, products: Products, machine: Accelerator, is_nest: bool) -> float:
    words = assumed_words(program, _SIZES)
    arrays = assumed_arrays(program, words)
    launch = Launch(products, arrays, words)
    try:
        launch.check()
        terms = sum(launch.sizes(product).terms for product in products.products)
        if terms > _MOST_TERMS:
            return ENDLESS
        given = {
            p.name: 1.0 if p.dtype.is_float else words[p.name] for p in program.params if not p.ndim
        }
        launched = {**arrays, **given}
        make = _nest_job if is_nest else spread
        job = make(program, (), launched, machine)
        return job.simulate().stats["tile_cycles"] / terms
    except (ArgumentError, Unfit):
        return ENDLESS  # it fits no tile


def _nest_job(
    nest: Program, args: tuple[object, ...], kwargs: Mapping[str, object], machine: Accelerator
) -> Job:
    """The launch of a nest alone, with 0 for the counters around it."""
    assert nest.parallel is not None
    alone = replace(nest, parallel=None, products=None, nests=(nest,), order=Order((), (0,)))
    return nests_job(alone, args, kwargs, machine, [(0, dict.fromkeys(nest.parallel.around, 0))])
