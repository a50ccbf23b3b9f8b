"""Compiles a kernel: frontend, regions, passes, mapping of every region, configuration words."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from vividc import arch, compiled_files
from vividc.arch import Accelerator
from vividc.arch.fabric import Fabric
from vividc.delivery import deliver, residents, variable_homes, with_homes
from vividc.dfg.build import build_kernel
from vividc.dfg.cfg import Function
from vividc.dfg.ir import DFG
from vividc.dfg.normalize import normalize
from vividc.dfg.parallel import Parallel
from vividc.dfg.parallel_loop import cut_parallel_loop
from vividc.dfg.pipeline import PassOptions, optimize_kernel
from vividc.dfg.precision import (
    FormatChoices,
    Precision,
    arithmetic_format,
    idle_names,
    parse_precision,
)
from vividc.dfg.product import Product
from vividc.dfg.regions import Kernel, Region
from vividc.dfg.transform.contract import contract as contract_products
from vividc.dfg.transform.in_format import in_format
from vividc.errors import (
    InternalError,
    KernelError,
    MappingFailed,
    SourceLoc,
    TimeLimit,
    VividcWarning,
    demand_callable,
    demand_type,
)
from vividc.frontend import KernelFunction, LLKernel
from vividc.gemm.kernels import AUTO, check_kernel_mode
from vividc.gemm.modes import MODES as GEMM_MODES
from vividc.mapper import MapProblem, MapResult, check_time_limit, map_dfg
from vividc.mapper.deadline import Deadline, limited
from vividc.mapper.list_schedule import list_schedule
from vividc.mapper.mapping import Mapping, Status
from vividc.mapper.straight_bounds import straight_lower_bound
from vividc.mapper.verify import violations
from vividc.planning.budget import Budget
from vividc.planning.choose import Stage, choose
from vividc.planning.estimate import Estimator, Shape
from vividc.planning.explain import loop_reports
from vividc.planning.fallback import Outcome, settle
from vividc.planning.options import Choices, Factors, TransformOptions, transform_options
from vividc.planning.products import priced, recognise
from vividc.program import STOPPED_BY_CLOCK, Program, encode
from vividc.program.programmable import demand_programmable

Progress = Callable[[str], None]

_LEAST_S = 1.0
"""Mapping the kernel as written is given so long in any case."""


@dataclass(frozen=True, slots=True)
class CompileOptions:
    """How a kernel is compiled.

    Attributes
    ----------
    mapper
        "auto", or another mapper's name.
    time_limit_s
        Seconds for mapping all regions; with a mapping in hand, what is left goes to proving it.
    strict_fp
        Refuse float64 arithmetic instead of running it in float32 with a warning.
    contract
        Fuse multiplications and additions into FMAs.
    progress
        Called with one line for each step.
    transform
        What is done to loops.
    reassociate
        Balance reductions of floats too, which changes their rounding; integers' always are.
    precision
        Formats of functions, from `parse_precision`.
    """

    mapper: str = "auto"
    time_limit_s: float = 60.0
    strict_fp: bool = False
    contract: bool = True
    progress: Progress | None = None
    transform: TransformOptions = field(default_factory=TransformOptions)
    reassociate: bool = False
    precision: Precision = ()


def compile(  # noqa: PLR0913 - the public contract, plus keywords
    kernel: KernelFunction | LLKernel,
    fabric: str | Fabric | Accelerator = "vivid-tile",
    mapper: str = "auto",
    time_limit_s: float = 60.0,
    *,
    strict_fp: bool = False,
    contract: bool = True,
    reassociate: bool = False,
    transform: str = "auto",
    unroll: Factors | None = None,
    jam: Factors | None = None,
    flatten: Choices | None = None,
    threads: int | None = None,
    precision: FormatChoices | None = None,
    progress: Progress | None = None,
    mode: str = AUTO,
) -> Program:
    """Compiles `kernel` for a tile, or for the tiles of an accelerator.

    Parameters
    ----------
    kernel
        A Python function decorated with `kernel`, or a C function from `load_ll`.
    fabric
        A fabric or an accelerator, a preset's name, or a YAML file. For an accelerator the loop
        over `numba.prange` becomes one that a launch can spread over the tiles.
    mapper, time_limit_s, strict_fp, contract, reassociate, progress
        See `CompileOptions`.
    transform
        "auto": loops are unrolled, jammed, flattened and run as threads where an estimate says that
        it pays; "none": not.
    unroll, jam
        Factors for loops by source line, as in {12: 4}: unroll the loop in line 12 by 4, or run 4
        iterations of it together in the loop inside it. 1 leaves a loop as it is.
    flatten
        Loops to make one with the loop inside them, or not, by source line, as in {12: True}.
    threads
        Iterations of the loop over `numba.prange` that a tile runs side by side, 1 to 8, each with
        loops and exits of its own. None: as many as the estimate says pay, if the transformation is
        "auto".
    precision
        Formats of functions, as in {"exp": "fp8"}: their results are numbers of that format, by
        fewer operations (`docs/precision.md`).
    mode
        How an accelerator runs a kernel that is a matrix product (docs/gemm.md): "gpu", on its
        tiles, "tpu-unified", "tpu-partitioned", or "auto", what is predicted to take fewest cycles
        with the sizes of a launch.

    Raises
    ------
    ArgumentError, KernelError, ArchError, MappingFailed, TimeLimit
    """
    loaded = _checked(kernel, fabric, time_limit_s)
    demand_type(mapper, str, "the mapper", 'give a name, as "auto"')
    demand_callable(progress, "progress")
    check_kernel_mode(mode)
    machine = loaded.fabric if isinstance(loaded, Accelerator) else loaded
    wanted = transform_options(transform, unroll, jam, flatten, threads)
    options = CompileOptions(
        *(mapper, time_limit_s, strict_fp, contract, progress, wanted, reassociate),
        parse_precision(precision),
    )
    function, parallel, told = _lowered(kernel, strict_fp, isinstance(loaded, Accelerator))
    for name in idle_names(precision, function):
        text = f"{kernel.name} has no {name}: its precision changes nothing"
        warnings.warn(text, VividcWarning, stacklevel=2)
        told = (*told, text)
    lines = _parallel_lines(kernel, wanted)
    if isinstance(loaded, Accelerator) and parallel is None and wanted.threads is None:
        lines = frozenset()  # iterations that are not proved independent keep their order
    product = _product(kernel, loaded, options, mode)
    program = _compile_stages(function, machine, options, lines)
    for text in program.warnings:
        if text != STOPPED_BY_CLOCK:  # a busy machine is no reason to fail tests
            warnings.warn(text, VividcWarning, stacklevel=2)
    warned = (*told, *program.warnings)
    compiled_files.note(program.provenance.kernel_file, program.provenance.kernel_sha256)
    return replace(program, warnings=warned, parallel=parallel, product=product)


def _checked(
    kernel: object, fabric: str | Fabric | Accelerator, time_limit_s: float
) -> Fabric | Accelerator:
    """The machine to compile for; arguments that make no sense are refused."""
    hint = "decorate the function with @vividc.kernel, or load a C function with vividc.load_ll"
    demand_type(kernel, (KernelFunction, LLKernel), "the kernel", hint)
    hint = "give a preset, a YAML file or a Fabric"
    demand_type(fabric, (str, Fabric, Accelerator), "the fabric", hint)
    machine = arch.load(fabric) if isinstance(fabric, str) else fabric
    demand_programmable(machine.fabric if isinstance(machine, Accelerator) else machine)
    check_time_limit(time_limit_s)
    return machine


def _product(
    kernel: KernelFunction | LLKernel,
    machine: Fabric | Accelerator,
    options: CompileOptions,
    mode: str,
) -> Product | None:
    """The matrix product that a kernel is; one that is to run as such must be one.

    Raises
    ------
    KernelError
        The mode is TPU-like, and the kernel or the machine has no such mode.
    """
    found: Product | str = "the fabric is one tile: give an accelerator, as vivid"
    if isinstance(machine, Accelerator):
        function = _whole(kernel, options.strict_fp)
        found = recognise(function)
        if not options.contract:
            found = "its sums are chains of FMAs, which --no-contract forbids"
        elif options.precision:
            found = "formats of its arithmetic or functions are chosen by --precision"
        if isinstance(found, Product):
            estimator = Estimator(machine.fabric, PassOptions(options.contract))
            return replace(priced(found, function, estimator, options.transform), mode=mode)
    if mode in GEMM_MODES:
        raise KernelError(
            f"{kernel.name} cannot run in mode {mode}: {found}",
            hint="a matrix product is three loops, as in docs/gemm.md; or choose the mode gpu",
        )
    return None


def why_no_product(kernel: KernelFunction | LLKernel) -> str:
    """Why a kernel is no matrix product; "": it is one."""
    found = recognise(_whole(kernel, strict_fp=False))
    return found if isinstance(found, str) else ""


def _whole(kernel: KernelFunction | LLKernel, strict_fp: bool) -> Function:
    """The kernel in SSA form, loops over `prange` as any other."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VividcWarning)  # they are told of elsewhere
        return normalize(kernel.lower(strict_fp=strict_fp))


