"""Runs a kernel's source through numba, the DFG interpreter and the simulator."""

from __future__ import annotations

import importlib.util
import warnings
from copy import deepcopy
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from random import Random

import numpy as np

import vividc
from tests.fuzz.generator import LENGTH
from vividc import arch
from vividc.dfg.build import build_kernel
from vividc.dfg.cfg import DType, Function
from vividc.dfg.interpreter import interpret
from vividc.dfg.loops import find_loops
from vividc.dfg.normalize import normalize
from vividc.dfg.pipeline import PassOptions, optimize_kernel
from vividc.dfg.regions import Kernel
from vividc.dfg.transform.refusal import Refusal
from vividc.dfg.transform.tidy import tidy
from vividc.errors import MappingFailed, TimeLimit, VividcError, VividcWarning
from vividc.frontend import KernelFunction
from vividc.planning.candidates import Candidate, Kind, State, apply
from vividc.planning.choose import choose
from vividc.planning.estimate import Estimator
from vividc.planning.frequency import expected_trips
from vividc.planning.options import TransformOptions

TRIALS = 2
OPTIONS = PassOptions(contract=False)
"""Without contraction the floats must be numba's, too, bit for bit."""

KINDS: tuple[Kind, ...] = ("full unrolling", "unrolling", "unroll-and-jam", "flattening")
_NUMBERS = count()


