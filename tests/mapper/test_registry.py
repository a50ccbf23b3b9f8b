"""Mappers by name, our own and guests'."""

from __future__ import annotations

from dataclasses import replace
from importlib.metadata import EntryPoint, EntryPoints
from typing import cast

import pytest
from fabrics import grid
from graphs import chain

from vividc.errors import VividcError
from vividc.mapper import (
    MapProblem,
    MapRequest,
    MapResult,
    find_mapper,
    map_dfg,
    mapper_names,
    registry,
)
from vividc.mapper.mapping import Status


def _install(monkeypatch: pytest.MonkeyPatch, name: str, value: str) -> None:
    point = EntryPoint(name, value, registry.ENTRY_POINT_GROUP)
    monkeypatch.setattr(registry, "entry_points", lambda **_: EntryPoints([point]))


def test_a_guest_is_found_by_its_entry_point(monkeypatch: pytest.MonkeyPatch) -> None:
    _install(monkeypatch, "guest", "vividc.mapper.search.portfolio:decoupled")
    ours = ("auto", "cpsat", "decoupled", "sat-kms", "ims", "spr")
    assert mapper_names() == (*ours, "guest")
    assert map_dfg(chain(2), grid(1, 2), mapper="guest", workers=1).status == "optimal"


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("no_such_package:run", "cannot be loaded"),
        ("vividc.mapper.search.portfolio:no_such_name", "cannot be loaded"),
        ("vividc.mapper.registry:ENTRY_POINT_GROUP", "not callable"),
    ],
)
def test_a_guest_that_does_not_load_is_a_user_error(
    monkeypatch: pytest.MonkeyPatch, value: str, message: str
) -> None:
    _install(monkeypatch, "guest", value)
    with pytest.raises(VividcError, match=message):
        find_mapper("guest")


def _raises(problem: MapProblem, request: MapRequest) -> MapResult:
    raise ZeroDivisionError("of the guest")


def _nothing(problem: MapProblem, request: MapRequest) -> MapResult:
    return cast(MapResult, None)


def _careless(problem: MapProblem, request: MapRequest) -> MapResult:
    result = registry.BUILT_IN["auto"](problem, request)
    assert result.mapping is not None
    return replace(result, mapping=replace(result.mapping, routes={}))


def _boasts(problem: MapProblem, request: MapRequest) -> MapResult:
    result = registry.BUILT_IN["auto"](problem, request)
    assert result.mapping is not None
    return replace(result, lower_bound=7, ii=7)


def _great(problem: MapProblem, request: MapRequest) -> MapResult:
    return MapResult(cast(Status, "great"), None, 1, (), None, "guest", 0.1)


def _impossible(problem: MapProblem, request: MapRequest) -> MapResult:
    return MapResult("infeasible", None, 1, (), None, "guest", 0.1)


@pytest.mark.parametrize(
    ("guest", "fault"),
    [
        ("_raises", "failed with ZeroDivisionError: of the guest"),
        ("_nothing", "returned a NoneType instead of a MapResult"),
        ("_boasts", "makes false claims: the mapping has II 1, the result says 7"),
        ("_great", "makes false claims: there is no status 'great'"),
        ("_impossible", "makes false claims: infeasible is claimed, but no II is refuted"),
        ("_careless", "made an illegal mapping of 'chain3': "),
    ],
)
def test_what_a_guest_does_wrong_is_its_own_fault(
    guest: str, fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    _install(monkeypatch, "guest", f"{__name__}:{guest}")
    with pytest.raises(VividcError, match=f"mapper 'guest' {fault}") as told:
        map_dfg(chain(3), grid(2, 2), mapper="guest", workers=1)
    assert "bug of vividc" not in str(told.value)


def test_a_guest_cannot_take_over_a_built_in_name(monkeypatch: pytest.MonkeyPatch) -> None:
    _install(monkeypatch, "auto", "vividc.mapper.search.portfolio:decoupled")
    assert find_mapper("auto") is registry.BUILT_IN["auto"]
