"""Attempts side by side: which result counts, and that what runs there is compiled before."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from tests.mapper.random_graphs import random_loop
from vividc import arch
from vividc.arch.fabric import Fabric
from vividc.mapper.bounds.bounds import all_bounds, mii
from vividc.mapper.check.verify import verify
from vividc.mapper.deadline import Deadline
from vividc.mapper.engines.negotiate import Effort, negotiate, prepare
from vividc.mapper.engines.negotiate.lockstep import Steps, every_result, first_result
from vividc.mapper.mapping import Mapping
from vividc.mapper.problem import MapProblem

EFFORT = Effort(moves=1500, rounds=20, repairs=60, trials=2)


def attempt(steps: int, value: str | None, pause_s: float = 0.0) -> Steps[str | None]:
    for _ in range(steps):
        time.sleep(pause_s)
        yield 1.0
    return value


def test_the_fewest_steps_count_not_the_fewest_seconds() -> None:
    assert first_result([attempt(3, "slow steps", 0.02), attempt(4, "quick steps")]) == "slow steps"


def test_of_equals_the_first_counts() -> None:
    assert first_result([attempt(3, "first", 0.01), attempt(3, "second")]) == "first"


def test_attempts_that_fail_leave_the_others_going() -> None:
    assert first_result([attempt(1, None), attempt(5, "found"), attempt(2, None)]) == "found"
    assert first_result([attempt(1, None), attempt(5, None)]) is None
    assert first_result([attempt(2, "alone")]) == "alone"


def test_every_attempt_ends_with_its_value_and_the_longest_step_is_charged() -> None:
    charged: list[float] = []

    def costs(value: str | None, *seconds: float) -> Steps[str | None]:
        yield from seconds
        return value

    for threads in (1, 2):
        charged.clear()
        going = [costs("a", 1.0, 2.0), costs(None, 3.0), costs("c", 1.0, 1.0, 4.0)]
        assert every_result(going, charged.append, threads) == ["a", None, "c"]
        assert sum(charged) == 3.0 + 2.0 + 4.0
    charged.clear()
    assert every_result([costs("a", 1.0, 2.0)], charged.append, 2) == ["a"]
    assert charged == [1.0, 2.0]


def test_what_goes_wrong_in_an_attempt_is_raised() -> None:
    def broken() -> Steps[str | None]:
        yield 1.0
        raise ValueError("of an attempt")

    with pytest.raises(ValueError, match="of an attempt"):
        first_result([attempt(5, "found"), broken()])


@pytest.mark.parametrize("left_s", [0.5, 100.0])
def test_little_effort_is_spent_as_if_steps_were_taken_in_turn(left_s: float) -> None:
    """Attempts ask for what is left before each step, by which those end that find none."""
    for threads in (1, 2):
        spent: list[float] = []

        def left(spent: list[float] = spent) -> float:
            return left_s - sum(spent)

        def lasting(name: str, steps: int, left: Callable[[], float] = left) -> Steps[str | None]:
            for number in range(steps):
                if left() <= 0.0:
                    return f"{name} after {number}"
                yield 0.02 if name == "long" else 0.01
            return f"{name} to its end"

        going = [lasting("long", 200), lasting("short", 40)]
        found = every_result(going, spent.append, threads, left)
        whole = ["long to its end", "short to its end"]
        assert found == (["long after 25", "short after 25"] if left_s == 0.5 else whole)
        assert sum(spent) == pytest.approx(min(0.5, left_s) if left_s == 0.5 else 4.0)


def test_the_first_of_a_race_is_the_one_with_the_fewest_steps_in_long_turns() -> None:
    for threads in (1, 2, 3):
        charged: list[float] = []
        going = [attempt(40, "late"), attempt(20, "first"), attempt(20, "second")]
        assert first_result(going, charged.append, threads) == "first"
        assert charged == [1.0] * 21


@pytest.mark.parametrize("name", ["openedge-3x3", "mesh-3x3"])
def test_two_sides_find_the_same_mapping_each_time(name: str) -> None:
    problem = problem_on(name)
    ii = mii(all_bounds(problem)) + 3
    found = [mapped(problem, ii, sides=2, threads=threads) for threads in (2, 1, 2)]
    assert found[0] is not None
    assert verify(problem.dfg, problem.fabric, found[0]) == []
    assert found[0] == found[1] == found[2]


@pytest.mark.parametrize("name", ["openedge-3x3", "mesh-3x3", "hycube-3x3"])
def test_nothing_is_compiled_within_a_time_limit(name: str) -> None:
    """The moves with routes were compiled in the middle of a search: 27 s of a limit of 10 s."""
    prepare()
    before = specialisations()
    problem = problem_on(name)
    bound = mii(all_bounds(problem))
    for ii in range(bound, bound + 3):
        mapped(problem, ii)
    assert specialisations() == before


def problem_on(name: str) -> MapProblem:
    fabric = arch.load(name)
    assert isinstance(fabric, Fabric)
    return MapProblem(random_loop(4, 26, (8, 2, 0)), fabric)


def mapped(problem: MapProblem, ii: int, sides: int = 1, threads: int = 1) -> Mapping | None:
    return negotiate(problem, ii, 1, Deadline.after(120), EFFORT, sides, threads).mapping


def specialisations() -> dict[str, int]:
    """Of each compiled function of negotiation that Python calls, how often it was compiled."""
    return {f"{one.__module__}.{one.__name__}": len(one.signatures) for one in entry_points()}


def entry_points() -> Iterator[Any]:
    for name in [
        name for name in sys.modules if name.startswith("vividc.mapper.engines.negotiate.")
    ]:
        for one in vars(sys.modules[name]).values():
            if hasattr(one, "signatures"):
                yield one


def test_the_longest_step_of_a_round_is_charged() -> None:
    def costs(first: float, second: float) -> Steps[str | None]:
        yield first
        yield second
        return None

    charged: list[float] = []
    first_result([costs(1.0, 2.0), costs(3.0, 1.0)], charged.append)
    assert charged == [3.0, 2.0, 0.0]
