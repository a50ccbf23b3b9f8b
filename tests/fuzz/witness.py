"""Runs a kernel by numba, by the interpreter before and after transformations, and simulated."""

from __future__ import annotations

import importlib.util
import linecache
import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from random import Random
from types import SimpleNamespace

import numpy as np

import vividc
from tests.fuzz.generate import random_arguments
from vividc import arch
from vividc.dfg.build import build_kernel
from vividc.dfg.cfg import Function
from vividc.dfg.interpreter import interpret
from vividc.dfg.loops import find_loops
from vividc.dfg.normalize import normalize
from vividc.dfg.pipeline import PassOptions, optimize_kernel
from vividc.dfg.regions import Kernel
from vividc.dfg.transform.refusal import Refusal
from vividc.dfg.transform.tidy import tidy
from vividc.errors import MappingFailed, TimeLimit, VividcError, VividcWarning
from vividc.frontend import KernelFunction
from vividc.planning.candidates import Candidate, State, apply
from vividc.planning.choose import choose
from vividc.planning.estimate import Estimator
from vividc.planning.frequency import expected_trips
from vividc.planning.options import TransformOptions
from vividc.sim.bind import bind, returned

TRIALS = 3
OPTIONS = PassOptions(contract=False)
ITERATION_LIMIT = 300_000
# exp, sin and division state at most a few units in the last place; their arguments are small.
TOLERANCE = 1e-5
INEXACT_ARRAY = 7
FORCED = (
    Candidate("unrolling", "", 2),
    Candidate("unrolling", "", 4),
    Candidate("unroll-and-jam", "", 2),
    Candidate("full unrolling", ""),
    Candidate("flattening", ""),
)


@dataclass(frozen=True, slots=True)
class Verdict:
    """How a program fared: `kind` is "agrees", "refused", "timeout", "differs" or "crashed"."""

    kind: str
    witness: str = ""
    detail: str = ""

    @property
    def find(self) -> bool:
        """The program shows a bug."""
        return self.kind in ("differs", "crashed")


def load(source: str, folder: Path, name: str) -> KernelFunction:
    """The kernel `program` of a module's source."""
    file = folder / f"{name}.py"
    file.write_text(source, encoding="utf-8")
    linecache.checkcache(str(file))
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    kernel: KernelFunction = module.program
    return kernel


def judge(source: str, seed: int, folder: Path, name: str, simulate: bool) -> Verdict:
    """Runs every witness on the same arguments; the first find counts.

    numba's own failures are raised as they are: then the source is no kernel.
    """
    kernel = load(source, folder, name)
    expected = [random_arguments(seed, trial) for trial in range(TRIALS)]
    values = [kernel(*arguments) for arguments in expected]
    witness = "lowering"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", VividcWarning)
            function = kernel.lower()
            for witness, lowered in _variants(function, seed):
                for trial in range(TRIALS):
                    arguments = random_arguments(seed, trial)
                    value = interpreted(lowered, arguments)
                    wrong = difference(arguments, value, expected[trial], values[trial])
                    if wrong:
                        return Verdict("differs", witness, f"trial {trial}: {wrong}")
            if simulate:
                witness = "simulator"
                program = vividc.compile(kernel, time_limit_s=20, contract=False)
                arguments = random_arguments(seed, 0)
                value = vividc.simulate(program, *arguments, cycle_limit=3_000_000).value
                wrong = difference(arguments, value, expected[0], values[0])
                if wrong:
                    return Verdict("differs", witness, wrong)
    except (MappingFailed, TimeLimit) as error:
        return Verdict("timeout", witness, error.reason)
    except VividcError as error:
        # After lowering nothing may be refused: the regions are what the compiler made itself.
        kind = "refused" if witness == "lowering" else "crashed"
        return Verdict(kind, witness, str(error))
    except Exception as error:
        return Verdict("crashed", witness, f"{type(error).__name__}: {error}"[:500])
    return Verdict("agrees")


def _variants(function: Function, seed: int):  # type: ignore[no-untyped-def]
    """The regions as written, as planned, and after forced transformations, each by name."""
    yield "as written", optimize_kernel(build_kernel(function), OPTIONS)
    estimator = Estimator(arch.load("vivid-tile"), OPTIONS)
    plan = choose(function, estimator, TransformOptions())
    if len(plan.stages) > 1:
        yield "planned", _regions(plan.stages[-1].state.function)
    tidied = tidy(function)
    yield "tidied", _regions(tidied)
    state = State(tidied, expected_trips(tidied, {}))
    random = Random(seed)
    names = []
    for _ in range(3):
        loops = find_loops(state.function)
        if not loops:
            return
        header = random.choice(loops).header
        candidate = replace(random.choice(FORCED), header=header)
        done = apply(state, candidate, expected_trips(state.function, state.hints))
        if isinstance(done, Refusal):
            continue
        state = done
        names.append(f"{candidate.kind} {candidate.factor} of {header}")
        yield f"forced {', '.join(names)}", _regions(state.function)


def _regions(function: Function) -> Kernel:
    return optimize_kernel(build_kernel(normalize(function)), OPTIONS)


def interpreted(kernel: Kernel, arguments: list[object]) -> object:
    """Runs the graphs; arrays are updated in place."""
    launch = SimpleNamespace(
        name=kernel.name,
        params=kernel.params,
        fabric=arch.load("vivid-tile"),
        banks={},
        locals=kernel.locals,
        stored_arrays=frozenset(),
    )
    bound = bind(launch, tuple(arguments), {})  # type: ignore[arg-type]
    memory = bound.memory.copy()
    done = interpret(kernel, memory, bound.inputs, iteration_limit=ITERATION_LIMIT)
    bound.copy_back(memory, frozenset(bound.arrays))
    if kernel.returns is None or done.value is None:
        return None
    return returned(kernel.returns, done.value)


def difference(found: list[object], value: object, expected: list[object], wanted: object) -> str:
    """What differs first, or nothing: bit for bit, but `out` within `TOLERANCE`."""
    if value != wanted:
        return f"returned {value!r}, numba {wanted!r}"
    for place, (one, other) in enumerate(zip(found, expected, strict=True)):
        mine, theirs = np.asarray(one), np.asarray(other)
        if place == INEXACT_ARRAY:
            same = np.allclose(mine, theirs, rtol=TOLERANCE, atol=TOLERANCE, equal_nan=True)
        else:
            both_nan = (mine != mine) & (theirs != theirs)  # noqa: PLR0124 - NaN
            same = bool(np.all(both_nan | (mine == theirs)))
        if not same:
            return f"argument {place}: {mine.tolist()}, numba {theirs.tolist()}"
    return ""
