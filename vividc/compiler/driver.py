"""Compiles a kernel: frontend, regions, passes, mapping of every region, configuration words."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial, wraps
from typing import Unpack

from vividc import arch
from vividc.arch import Accelerator
from vividc.arch.fabric import Fabric
from vividc.compiler.kept_programs import Place, place_of
from vividc.compiler.planning.choose import choose
from vividc.compiler.planning.estimate import Estimator, Spaces
from vividc.compiler.planning.explain import loop_reports
from vividc.compiler.planning.fallback import HASTY, TRANSFORMED_GUARD, Budget, Outcome, settle
from vividc.compiler.planning.options import FlatLoopOptions, LoopOptions, loop_options
from vividc.compiler.planning.plan import Plan, Stage
from vividc.compiler.regions.earlier import Earlier
from vividc.compiler.regions.map_regions import (
    guarded,
)
from vividc.compiler.regions.one_straight import Progress
from vividc.compiler.stage import CompileOptions, map_stage
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.pipeline import PassOptions, optimize_kernel
from vividc.dfg.regions import Kernel
from vividc.errors import (
    KernelError,
    SourceLoc,
    VividcWarning,
    demand_callable,
    demand_type,
    warn,
)
from vividc.frontend import KernelFunction, LLKernel
from vividc.frontend.like import Like
from vividc.host import compiled_files, time_limit, watch
from vividc.host.watch import run_passes, seldom, timed, watched
from vividc.machine.parallel import Parallel
from vividc.machine.product import AUTO, GPU, Products
from vividc.mapper import EffortLevel, check_effort, check_time_limit
from vividc.mapper.deadline import limited
from vividc.mapper.registry import named
from vividc.mapper.request import Mapper
from vividc.program import CUT_SHORT, Program
from vividc.program.encoder.encode import with_designs
from vividc.program.encoder.programmable import demand_programmable
from vividc.ssa.analysis.frequency import NO_TRIPS
from vividc.ssa.formats.in_format import in_format
from vividc.ssa.formats.precision import (
    FormatChoices,
    arithmetic_format,
    idle_names,
    parse_precision,
)
from vividc.ssa.ir import Function
from vividc.ssa.parallel.cut import cut_parallel_loop
from vividc.ssa.rewrite.contract import contract as contract_products

_GRACE_S, _GRACE_SHARE = 0.5, 0.05
"""Work that misses its limit by no more than this is finished: seconds, and a share of it."""


def compile(  # noqa: PLR0913 - the public contract, plus keywords
    kernel: KernelFunction | LLKernel,
    fabric: str | Fabric | Accelerator = "vivid-tile",
    mapper: str | Mapper = "auto",
    time_limit_s: float = 60.0,
    *,
    effort: EffortLevel = "normal",
    loops: LoopOptions | None = None,
    strict_fp: bool = False,
    contract: bool = True,
    reassociate: bool = False,
    precision: FormatChoices | None = None,
    progress: Progress | None = None,
    mode: str = AUTO,
    like: Like | None = None,
    cache: bool = True,
    **flat: Unpack[FlatLoopOptions],
) -> Program:
    """Compiles `kernel` for a tile, or for the tiles of an accelerator.

    Parameters
    ----------
    kernel
        A Python function decorated with `kernel`, or a C function from `load_ll`.
    fabric
        A fabric or an accelerator, a preset's name, or a YAML file. For an accelerator the loop
        over `numba.prange` becomes one that a launch can spread over the tiles.
    mapper, strict_fp, contract, reassociate, progress
        See `CompileOptions`.
    time_limit_s
        Seconds of wall time for all of it, kept within a tenth and a second; what they cut short is
        a warning.
    effort
        Where the search for each loop's mapping stops before that: "fast" at the first good one
        (the others go on, at its II, for fewer bank stalls), "normal" where more work rarely pays,
        which takes seconds, "thorough" where it is not expected to pay at all, "prove" once every
        smaller II is refuted (`docs/loops.md`).
    loops
        How loops are transformed, as in LoopOptions(unroll={12: 4}). None: where an estimate says
        that it pays.
    precision
        Formats of functions, as in {"exp": "fp8"}: their results are numbers of that format, by
        fewer operations (`docs/precision.md`).
    mode
        How an accelerator runs a kernel that is a matrix product (docs/gemm.md): "gpu", on its
        tiles, "tpu-unified", "tpu-partitioned", or "auto", what is predicted to take fewest cycles
        with the sizes of a launch.
    like
        What launches will be given, for each parameter in order or by name, as in like=(A, B, n) or
        like={"A": (20, 30), "n": 16}: shapes of arrays and values of integers become constants,
        and a launch with others is refused (docs/known-sizes.md). None: as the kernel says, mostly
        any.
    cache
        Take the program from the user's cache if the same was compiled before, and keep it there
        (docs/caching.md).
    **flat
        Deprecated: `transform`, and the fields of `LoopOptions` as keywords.

    Raises
    ------
    ArgumentError, KernelError, ArchError, MappingFailed, TimeLimit
    """
    loaded = checked(kernel, fabric, time_limit_s)
    if like is not None:
        kernel = kernel.sized(like)
    mapper = named(mapper)
    demand_type(cache, bool, "cache", "give True or False")
    demand_callable(progress, "progress")
    check_effort(effort)
    _check_mode(mode)
    wanted = loop_options(loops, flat)
    options = CompileOptions(
        mapper=mapper,
        time_limit_s=time_limit_s,
        effort=effort,
        progress=watch.to_tell(progress),
        strict_fp=strict_fp,
        contract=contract,
        loops=wanted,
        reassociate=reassociate or (isinstance(kernel, KernelFunction) and kernel.fastmath),
        precision=parse_precision(precision),
        resident=isinstance(loaded, Accelerator),
    )
    grace_s = _GRACE_S + _GRACE_SHARE * time_limit_s
    name, loc = kernel.name, kernel.loc
    with seldom(), time_limit.limited(time_limit_s, name, loc, grace_s=grace_s) as limit:
        program = _compiled(kernel, loaded, options, mode, cache)
    texts = [f"{kernel.loc}: {what} took too long and {CUT_SHORT}" for what in limit.cut]
    for text in texts:
        warn(text)
    compiled_files.note(program.provenance.kernel_file, program.provenance.kernel_sha256)
    return replace(program, warnings=(*program.warnings, *texts))


def _compiled(
    kernel: KernelFunction | LLKernel,
    loaded: Fabric | Accelerator,
    options: CompileOptions,
    mode: str,
    cache: bool,
) -> Program:
    """The program, with the warnings that were given."""
    wanted, strict_fp = options.loops, options.strict_fp
    function, parallel, told = lowered(kernel, strict_fp, isinstance(loaded, Accelerator))
    for name in idle_names(dict(options.precision), function):
        text = f"{kernel.name} has no {name}: its precision changes nothing"
        warn(text)
        told = (*told, text)
    lines = parallel_lines(kernel, wanted)
    if isinstance(loaded, Accelerator) and parallel is None and wanted.threads is None:
        lines = frozenset()  # iterations that are not proved independent keep their order
    how = (replace(options, progress=None), lines, parallel, mode)
    place = place_of(function, loaded, options.mapper, *how) if cache else Place(function)
    program = place.read()
    machine = loaded.fabric if isinstance(loaded, Accelerator) else loaded

    def one(nest: Function, trips: Mapping[str, float], limit_s: float) -> Program:
        with watch.aside():
            shared = replace(options, time_limit_s=limit_s)
            return compile_stages(nest, machine, shared, frozenset(), "all", trips)

    if program is None:
        products = _demanded(kernel, loaded, options, mode)
        spaces: Spaces = "none" if isinstance(loaded, Accelerator) else "paying"  # moved end to end
        program = compile_stages(function, machine, options, lines, spaces)
        everything = (*told, *program.warnings)
        program = replace(program, warnings=everything, parallel=parallel, products=products)
        if isinstance(loaded, Accelerator):
            program = _of_accelerator(program, kernel, loaded, options, mode, one)
        place.write(program)
    warned = tuple(
        dict.fromkeys((*told, *program.warnings))
    )  # a kernel is lowered, and tells, once
    for text in warned[len(told) :]:
        warn(text)
    return replace(program, warnings=warned)


def _check_mode(mode: str) -> None:
    if not isinstance(mode, str) or mode != AUTO:
        from vividc.gemm.kernels.choice import check_kernel_mode  # noqa: PLC0415 - loads launches

        check_kernel_mode(mode)


def _demanded(
    kernel: KernelFunction | LLKernel,
    loaded: Fabric | Accelerator,
    options: CompileOptions,
    mode: str,
) -> Products | None:
    """The matrix products that the kernel is made of, for an accelerator."""
    if mode == AUTO and not isinstance(loaded, Accelerator):
        return None
    from vividc.compiler.products import demanded_products, forbidden  # noqa: PLC0415

    reason = forbidden(options.contract, options.precision)
    return demanded_products(kernel, loaded, mode, reason, options.strict_fp)


def _of_accelerator(
    program: Program,
    kernel: KernelFunction | LLKernel,
    machine: Accelerator,
    options: CompileOptions,
    mode: str,
    one: Callable[[Function, Mapping[str, float], float], Program],
) -> Program:
    """The program with what launches on an accelerator may choose; `one` compiles a nest."""
    from vividc.compiler.nests import with_nests  # noqa: PLC0415 - these load launches
    from vividc.compiler.price import priced  # noqa: PLC0415
    from vividc.compiler.products import forbidden, with_products  # noqa: PLC0415

    products = program.products
    program = replace(priced(program, machine), accelerator=machine.source)
    if mode in (AUTO, GPU):
        again = watch.untold(lambda: kernel.lower(strict_fp=options.strict_fp))
        program = with_nests(program, again, program.parallel, one)
        if mode == AUTO and products is None and not forbidden(options.contract, options.precision):
            program = with_products(program, again, machine)
    return program


def checked(
    kernel: object, fabric: str | Fabric | Accelerator, time_limit_s: float
) -> Fabric | Accelerator:
    """The machine to compile for, once all arguments are checked."""
    hint = "decorate the function with @vividc.kernel, or load a C function with vividc.load_ll"
    demand_type(kernel, (KernelFunction, LLKernel), "the kernel", hint)
    hint = "give a preset, a YAML file or a Fabric"
    demand_type(fabric, (str, Fabric, Accelerator), "the fabric", hint)
    machine = arch.load(fabric) if isinstance(fabric, str) else fabric
    demand_programmable(machine.fabric if isinstance(machine, Accelerator) else machine)
    check_time_limit(time_limit_s)
    return machine


def parallel_lines(kernel: KernelFunction | LLKernel, wanted: LoopOptions) -> frozenset[int]:
    """Lines with loops over `prange`; threads demand one."""
    lines = kernel.prange_lines if isinstance(kernel, KernelFunction) else frozenset[int]()
    if not lines and (wanted.threads or 1) > 1:
        raise KernelError(
            f"{kernel.name} has no loop over prange to make {wanted.threads} threads of",
            loc=kernel.loc,
            hint="write `for i in prange(n)` around independent iterations, or leave threads out",
        )
    return lines


def lowered(
    kernel: KernelFunction | LLKernel, strict_fp: bool, spread: bool
) -> tuple[Function, Parallel | None, tuple[str, ...]]:
    """The kernel in SSA form, the loop to spread, and the warnings that the frontend gave."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", VividcWarning)
        function, parallel = _cut(kernel, strict_fp, spread)
    for warning in caught:
        warnings.warn_explicit(warning.message, warning.category, warning.filename, warning.lineno)
    told = (str(w.message) for w in caught if issubclass(w.category, VividcWarning))
    return function, parallel, tuple(told)


