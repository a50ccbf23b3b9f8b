"""Estimated cycles of a recognised matrix product on one tile."""

from __future__ import annotations

import math
from dataclasses import replace

from vividc.compiler.planning.choose import choose
from vividc.compiler.planning.estimate import Estimator
from vividc.compiler.planning.options import LoopOptions
from vividc.machine.product import Product
from vividc.ssa.analysis.frequency import expected_trips
from vividc.ssa.flow import find_loops
from vividc.ssa.ir import Function

_ENDLESS = 1e15
"""Cycles of what cannot be mapped, by estimate: a number that a file can hold."""


def priced(
    product: Product, function: Function, estimator: Estimator, wanted: LoopOptions
) -> Product:
    """A product with the cycles that a tile takes for each of its terms: of the plan that is tried
    first, by its estimate with assumed sizes.
    """
    plan = choose(function, estimator, wanted)
    last = plan.stages[-1]
    trips = expected_trips(function, {})
    terms = math.prod(trips[loop.header] for loop in find_loops(function))
    cycles = min(last.estimate.cycles, _ENDLESS)
    return replace(product, cycles_a_term=cycles / terms)
