"""Variables between regions: what constant stores must keep room for."""

from __future__ import annotations

from vividc.compiler.delivery import with_homes


def test_homes_take_room_before_they_are_written() -> None:
    held = {0: frozenset({("const", 7)}), 1: frozenset({("live_in", "%x")})}
    both = with_homes(held, {"%x": frozenset({0, 1}), "%y": frozenset({1})})
    assert both == {
        0: {("const", 7), ("live_in", "%x")},
        1: {("live_in", "%x"), ("live_in", "%y")},
    }