def _parallel_lines(kernel: KernelFunction | LLKernel, wanted: TransformOptions) -> frozenset[int]:
    """Lines with loops over `prange`; some, if threads are asked for."""
    lines = kernel.prange_lines if isinstance(kernel, KernelFunction) else frozenset[int]()
    if not lines and (wanted.threads or 1) > 1:
        raise KernelError(
            f"{kernel.name} has no loop over prange to make {wanted.threads} threads of",
            loc=kernel.loc,
            hint="write `for i in prange(n)` around independent iterations, or leave threads out",
        )
    return lines


def _lowered(
    kernel: KernelFunction | LLKernel, strict_fp: bool, spread: bool
) -> tuple[Function, Parallel | None, tuple[str, ...]]:
    """The kernel in SSA form, its loop to spread, and the frontend's warnings, given too."""
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
        return kernel.lower(strict_fp=strict_fp), None
    function = kernel.lower(strict_fp=strict_fp, spread=True)
    try:
        return cut_parallel_loop(function, lines)
    except KernelError as refusal:
        loc = refusal.loc or SourceLoc(function.file, min(lines))
        text = f"{loc}: {kernel.name} runs on one tile only: {refusal.reason}; {refusal.hint}"
        warnings.warn(text, VividcWarning, stacklevel=2)
        return function, None


