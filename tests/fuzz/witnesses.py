"""Runs a kernel's source through numba, the DFG interpreter and the simulator."""

from __future__ import annotations

import importlib.util
import warnings
from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import partial
from itertools import count
from pathlib import Path
from random import Random
from types import ModuleType
from typing import Literal

import numba
import numpy as np

import vividc
from tests.dfg.memory_trace import Trace
from tests.fuzz.arguments import Difference, Shapes, arguments, compare
from tests.fuzz.forms import OPTIONS, asked, forms
from tests.fuzz.kinds import Kinds
from vividc import arch
from vividc.arch.fabric import Fabric
from vividc.compiler.regions.map_regions import Unmapped, map_kernel
from vividc.compiler.stage import CompileOptions
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.interpret.interpreter import interpret
from vividc.dfg.pipeline import optimize_kernel
from vividc.dfg.regions import Kernel
from vividc.errors import (
    KernelError,
    KernelRaised,
    MappingFailed,
    SimulationError,
    TimeLimit,
    VividcError,
    VividcWarning,
)
from vividc.frontend import KernelFunction
from vividc.machine.params import DType, given
from vividc.program import Program, encode
from vividc.ssa.flow import find_loops
from vividc.ssa.ir import Function
from vividc.ssa.rewrite.normalize import normalize

TRIALS = 3
MAPPING_S = 4.0
"""For a kernel's loops; one that takes longer runs block by block."""

ROUGH = frozenset("g")
"""Arrays of results that depend on the last bits of elementary functions."""

_ENTRIES = (32, 8, 12, 6, 32)
"""Of each constant store, by seed."""

_CONTEXTS = (512, 48, 512)
"""Of the configuration memory, by seed: of some tiles it holds part of a program only."""

Simulated = Literal["", "blocks", "mapped", "tiles"]
"""Whether the simulator is a witness, and whether loops are scheduled for it or run in blocks, or
are spread over tiles (`spreads`).
"""

_NUMBERS = count()
_SHAPES = {"SHAPES": {}, "FIXED": True, "MOST": {}}


@dataclass(frozen=True, slots=True)
class Verdict:
    """What became of a program: `kind` is "agrees", "refused", "differs" or "crashes"."""

    kind: str
    text: str = ""
    tried: tuple[str, ...] = ()
    """Kinds of arguments that made no difference, or were refused as they should."""

    @property
    def is_find(self) -> bool:
        """Whether somebody has to look at it."""
        return self.kind in ("differs", "crashes")


def load(source: str, folder: Path) -> ModuleType:
    """The module, whose `program` is a kernel."""
    name = f"fuzz{next(_NUMBERS)}"
    file = folder / f"{name}.py"
    file.write_text(source, encoding="utf-8")
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def shapes_of(module: ModuleType) -> Shapes:
    """What a module says of its arrays; without a word they are `LENGTH` long."""
    given = (getattr(module, name, other) for name, other in _SHAPES.items())
    return Shapes(*given)


def run_regions(lowered: Kernel, args: list[object]) -> object:
    """Interprets the graphs; arrays are updated in place. Accesses that meet are kept in order."""
    memory = bytearray()
    inputs: dict[str, int] = {}
    places: list[tuple[int, np.ndarray]] = []
    for param, value in zip(given(lowered.params), args, strict=True):
        if isinstance(value, np.ndarray):
            inputs[f"&{param.name}"] = len(memory)
            inputs |= {f"{param.name}.shape{k}": n for k, n in enumerate(value.shape)}
            places.append((len(memory), value))
            memory += value.tobytes() + bytes(-value.nbytes % 4)
        else:
            assert isinstance(value, np.generic)
            word = int.from_bytes(value.tobytes(), "little")  # less than a word: zeros above
            inputs |= {param.name: word & 2**32 - 1, f"{param.name}.high": word >> 32}
    made: dict[str, np.ndarray] = {}
    for param in (param for param in lowered.params if param.made):
        made[param.name] = np.zeros(param.words_at(inputs), param.dtype.value)
        inputs[f"&{param.name}"] = len(memory)
        places.append((len(memory), made[param.name]))
        memory += made[param.name].tobytes()
    for local in (declared.at_launch(inputs) for declared in lowered.locals):
        inputs[f"&{local.name}"] = len(memory)
        words = local.contents or (0xA5A5A5A5,) * local.words
        memory += np.array(words, np.uint32).tobytes() + bytes(4 * (local.words - len(words)))
    trace = Trace(lowered)
    result = interpret(lowered, memory, inputs, iteration_limit=300_000, watch=trace)
    trace.demand_order()
    for start, array in places:
        raw = np.frombuffer(bytes(memory[start : start + array.nbytes]), array.dtype)
        array[...] = raw.reshape(array.shape)
    if lowered.results is not None:
        named = {p.name: a for p, a in zip(given(lowered.params), args, strict=True) if p.ndim}
        value = deepcopy(lowered.results.value(named | made, inputs))
        if lowered.returns is None:
            return value
    return _returned(lowered.returns, result.value or 0)


