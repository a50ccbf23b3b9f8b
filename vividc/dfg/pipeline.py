"""The default pass pipeline over every region's DFG."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import wraps

from vividc.dfg.check import check
from vividc.dfg.expand.expand import expansion_pass
from vividc.dfg.ir import DFG
from vividc.dfg.passes import (
    contract_fma,
    eliminate_common_subexpressions,
    fold_constants,
    fold_selects,
    recognize_min_max,
    remove_dead_nodes,
)
from vividc.dfg.passes.balance import pass_for, rebalance_sums_of_loops
from vividc.dfg.regions import Kernel
from vividc.errors import InternalError
from vividc.host import time_limit
from vividc.host.watch import name_of, run_passes
from vividc.ssa.formats.precision import Precision

Pass = Callable[[DFG], DFG]


@dataclass(frozen=True, slots=True)
class PassOptions:
    """Switches of the pipeline. `contract`: fuse multiply and add (changes rounding, as hardware
    FMAs do). `reassociate`: balance float reductions too (changes rounding). `precision`: formats
    of functions.
    """

    contract: bool = True
    reassociate: bool = False
    precision: Precision = ()


def pipeline(options: PassOptions) -> tuple[Pass, ...]:
    """The passes in order."""
    passes: list[Pass] = [
        fold_constants,
        # Before selects are folded: a select of a comparison of its own arms is a minimum.
        recognize_min_max,
        expansion_pass(options.precision),
        eliminate_common_subexpressions,
        # Before contraction, which ties a sum's operands to their products.
        pass_for(reassociate=options.reassociate),
    ]
    if options.contract:
        passes.append(contract_fma)
    # After contraction: a select whose arm is an accumulating FMA becomes a predicated FMA.
    passes.append(fold_selects)
    if options.reassociate:
        passes.append(rebalance_sums_of_loops)
    passes += [fold_constants, eliminate_common_subexpressions, remove_dead_nodes]
    return tuple(passes)


def optimize(dfg: DFG, options: PassOptions | None = None) -> DFG:
    """Runs the pipeline and checks the graph after each pass.

    Raises
    ------
    InternalError
        If a pass breaks an invariant of the IR.
    """
    first, *others = pipeline(options or PassOptions())
    return run_passes((_checked(first, always=True), *map(_checked, others)), dfg)


def _checked(step: Pass, *, always: bool = False) -> Pass:
    """A pass, with the check of the graph that it makes; `always`: of one that it leaves, too."""

    @wraps(step)
    def checked(dfg: DFG) -> DFG:
        time_limit.step("regions were optimised")
        made = step(dfg)
        broken = check(made) if always or made is not dfg else ()
        if broken:
            raise InternalError(f"{name_of(step)} broke region {dfg.name}: {'; '.join(broken)}")
        return made

    return checked


def optimize_kernel(kernel: Kernel, options: PassOptions | None = None) -> Kernel:
    """Runs the pipeline over every region."""
    regions = (replace(region, dfg=optimize(region.dfg, options)) for region in kernel.regions)
    return replace(kernel, regions=tuple(regions))