def _cut(
    kernel: KernelFunction | LLKernel, strict_fp: bool, spread: bool
) -> tuple[Function, Parallel | None]:
    """The function, with its loop over `prange` cut if it is to be spread over tiles, and is proved
    to be the same in parts; if it is not, a warning says why.
    """
    lines = kernel.prange_lines if isinstance(kernel, KernelFunction) and spread else frozenset()
    if not lines or not isinstance(kernel, KernelFunction):
        if isinstance(kernel, KernelFunction) and spread and kernel.called_prange:
            text = f"its loop over prange is in {kernel.called_prange}, which it calls"
            text = (
                f"{kernel.loc}: {kernel.name} runs on one tile only: {text}; write it in the kernel"
            )
            warn(text)
        return watched("frontend", lambda: kernel.lower(strict_fp=strict_fp)), None
    function = watched("frontend", lambda: kernel.lower(strict_fp=strict_fp, spread=True))
    try:
        return watched("cut-parallel-loop", lambda: cut_parallel_loop(function, lines))
    except KernelError as refusal:
        loc = refusal.loc or SourceLoc(function.file, min(lines))
        text = f"{loc}: {kernel.name} runs on one tile only: {refusal.reason}; {refusal.hint}"
        warn(text)
        return function, None


def compile_stages(
    function: Function,
    fabric: Fabric,
    options: CompileOptions,
    parallel: frozenset[int],
    spaces: Spaces,
    trips: Mapping[str, float] = NO_TRIPS,
) -> Program:
    """The program of the plan's best stage that can be mapped; `spaces`: of which matrices rows
    may lie further apart than they are long; `trips`: see `choose`.
    """
    estimator = replace(estimator_for(fabric, options), spaces=spaces)
    plan = planned(function, estimator, options, parallel, trips)
    earlier = Earlier()

    def attempt(stage: Stage, last_resort: bool, below: float) -> Outcome | None:
        limit_s = budget.share(last_resort).remaining_s
        guard_s = time_limit.remaining_s() * (1.0 if last_resort else TRANSFORMED_GUARD)
        with guarded(guard_s, grace_s=math.inf if last_resort else 0.0):
            shared = replace(options, time_limit_s=limit_s)
            before = replace(earlier, hopeless={}, crowded=set()) if last_resort else earlier
            return map_stage(stage, estimator, shared, before, last_resort, below)

    with limited(options.time_limit_s) as whole:
        budget = Budget.of(whole)
        hasty = options.effort == "normal"
        settled = settle(plan, attempt, HASTY if hasty else math.inf)
    notes = [
        f"{_place(settled.outcome, header)}: the loop {why} and runs block by block"
        for header, why in settled.outcome.sequential.items()
    ]
    loops = loop_reports(plan, settled)
    made = settled.outcome
    program = with_designs(made.program, made.kernel, made.results)
    return replace(program, warnings=(*notes, *_long(program, made)), loops=loops)


