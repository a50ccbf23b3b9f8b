"""From a graph to a mapping: attempts at an II, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from vividc.errors import InternalError
from vividc.mapper.check.verify import violations
from vividc.mapper.deadline import Deadline
from vividc.mapper.engines.negotiate import tuning
from vividc.mapper.engines.negotiate.frame import Frame, loose_frame
from vividc.mapper.engines.negotiate.lockstep import every_result, first_result
from vividc.mapper.engines.negotiate.negotiation import Negotiation
from vividc.mapper.engines.negotiate.tuning import Effort
from vividc.mapper.mapping import Mapping
from vividc.mapper.problem import MapProblem


@dataclass(frozen=True, slots=True)
class Negotiated:
    """A mapping, if one was found; `is_far`: more effort at this II is not expected to find one."""

    mapping: Mapping | None = None
    is_far: bool = False


def negotiate(
    problem: MapProblem,
    ii: int,
    seed: int,
    deadline: Deadline,
    effort: Effort | None = None,
    sides: int = 1,
    threads: int = 1,
    *,
    frame: Frame | None = None,
) -> Negotiated:
    """A mapping at `ii` in the `frame`, without one in a loose one; or none, which refutes nothing.
    Trials are shared out among so many `sides`, each with a seed of its own, that go on in step.
    Deterministic for a seed and so many sides; threads only make it faster.
    """
    effort = effort or Effort()
    frame = loose_frame(problem, ii) if frame is None else frame
    share = replace(effort, trials=-(-effort.trials // sides))
    seeds = range(seed, seed + tuning.SEED_STEP * sides, tuning.SEED_STEP)
    tries = [Try(problem, ii, one, share, frame) for one in seeds]
    attempts = [attempt for one in tries if (attempt := _begun(one)) is not None]
    deadline.charge(tuning.BEGIN_S)
    if not attempts:
        return Negotiated()
    going = [attempt.run(share, deadline) for attempt in attempts]
    mapping = first_result(going, deadline.charge, threads, lambda: deadline.remaining_s)
    if mapping is None:
        return Negotiated(is_far=all(attempt.is_far for attempt in attempts))
    return Negotiated(_checked(mapping, problem))


@dataclass(frozen=True, slots=True)
class Try:
    """A mapping that is looked for: see `negotiate`. Without a frame there is none."""

    problem: MapProblem
    ii: int
    seed: int
    effort: Effort
    frame: Frame | None


def negotiate_each(tries: Sequence[Try], deadline: Deadline, threads: int) -> list[Mapping | None]:
    """The mapping of each try, or None, which the caller verifies; they go on in step, as the sides
    of one do.
    """
    if any(one.frame for one in tries):
        deadline.charge(tuning.BEGIN_S)
    begun = [_begun(one) for one in tries]
    going = [
        attempt.run(one.effort, deadline)
        for one, attempt in zip(tries, begun, strict=True)
        if attempt is not None
    ]
    found = iter(every_result(going, deadline.charge, threads, lambda: deadline.remaining_s))
    return [None if attempt is None else next(found) for attempt in begun]


def _begun(one: Try) -> Negotiation | None:
    """A try that can begin; None: nothing is to be found."""
    problem, frame, nodes = one.problem, one.frame, one.problem.dfg.placed
    if frame is None or not nodes or not all(problem.candidates(node) for node in nodes):
        return None
    attempt = Negotiation(problem, one.ii, frame, one.seed)
    return attempt if attempt.fits else None


def annealing_s(problem: MapProblem, effort: Effort) -> float:
    """Effort that annealing a graph's places once takes at least, in seconds."""
    moves = effort.moves * len(problem.dfg.placed)
    if problem.fabric.routing.moves:
        return effort.shown * moves * tuning.SHOWN_MOVE_S
    return moves * tuning.MOVE_S


def _checked(mapping: Mapping, task: MapProblem) -> Mapping:
    faults = violations(
        task.dfg, task.fabric, mapping, allowed=task.allowed, resident=task.resident
    )
    if faults:
        raise InternalError(f"negotiated mapping of {task.dfg.name}: {faults[0].message}")
    return mapping