def _compile_stages(
    function: Function, fabric: Fabric, options: CompileOptions, parallel: frozenset[int]
) -> Program:
    """The program of the plan's best stage that can be mapped."""
    if options.contract:  # copies may share a product, and must round like the one they are of
        function = contract_products(function)
    narrow = arithmetic_format(options.precision)
    if narrow is not None:
        function = in_format(function, narrow)
    passes = PassOptions(False, options.reassociate, options.precision)
    estimator = Estimator(fabric, passes)
    plan = choose(function, estimator, options.transform, parallel)
    known: dict[DFG, MapResult] = {}

    def attempt(stage: Stage, last_resort: bool) -> Outcome:
        deadline = budget.share(last_resort)
        return _map_stage(stage, estimator, options, known, deadline, last_resort)

    with limited(options.time_limit_s) as whole:
        budget = Budget.of(whole.remaining_s)
        settled = settle(plan, attempt)
    notes = [
        f"{_place(settled.outcome, header)}: the loop {why} and runs block by block"
        for header, why in settled.outcome.sequential.items()
    ]
    if whole.meter.hurried:
        notes.append(STOPPED_BY_CLOCK)
    loops = loop_reports(plan, settled)
    return replace(settled.outcome.program, warnings=tuple(notes), loops=loops)


def _map_stage(
    stage: Stage,
    estimator: Estimator,
    options: CompileOptions,
    known: dict[DFG, MapResult],
    deadline: Deadline,
    last_resort: bool,
) -> Outcome:
    """Maps a stage; a loop that cannot be modulo-scheduled (in time) runs block by block, unless
    it is a transformed one.
    """
    sequential: dict[str, str] = {}
    while True:
        function = replace(stage.state.function, sequential=frozenset(sequential))
        function = estimator.prepared(function, stage.state.hints)
        kernel = optimize_kernel(build_kernel(function), estimator.options)
        try:
            limited = replace(options, time_limit_s=max(deadline.remaining_s, _LEAST_S))
            mapped, results = map_kernel(kernel, estimator.fabric, limited, known)
            break
        except (MappingFailed, TimeLimit) as error:
            if not error.header or (error.header in stage.state.made and not last_resort):
                raise
            timed_out = isinstance(error, TimeLimit)
            why = "took too long" if timed_out else "has no modulo schedule"
            sequential[error.header] = why
    mappings = {index: _mapping(result) for index, result in results.items()}
    program = encode(
        mapped, estimator.fabric, mappings, reports=results, options=_provenance(options)
    )
    shapes = [
        Shape(row.ii, row.span, len(region.dfg.operations))
        for row, region in zip(program.table, mapped.regions, strict=True)
    ]
    achieved = estimator.priced(function, mapped, shapes, stage.state.hints)
    return Outcome(stage, mapped, results, program, achieved, sequential)