def _long(program: Program, made: Outcome) -> Iterator[str]:
    """What is told of a program that the configuration memory does not hold, unless what it does
    not hold is hardly ever run.
    """
    if made.achieved.contexts > program.fabric.controller.contexts:
        held = program.fabric.controller.contexts
        yield (
            f"{program.name} takes {len(program.words)} contexts, and fabric "
            f"{program.fabric.name} has {held}: others are brought while it runs, which takes time"
        )


def estimator_for(fabric: Fabric, options: CompileOptions) -> Estimator:
    """What estimates functions that are compiled so; contraction comes before."""
    passes = PassOptions(False, options.reassociate, options.precision)
    return Estimator(fabric, passes, resident=options.resident)


def planned(
    function: Function,
    estimator: Estimator,
    options: CompileOptions,
    parallel: frozenset[int],
    trips: Mapping[str, float] = NO_TRIPS,
) -> Plan:
    """The plan for a lowered function: what is mapped first, and what instead."""
    function = run_passes(_before_planning(options), function)
    return timed("choose", partial(choose, function, estimator, options.loops, parallel, trips))


def _before_planning(options: CompileOptions) -> Iterator[Callable[[Function], Function]]:
    if options.contract:  # copies may share a product, and must round like the one they are of
        yield contract_products
    narrow = arithmetic_format(options.precision)
    if narrow is not None:
        yield wraps(in_format)(lambda function: in_format(function, narrow))


def _place(outcome: Outcome, header: str) -> str:
    return str(outcome.stage.state.loc(header))


def lower(
    kernel: KernelFunction | LLKernel,
    *,
    strict_fp: bool = False,
    contract: bool = True,
    sequential: frozenset[str] = frozenset(),
) -> Kernel:
    """The kernel's regions with optimised graphs, before mapping.

    `sequential`: headers of innermost loops that are not to be modulo-scheduled.
    """
    function = replace(kernel.lower(strict_fp=strict_fp), sequential=sequential)
    if contract:
        function = contract_products(function)
    return optimize_kernel(build_kernel(function), PassOptions(contract=False))
