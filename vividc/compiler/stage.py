"""A stage of a plan: its regions mapped, and the words of them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import partial

from vividc.arch.fabric import Fabric
from vividc.compiler.planning.estimate import Estimator, Shape
from vividc.compiler.planning.fallback import Outcome, Race
from vividc.compiler.planning.options import LoopOptions
from vividc.compiler.planning.plan import Stage
from vividc.compiler.planning.spacing import spaced
from vividc.compiler.regions.earlier import Earlier
from vividc.compiler.regions.map_again import Runs
from vividc.compiler.regions.map_regions import MapOptions, Unmapped, map_kernel
from vividc.compiler.regions.map_straight import lengths_of
from vividc.compiler.regions.turns import turns_of
from vividc.dfg.regions import Kernel
from vividc.errors import TimeLimit
from vividc.host import watch
from vividc.host.watch import is_watched, watched
from vividc.mapper.result import MapResult, mapping_of
from vividc.program import Program, encode
from vividc.program.encoder.encode import check_contexts
from vividc.program.encoder.places import Layout
from vividc.program.reloads import most_contexts
from vividc.ssa.formats.precision import Precision
from vividc.ssa.ir import Function


@dataclass(frozen=True, slots=True)
class CompileOptions(MapOptions):
    """How a kernel is compiled: how its regions are mapped, and

    Attributes
    ----------
    strict_fp
        Refuse float64 arithmetic instead of running it in float32 with a warning.
    contract
        Fuse multiplications and additions into FMAs.
    loops
        How loops are transformed.
    reassociate
        Balance reductions of floats too, which changes their rounding; integers' always are. A
        kernel made of a function that numba has compiled with `fastmath` has this leave.
    precision
        Formats of functions, from `parse_precision`.
    resident
        The configuration memory holds all of the program: tiles of an accelerator bring no contexts
        while they run.
    """

    strict_fp: bool = False
    contract: bool = True
    loops: LoopOptions = field(default_factory=LoopOptions)
    reassociate: bool = False
    precision: Precision = ()
    resident: bool = False


def map_stage(
    stage: Stage,
    estimator: Estimator,
    options: CompileOptions,
    earlier: Earlier,
    last_resort: bool,
    below: float,
) -> Outcome | None:
    """Maps a stage; a loop that cannot be modulo-scheduled (in time) runs block by block, unless
    it is a transformed one. None: it is sure to take so many cycles; whoever looks on sees it all.
    """
    sequential: dict[str, str] = {}
    held = estimator.fabric.controller.contexts
    most = held if options.resident else most_contexts(estimator.fabric)
    most_held = most if last_resort else held
    demanded = frozenset[str]() if last_resort else frozenset(stage.state.made)
    while True:
        function = stage.state.function
        if sequential:
            function = replace(function, sequential=frozenset(sequential))
        function = _prepared(function, stage, estimator)
        function = spaced(function, estimator, stage.state.hints)
        kernel = _kernel_of(function, stage, estimator, most_held)
        costs = estimator.expected(function, kernel, stage.state.hints)
        turns = None if options.resident else turns_of(function, costs, stage.state.hints)
        runs = Runs.of(costs, turns)
        race = Race(estimator, function, stage.state.hints, math.inf if is_watched() else below)
        mapping = partial(
            map_kernel,
            kernel,
            estimator.fabric,
            options,
            earlier,
            demanded=demanded,
            runs=runs,
            is_lost=partial(race.is_lost, kernel),
        )
        made = watched("map", mapping)
        if made is None:
            return None
        if not isinstance(made, Unmapped):
            break
        if not demanded.isdisjoint(made.headers):
            raise made.error
        timed_out = isinstance(made.error, TimeLimit)
        why = "took too long" if timed_out else "has no modulo schedule"
        sequential |= dict.fromkeys(made.headers, why)
    mapped, results = made
    used = sum(mapping_of(result).ii for result in results.values())
    check_contexts(mapped, estimator.fabric, used, most)
    layout = None if turns is None else turns.layout(lengths_of(made), estimator.fabric)
    program = _encoded(mapped, results, runs, estimator.fabric, options, layout)
    brought = None if layout is None else layout.cycles
    hints, shapes = stage.state.hints, _shapes(program)
    achieved = estimator.priced(function, mapped, shapes, hints, brought=brought)
    return Outcome(stage, mapped, results, program, achieved, sequential)


def _encoded(
    kernel: Kernel,
    results: dict[int, MapResult],
    runs: Runs,
    fabric: Fabric,
    options: CompileOptions,
    layout: Layout | None,
) -> Program:
    encoding = partial(
        encode,
        kernel,
        fabric,
        {index: mapping_of(result) for index, result in results.items()},
        reports=results,
        options=_provenance(options),
        iterations=runs.iterations,
        order=() if layout is None else layout.order,
    )
    return watched("encode", encoding)


def _shapes(program: Program) -> list[Shape]:
    """The shapes that regions have come out with."""
    return [
        Shape(
            report.ii,
            report.span,
            report.operations,
            stalls=report.stalls,
            drain=row.drain,
            fill=row.fill,
        )
        for report, row in zip(program.regions, program.table, strict=True)
    ]


def _prepared(function: Function, stage: Stage, estimator: Estimator) -> Function:
    """The stage's function, normalised; estimates on the way are not watched."""

    def prepare() -> Function:
        with watch.aside():
            return estimator.prepared(function, stage.state.hints)

    watched("choose", lambda: function)
    return watched("prepare", prepare)


def _kernel_of(function: Function, stage: Stage, estimator: Estimator, most: int) -> Kernel:
    """The function's regions with optimised graphs; too many contexts are refused first."""
    built = watched("build-kernel", lambda: estimator.built(function))
    used = estimator.contexts(function, built, stage.state.hints)
    check_contexts(built, estimator.fabric, used, most, "at least ")
    return watched("optimize", lambda: estimator.optimized_kernel(built))


def _provenance(options: CompileOptions) -> dict[str, str | int | float | bool | None]:
    return {
        "mapper": options.mapper,
        "effort": options.effort,
        "strict_fp": options.strict_fp,
        "contract": options.contract,
        "reassociate": options.reassociate,
        "transform": "auto" if options.loops.auto else "none",
        "threads": options.loops.threads,
        **{f"precision {name}": fmt for name, fmt in options.precision},
    }
