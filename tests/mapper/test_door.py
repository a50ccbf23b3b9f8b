"""What a caller adds to the model: constraints, objectives, and what may still be claimed then."""

from __future__ import annotations

import json
import time
from collections.abc import Callable

import pytest
from fabrics import grid
from graphs import accumulator, blending, chain

from vividc.errors import VividcError
from vividc.mapper import (
    OBJECTIVES,
    MapResult,
    ModelHandle,
    map_dfg,
    mapping_from_json,
    mapping_to_json,
)
from vividc.mapper.engines.cpsat import measure
from vividc.mapper.problem import MapProblem

EXTENSIBLE = ("auto", "cpsat", "decoupled")


@pytest.mark.parametrize("mapper", EXTENSIBLE)
def test_a_constraint_holds_in_the_mapping(mapper: str) -> None:
    def pinned(handle: ModelHandle) -> None:
        handle.model.add(handle.on_pe(2, 3) == 1)
        handle.model.add(handle.start(4) >= handle.start(3) + 3)

    result = map_dfg(chain(4), grid(2, 2), mapper, extend=pinned, workers=1)
    assert result.mapping is not None
    places = result.mapping.places
    assert places[2].pe == 3
    assert places[4].time >= places[3].time + 3
    assert result.constrained


def test_added_constraints_limit_what_is_proved() -> None:
    def one_a_slot(handle: ModelHandle) -> None:
        for slot in range(handle.ii):
            handle.model.add(handle.in_slot(0, slot) + handle.in_slot(1, slot) <= 1)

    free = map_dfg(chain(2), grid(1, 2), workers=1)
    limited = map_dfg(chain(2), grid(1, 2), workers=1, extend=one_a_slot)
    assert (free.claim, free.ii) == ("optimal", 1)
    assert (limited.claim, limited.ii) == ("optimal within the added constraints", 2)
    assert "with the added constraints" in limited.refuted[0].by
    assert all(bound.ii == 1 for bound in limited.bounds)
    assert "within the added constraints" in limited.explain()


def test_a_contradiction_is_infeasible_within_the_added_constraints() -> None:
    def impossible(handle: ModelHandle) -> None:
        handle.model.add(handle.start(2) > handle.start(3))

    result = map_dfg(chain(2), grid(1, 2, contexts=3, max_stages=2), extend=impossible, workers=1)
    assert result.claim == "infeasible within the added constraints"


def test_schedules_as_long_as_what_is_added_asks_for() -> None:
    def late(handle: ModelHandle) -> None:
        handle.model.add(handle.start(2) >= 6)

    result = map_dfg(chain(1), grid(1, 1), extend=late, workers=1)
    assert (result.status, result.ii) == ("optimal", 1)
    assert result.mapping is not None
    assert result.mapping.places[2].time >= 6


@pytest.mark.parametrize("mapper", ["auto", "ims", "spr", "sat-kms"])
@pytest.mark.parametrize("objective", sorted(OBJECTIVES))
def test_an_objective_never_makes_it_worse(mapper: str, objective: str) -> None:
    dfg, fabric = chain(5), grid(2, 2)
    result = map_dfg(dfg, fabric, mapper, objective=objective, workers=1, time_limit_s=20)
    found = result.objective
    assert result.mapping is not None
    assert found is not None
    assert found.value is not None
    assert found.before is not None
    assert found.value <= found.before
    assert found.value == measure(MapProblem(dfg, fabric), result.mapping, objective)
    assert found.bound is None or found.bound <= found.value


def test_least_hops_registers_and_length_are_proved() -> None:
    values = {}
    for name in OBJECTIVES:
        result = map_dfg(chain(3), grid(1, 1), objective=name, workers=1)
        assert result.objective is not None
        assert result.objective.bound == result.objective.value
        values[name] = result.objective.value
    assert values == {"hops": 0, "registers": 0, "length": 3}


def test_an_added_objective_is_minimised_at_the_ii() -> None:
    def far_right(handle: ModelHandle) -> None:
        handle.minimize(-handle.on_pe(3, 3))

    result = map_dfg(accumulator(), grid(2, 2), extend=far_right, workers=1)
    assert result.mapping is not None
    assert result.objective is not None
    assert result.mapping.places[3].pe == 3
    assert (result.objective.name, result.objective.value) == ("added objective", -1)


def test_the_claim_survives_json() -> None:
    dfg, fabric = chain(2), grid(1, 2)
    result = map_dfg(dfg, fabric, extend=lambda _: None, objective="hops", workers=1)
    text = json.dumps(mapping_to_json(result, dfg, fabric))
    back: MapResult = mapping_from_json(json.loads(text), dfg, fabric)
    assert (back.constrained, back.objective) == (True, result.objective)


@pytest.mark.parametrize("mapper", ["sat-kms", "ims", "spr"])
def test_a_mapper_without_the_model_takes_no_constraints(mapper: str) -> None:
    with pytest.raises(VividcError, match="takes no constraints"):
        map_dfg(chain(2), grid(1, 2), mapper, extend=lambda _: None)


def test_an_unknown_objective_is_refused() -> None:
    with pytest.raises(VividcError, match="unknown objective"):
        map_dfg(chain(2), grid(1, 2), objective="beauty")


@pytest.mark.parametrize(
    ("use", "message"),
    [
        (lambda h: h.start(99), "start: chain2 has no placed node 99\nhint: placed nodes are 2, 3"),
        (lambda h: h.start(0), "start: chain2 has no placed node 0"),
        (lambda h: h.start("a"), "start: chain2 has no placed node 'a'"),
        (lambda h: h.on_pe(2, 77), "on_pe: grid-2x2 has no PE 77\nhint: PEs are 0 to 3"),
        (lambda h: h.in_slot(-1, 0), "in_slot: grid-2x2 has no PE -1"),
        (lambda h: h.held(4, 0), "held: grid-2x2 has no PE 4"),
        (lambda h: h.on_link(99), "on_link: the fabric has no link 99\nhint: links are 0 to 7"),
        (lambda h: h.on_link(0, 99), "on_link: chain2 has no placed node 99"),
        (lambda h: h.minimize("x"), "minimize: 'x' is not an expression\nhint: give a sum"),
        (lambda h: h.minimize(h.start(2) <= 3), "is not an expression"),
    ],
)
def test_what_does_not_exist_is_refused(use: Callable[[ModelHandle], object], message: str) -> None:
    def extend(handle: ModelHandle) -> None:
        use(handle)

    with pytest.raises(VividcError) as caught:
        map_dfg(chain(2), grid(2, 2), extend=extend, workers=1)
    assert message in str(caught.value)


def test_a_function_of_no_or_two_arguments_is_refused() -> None:
    for extend in (lambda: None, lambda _, __: None):
        with pytest.raises(VividcError, match="extend: extend cannot be called with one argument"):
            map_dfg(chain(2), grid(1, 2), extend=extend)  # type: ignore[arg-type]


def test_no_worker_is_left_after_the_time_limit() -> None:
    threads = _threads()
    map_dfg(blending(), grid(3, 3), "cpsat", time_limit_s=2, workers=2)
    assert _settles_at(threads)


def _settles_at(threads: int) -> bool:
    """Whether no more threads are left soon: the system may still count one that was joined."""
    patience = time.monotonic() + 20.0
    while _threads() > threads and time.monotonic() < patience:
        time.sleep(0.01)
    return _threads() <= threads


def _threads() -> int:
    with open("/proc/self/status", encoding="ascii") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("Threads:"))