def _returned(dtype: DType | None, value: int) -> object:
    if dtype is None:
        return None
    if dtype is DType.F32:
        return np.array([value], np.uint32).view(np.float32)[0]
    if dtype is DType.BOOL:
        return bool(value & 1)
    bits = {DType.I64: 64, DType.U64: 64}.get(dtype, 8 * dtype.size_bytes)
    word = value % 2**bits
    return word - (word >> bits - 1 << bits) if dtype.is_signed else word


def words_in_blocks(function: Function) -> Program:
    """The words of a function none of whose loops is scheduled, which is quick."""
    fabric = arch.load("vivid-tile")
    headers = frozenset(loop.header for loop in find_loops(normalize(function)))
    function = normalize(replace(function, sequential=headers))
    kernel = optimize_kernel(build_kernel(function), OPTIONS)
    made = map_kernel(kernel, fabric, CompileOptions(time_limit_s=MAPPING_S))
    if isinstance(made, Unmapped):
        raise made.error
    mapped, results = made
    mappings = {i: r.mapping for i, r in results.items() if r.mapping is not None}
    return encode(mapped, fabric, mappings, reports=results)


def mapped(kernel: KernelFunction, source: str, seed: int) -> Program:
    """The words with loops scheduled, after random wishes for their transformation."""
    mapping = partial(vividc.compile, kernel, _tile(seed), contract=False, time_limit_s=MAPPING_S)
    try:
        return mapping(loops=asked(source, seed))
    except KernelError:  # a loop that cannot be transformed as asked
        return mapping(loops=vividc.LoopOptions(auto=False))


def _tile(seed: int) -> Fabric:
    """A tile whose constant stores may be so small that variables share their entries, and whose
    configuration memory may be so small that contexts are brought as they are needed.
    """
    tile = _with_contexts(arch.load_tile("vivid-tile"), _CONTEXTS[seed % len(_CONTEXTS)])
    entries = _ENTRIES[seed % len(_ENTRIES)]
    return replace(tile, pes=tuple(replace(pe, constants=entries) for pe in tile.pes))


def _with_contexts(tile: Fabric, contexts: int) -> Fabric:
    return replace(tile, controller=replace(tile.controller, contexts=contexts))


def _in_few_contexts(program: Program, seed: int) -> Program:
    """Every other program: on a tile that holds little more than its longest region."""
    if seed % 2 or any(row.drain or row.fill for row in program.table):
        return program
    longest = max(row.ii for row in program.table)
    return replace(program, fabric=_with_contexts(program.fabric, longest + seed % 5))


def _of_a_model(kernel: KernelFunction, seed: int) -> KernelFunction:
    """The kernel, or the same under the error model "python": one in four."""
    if seed % 4:
        return kernel
    return KernelFunction(kernel.py_func, kernel.numba_signature, kernel.name, "python")


def _all_raise(
    built: list[tuple[str, Kernel]], program: Program | None, args: list[object]
) -> None:
    """Demand that each witness ends with the error that numba raises."""
    runs = [(what, partial(run_regions, lowered, deepcopy(args))) for what, lowered in built]
    if program is not None:
        runs.append(("simulator", partial(vividc.simulate, program, *deepcopy(args))))
    for what, run in runs:
        try:
            run()
        except SimulationError as error:
            if "ZeroDivisionError" in str(error):
                continue
        raise Difference(f"{what}: numba raises ZeroDivisionError, which it does not")


