"""A function as written and after transformations: chosen, asked for, and at random."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random
from typing import Any

from vividc import arch
from vividc.compiler.planning.candidates import Candidate, Kind, apply
from vividc.compiler.planning.choose import choose
from vividc.compiler.planning.estimate import Estimator
from vividc.compiler.planning.options import LoopOptions
from vividc.compiler.planning.state import State
from vividc.dfg.pipeline import PassOptions
from vividc.ssa.analysis.frequency import expected_trips
from vividc.ssa.flow import find_loops
from vividc.ssa.ir import Function
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

OPTIONS = PassOptions(contract=False)
"""Without contraction the floats must be numba's, too, bit for bit."""

KINDS: tuple[Kind, ...] = (
    "full unrolling",
    "unrolling",
    "masked unrolling",
    "unroll-and-jam",
    "flattening",
    "versioning",
)
WITH_FACTOR = ("unrolling", "masked unrolling", "unroll-and-jam", "partial results")
MOST_INSTRUCTIONS = 400
"""No further transformation of what is larger: it would take its time and show little."""


@dataclass(frozen=True, slots=True)
class Form:
    """A function, how it came about, and the passes' options for it."""

    text: str
    function: Function
    options: PassOptions = OPTIONS


def forms(function: Function, seed: int, *, is_whole: bool) -> list[Form]:
    """The function as written, and some of its transformed forms.

    Parameters
    ----------
    seed
        Of the choice of transformations.
    is_whole
        No floats: sums may be balanced, too.
    """
    random = Random(seed)
    found = [Form("as written", function)]
    kind = random.random()
    if kind < 0.2:
        estimator = Estimator(arch.load("vivid-tile"), OPTIONS)
        plan = choose(function, estimator, LoopOptions())
        found.append(Form("chosen", plan.stages[-1].state.function))
    for _ in range(2 if kind > 0.5 else 1):
        text, other = at_random(function, random, is_whole=is_whole)
        found += [Form(text, other)] if text else []
    if is_whole and random.random() < 0.3:
        options = PassOptions(contract=False, reassociate=True)
        last = found[-1]
        found[-1] = Form(f"{last.text}, reassociated", last.function, options)
    return found


def at_random(
    function: Function, random: Random, *, is_whole: bool = False
) -> tuple[str, Function]:
    """Some transformations; their names are empty if none was possible. Without floats
    (`is_whole`) sums have partial results, too.
    """
    kinds = (*KINDS, "partial results") if is_whole else KINDS
    tidied = tidy(function)
    state = State(tidied, expected_trips(tidied, {}))
    names = []
    for _ in range(4):
        headers = sorted(loop.header for loop in find_loops(state.function))
        if not headers or sum(len(b.instrs) for b in state.function.blocks) > MOST_INSTRUCTIONS:
            break
        kind = random.choice(kinds)
        factor = random.choice([2, 4]) if kind in WITH_FACTOR else 0
        candidate = Candidate(kind, random.choice(headers), factor)
        done = apply(state, candidate, expected_trips(state.function, state.hints))
        if not isinstance(done, Refusal):
            state = done
            names.append(f"{kind} {candidate.header} {factor}")
    return "; ".join(names), state.function


def asked(source: str, seed: int) -> LoopOptions:
    """Random options for the loops of a kernel."""
    random = Random(seed)
    if random.random() < 0.4:
        return LoopOptions(random.choice([True, False]))
    lines = [n for n, line in enumerate(source.splitlines(), 1) if line.lstrip().startswith("for ")]
    if not lines:
        return LoopOptions(auto=False)
    line = random.choice(lines)
    choices: list[dict[str, Any]] = [
        {"unroll": {line: random.choice([2, 4])}},
        {"jam": {line: 2}},
        {"flatten": {line: True}},
    ]
    return LoopOptions(random.choice([True, False]), **random.choice(choices))