class Difference(Exception):
    """A witness disagrees with numba: which one and how."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """What became of a program: `kind` is "agrees", "refused", "differs" or "crashes"."""

    kind: str
    text: str = ""

    @property
    def is_find(self) -> bool:
        """Whether somebody has to look at it."""
        return self.kind in ("differs", "crashes")


def load(source: str, folder: Path) -> KernelFunction:
    """The kernel `program` of a module."""
    name = f"fuzz{next(_NUMBERS)}"
    file = folder / f"{name}.py"
    file.write_text(source, encoding="utf-8")
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    kernel: KernelFunction = module.program
    return kernel


def arguments(kernel: KernelFunction, seed: int, trial: int) -> list[object]:
    """Random arguments; those of later trials are nearer to 0."""
    rng = np.random.default_rng([seed, trial])
    limit = (2**62, 40)[trial % 2]
    found: list[object] = []
    for param in kernel.params:
        size = (LENGTH,) * param.ndim
        if param.dtype is DType.F32:
            found.append(rng.integers(-64, 64, size).astype(np.float32) / np.float32(8))
        elif param.dtype is DType.BOOL:
            found.append(rng.random(size) < 0.5)
        else:
            info = np.iinfo(_numpy(param.dtype))
            low, high = max(info.min, -limit), min(info.max, limit)
            drawn = rng.integers(low, high, size or 1, info.dtype, endpoint=True)
            found.append(drawn if param.ndim else drawn[0])
    return found


def _numpy(dtype: DType) -> str:
    sign = "u" if dtype.name.startswith("U") else ""
    return f"{sign}int{8 * dtype.size_bytes}"


def run_regions(lowered: Kernel, args: list[object]) -> object:
    """Interprets the graphs; arrays are updated in place."""
    memory = bytearray()
    inputs: dict[str, int] = {}
    places: list[tuple[int, np.ndarray]] = []
    for param, value in zip(lowered.params, args, strict=True):
        if isinstance(value, np.ndarray):
            inputs[f"&{param.name}"] = len(memory)
            inputs |= {f"{param.name}.shape{k}": n for k, n in enumerate(value.shape)}
            places.append((len(memory), value))
            memory += value.tobytes() + bytes(-value.nbytes % 4)
        else:
            word = int(value)  # type: ignore[call-overload]
            inputs |= {param.name: word & 2**32 - 1, f"{param.name}.high": word >> 32 & 2**32 - 1}
    for local in lowered.locals:
        inputs[f"&{local.name}"] = len(memory)
        words = local.contents or (0xA5A5A5A5,) * local.words
        memory += np.array(words, np.uint32).tobytes() + bytes(4 * (local.words - len(words)))
    result = interpret(lowered, memory, inputs, iteration_limit=300_000)
    for start, array in places:
        array[...] = np.frombuffer(bytes(memory[start : start + array.nbytes]), array.dtype)
    assert lowered.returns is not None
    bits = 8 * lowered.returns.size_bytes
    word = (result.value or 0) % 2**bits
    is_signed = not lowered.returns.name.startswith("U")
    return word - (word >> bits - 1 << bits) if is_signed else word


def transformed(function: Function, seed: int) -> list[tuple[str, Function]]:
    """The function as `vividc.compile` would choose, and after random transformations."""
    random = Random(seed)
    estimator = Estimator(arch.load("vivid-tile"), OPTIONS)
    plan = choose(function, estimator, TransformOptions())
    found = [("chosen", plan.stages[-1].state.function)]
    tidied = tidy(function)
    state = State(tidied, expected_trips(tidied, {}))
    names = []
    for _ in range(4):
        loops = sorted(loop.header for loop in find_loops(state.function))
        if not loops or sum(len(b.instrs) for b in state.function.blocks) > 600:
            break
        kind = random.choice(KINDS)
        factor = random.choice([2, 4]) if kind in ("unrolling", "unroll-and-jam") else 0
        candidate = Candidate(kind, random.choice(loops), factor)
        done = apply(state, candidate, expected_trips(state.function, state.hints))
        if not isinstance(done, Refusal):
            state = done
            names.append(f"{kind} {candidate.header} {factor}")
    return [*found, ("; ".join(names), state.function)] if names else found


def compare(what: str, found: list[object], expected: list[object]) -> None:
    """Demands equality, bit for bit but for what a NaN holds."""
    for number, (one, other) in enumerate(zip(found, expected, strict=True)):
        first, second = np.asarray(one), np.asarray(other)
        is_float = second.dtype.kind == "f"
        same = np.array_equal(first, second, equal_nan=is_float)
        if is_float and same:
            number_at = ~np.isnan(second)  # 0.0 == -0.0, but they differ in their sign
            same = bool((np.signbit(first) == np.signbit(second))[number_at].all())
        if not same:
            raise Difference(f"{what}: value {number} is {first.tolist()}, not {second.tolist()}")


def _run(kernel: KernelFunction, seed: int, simulate: bool) -> None:
    function = kernel.lower()
    forms = [("as written", function), *transformed(function, seed)]
    built = [
        (what, optimize_kernel(build_kernel(normalize(form)), OPTIONS)) for what, form in forms
    ]
    program = None
    if simulate:
        program = vividc.compile(kernel, contract=False, time_limit_s=15)
    for trial in range(TRIALS):
        args = arguments(kernel, seed, trial)
        expected = deepcopy(args)
        value = kernel(*expected)
        for what, lowered in built:
            mine = deepcopy(args)
            result = run_regions(lowered, mine)
            compare(f"interpreter, {what}", [result, *mine], [value, *expected])
        if program is not None:
            mine = deepcopy(args)
            result = vividc.simulate(program, *mine).value
            compare("simulator", [result, *mine], [value, *expected])


def judge(source: str, seed: int, folder: Path, *, simulate: bool = False) -> Verdict:
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
    kernel = load(source, folder)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", VividcWarning)
            kernel.lower()
    except VividcError as error:
        return Verdict("refused", error.reason)
    except Exception as error:  # whatever it is: a crash is what is looked for
        return Verdict("crashes", f"{type(error).__name__}: {error}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", VividcWarning)
            _run(kernel, seed, simulate)
    except Difference as error:
        return Verdict("differs", str(error))
    except (MappingFailed, TimeLimit) as error:
        return Verdict("refused", f"mapper: {type(error).__name__}")
    except Exception as error:  # whatever it is: a crash is what is looked for
        return Verdict("crashes", f"{type(error).__name__}: {error}")
    return Verdict("agrees")
