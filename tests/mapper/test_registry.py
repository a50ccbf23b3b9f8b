"""Mappers by name, our own and guests'."""

from __future__ import annotations

from importlib.metadata import EntryPoint, EntryPoints

import pytest
from fabrics import grid
from graphs import chain

from vividc.errors import VividcError
from vividc.mapper import find_mapper, map_dfg, mapper_names, registry


def _install(monkeypatch: pytest.MonkeyPatch, name: str, value: str) -> None:
    point = EntryPoint(name, value, registry.ENTRY_POINT_GROUP)
    monkeypatch.setattr(registry, "entry_points", lambda **_: EntryPoints([point]))


def test_a_guest_is_found_by_its_entry_point(monkeypatch: pytest.MonkeyPatch) -> None:
    _install(monkeypatch, "guest", "vividc.mapper.portfolio:decoupled")
    ours = ("auto", "cpsat", "decoupled", "sat-kms", "ims", "spr")
    assert mapper_names() == (*ours, "guest")
    assert map_dfg(chain(2), grid(1, 2), mapper="guest", workers=1).status == "optimal"


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("no_such_package:run", "cannot be loaded"),
        ("vividc.mapper.portfolio:no_such_name", "cannot be loaded"),
        ("vividc.mapper.registry:ENTRY_POINT_GROUP", "not callable"),
    ],
)
def test_a_guest_that_does_not_load_is_a_user_error(
    monkeypatch: pytest.MonkeyPatch, value: str, message: str
) -> None:
    _install(monkeypatch, "guest", value)
    with pytest.raises(VividcError, match=message):
        find_mapper("guest")


def test_a_guest_cannot_take_over_a_built_in_name(monkeypatch: pytest.MonkeyPatch) -> None:
    _install(monkeypatch, "auto", "vividc.mapper.portfolio:decoupled")
    assert find_mapper("auto") is registry.BUILT_IN["auto"]