def _run(module: ModuleType, source: str, seed: int, simulate: Simulated) -> tuple[str, ...]:
    kernel = _of_a_model(module.program, seed)
    function = kernel.lower()
    built: list[tuple[str, Kernel]] = []
    tried = forms(function, seed, is_whole="float32" not in source)
    for form in tried:
        lowered = optimize_kernel(build_kernel(normalize(form.function)), form.options)
        built.append((f"interpreter, {form.text}", lowered))
    program = None
    if simulate == "mapped":
        program = mapped(kernel, source, seed)
    elif simulate == "blocks":
        program = _in_few_contexts(words_in_blocks(tried[-1].function), seed)
    rough = frozenset(n for n, param in enumerate(kernel.params, 1) if param.name in ROUGH)
    tried: tuple[str, ...] = ()
    for trial in range(TRIALS):
        args = arguments(kernel, shapes_of(module), seed, trial)
        expected = deepcopy(args)
        try:
            value = _told_of(kernel, expected, source)
        except ZeroDivisionError:
            _all_raise(built, program, args)
            continue
        first: list[object] = []
        for what, lowered in built:
            mine = deepcopy(args)
            result = _told_of(partial(run_regions, lowered), [mine], source)
            compare(what, [result, *mine], [value, *expected], rough)
            first = first or [result, *mine]
            compare(f"{what}, against as written", [result, *mine], first)
        if trial == seed % (2 * TRIALS):  # in half of the programs
            _for_these_sizes(kernel, args, first, seed, simulate)
        if program is not None:
            _simulate(program, args, f"simulator, {simulate}", first)
            if trial == seed % TRIALS and "raise " not in source:
                tried = _kinds(program, built[0][1]).check(args, Random(seed))
    return tried


def _told_of(run: Callable[..., object], args: Sequence[object], source: str) -> object:
    """What a run returns, or the type of what it raises, if the kernel has a `raise`."""
    try:
        return run(*args)
    except (ValueError, OverflowError) as error:
        is_kernels = isinstance(error, KernelRaised) or not isinstance(error, VividcError)
        if "raise " not in source or not is_kernels:
            raise
        return "ValueError" if isinstance(error, ValueError) else "OverflowError"


def _for_these_sizes(
    kernel: KernelFunction,
    args: list[object],
    expected: list[object],
    seed: int,
    simulate: Simulated,
) -> None:
    """Demands the same of what is compiled for the sizes of these arguments only."""
    function = kernel.sized(args).lower()
    tried = forms(function, seed, is_whole=False)
    for form in tried:
        lowered = optimize_kernel(build_kernel(normalize(form.function)), form.options)
        mine = deepcopy(args)
        result = _told_of(partial(run_regions, lowered), [mine], "raise ")
        compare(f"interpreter, known sizes, {form.text}", [result, *mine], expected)
    if simulate == "blocks":
        program = words_in_blocks(tried[-1].function)
        _simulate(program, args, "simulator, known sizes", expected)


def _kinds(program: Program, lowered: Kernel) -> Kinds:
    """The program's arguments in other clothes, against the interpreter."""
    return Kinds(
        lambda args: vividc.simulate(program, *args).value,
        lambda args: run_regions(lowered, args),
        frozenset(n for n, p in enumerate(program.params) if p.name in program.stored_arrays),
    )


def _simulate(program: Program, args: list[object], what: str, expected: list[object]) -> None:
    """Demands the results of both engines, and that the engines count the same."""
    counts = []
    for engine in ("reference", "native"):
        mine = deepcopy(args)
        counts.append({})
        run = partial(_simulated, program, engine, counts[-1])
        value = _told_of(run, mine, "raise ")
        compare(f"{what}, {engine} engine", [value, *mine], expected)
    if counts[0] != counts[1]:
        raise Difference(f"{what}: the engines count {counts[0]} and {counts[1]}")


def _simulated(program: Program, engine: str, stats: dict[str, object], *args: object) -> object:
    result = vividc.simulate(program, *args, engine=engine)
    stats |= {**result.stats, "engine": ""}
    return result.value


def stays_inside(source: str, seed: int, folder: Path) -> bool:
    """Whether no access leaves its array, so that a shrunk program means something."""
    module = load(source, folder)
    kernel: KernelFunction = module.program
    checked = numba.njit(kernel.numba_signature, boundscheck=True, error_model="numpy")
    run = checked(kernel.py_func)
    try:
        for trial in range(TRIALS):
            run(*arguments(kernel, shapes_of(module), seed, trial))
    except IndexError:
        return False
    return True


def judge(source: str, seed: int, folder: Path, *, simulate: Simulated = "") -> Verdict:
    """Whether all witnesses agree on a program.

    Parameters
    ----------
    source
        A module whose `program` is a kernel.
    seed
        Of the arguments and of the transformations.
    folder
        Where the module is written.
    simulate
        Map the kernel, too, and run its words.
    """
    module = load(source, folder)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", VividcWarning)
            tried = _run(module, source, seed, simulate)
    except Difference as error:
        return Verdict("differs", str(error))
    except (MappingFailed, TimeLimit) as error:
        return Verdict("refused", f"mapper: {type(error).__name__}: {error.reason}")
    except KernelError as error:
        return Verdict("refused", error.reason)
    except Exception as error:  # whatever it is: a crash is what is looked for
        return Verdict("crashes", f"{type(error).__name__}: {error}")
    return Verdict("agrees", tried=tried)