def _provenance(options: CompileOptions) -> dict[str, str | int | float | bool | None]:
    return {
        "mapper": options.mapper,
        "strict_fp": options.strict_fp,
        "contract": options.contract,
        "reassociate": options.reassociate,
        "transform": options.transform.mode,
        "threads": options.transform.threads,
        **{f"precision {name}": fmt for name, fmt in options.precision},
    }


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


def map_kernel(
    kernel: Kernel,
    fabric: Fabric,
    options: CompileOptions,
    known: dict[DFG, MapResult] | None = None,
) -> tuple[Kernel, dict[int, MapResult]]:
    """Maps all regions: loops first, then straight regions around them.

    `known` keeps the results of loops from one call to the next.

    Returns
    -------
    The kernel whose straight regions hold their deliveries, and the result of each region by index.

    Raises
    ------
    MappingFailed, TimeLimit
        With `header` set if a loop is the reason.
    """
    results = _map_loops(kernel, fabric, options, {} if known is None else known)
    loops = {index: _mapping(result) for index, result in results.items()}
    homes = variable_homes(kernel, fabric, loops)
    done = [(kernel.regions[index].dfg, mapping) for index, mapping in loops.items()]
    regions = list(kernel.regions)
    for index, region in enumerate(kernel.regions):
        if region.kind == "loop":
            continue
        ready = deliver(region, homes)
        held = with_homes(residents(fabric, done), homes)
        problem = MapProblem(ready.dfg, fabric, ready.allowed, held)
        results[index] = _map_straight(problem, options)
        regions[index] = replace(region, dfg=ready.dfg)
        done.append((ready.dfg, _mapping(results[index])))
    return replace(kernel, regions=tuple(regions)), results


def _map_loops(
    kernel: Kernel, fabric: Fabric, options: CompileOptions, known: dict[DFG, MapResult]
) -> dict[int, MapResult]:
    loops = [(i, region) for i, region in enumerate(kernel.regions) if region.kind == "loop"]
    deadline = Deadline.after(options.time_limit_s)
    results: dict[int, MapResult] = {}
    done: list[tuple[DFG, Mapping]] = []
    for number, (index, region) in enumerate(loops):
        resident = residents(fabric, done)
        result = known.get(region.dfg)
        if result is None or violations(region.dfg, fabric, _mapping(result), resident=resident):
            share = deadline.remaining_s / (len(loops) - number)
            result = map_dfg(
                region.dfg,
                fabric,
                options.mapper,
                time_limit_s=max(share, 1.0),
                resident=resident,
                progress=_prefixed(options.progress, region),
                thrifty=True,
            )
        _demand(result, region)
        known[region.dfg] = result
        results[index] = result
        done.append((region.dfg, _mapping(result)))
    return results


def _map_straight(problem: MapProblem, options: CompileOptions) -> MapResult:
    start = time.monotonic()
    mapping = list_schedule(problem)
    found = violations(
        problem.dfg,
        problem.fabric,
        mapping,
        allowed=problem.allowed,
        resident=problem.resident,
        straight=True,
    )
    if found:
        raise InternalError(f"list schedule of {problem.dfg.name}: {found[0].message}")
    bound = straight_lower_bound(problem)
    wall_s = time.monotonic() - start
    if options.progress is not None:
        options.progress(f"{problem.dfg.name}: {mapping.ii} cycles")
    status: Status = "optimal" if mapping.ii <= bound.ii else "feasible"
    return MapResult(status, mapping.ii, bound.ii, (bound,), mapping, "list", wall_s)


def _demand(result: MapResult, region: Region) -> None:
    if result.mapping is not None:
        return
    error: MappingFailed | TimeLimit
    if result.status == "infeasible":
        error = MappingFailed(f"{region.name} cannot be mapped: {result.explain()}", loc=region.loc)
    else:
        hint = "give a longer --time-limit, or a larger fabric"
        text = f"{region.name} was not mapped in time: {result.explain()}"
        error = TimeLimit(text, loc=region.loc, hint=hint)
    error.header = region.header
    raise error


def _mapping(result: MapResult) -> Mapping:
    if result.mapping is None:
        raise InternalError("a region without a mapping was passed on")
    return result.mapping


def _prefixed(progress: Progress | None, region: Region) -> Progress | None:
    if progress is None:
        return None
    return lambda text: progress(f"{region.name}: {text}")
