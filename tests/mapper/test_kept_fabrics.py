"""Results are kept by fabric, and go with it."""

from __future__ import annotations

import gc
import weakref

import pytest
from random_graphs import random_loop

from vividc.arch import load
from vividc.arch.fabric import Fabric
from vividc.host.once import once_each
from vividc.mapper import map_dfg


@pytest.mark.parametrize("name", ["mesh-5x5", "adres-4x4", "openedge-4x4"])
def test_mapping_keeps_no_fabric(name: str) -> None:
    fabric = load(name)
    alive = weakref.ref(fabric)
    map_dfg(random_loop(1, 12), fabric, time_limit_s=5, workers=1)
    del fabric
    gc.collect()
    assert alive() is None


def test_computed_once_for_each_fabric_and_let_go_with_it() -> None:
    asked: list[str] = []

    @once_each
    def described(fabric: Fabric) -> list[str]:
        """What it says."""
        asked.append(fabric.name)
        return [fabric.name]

    for _ in range(20):
        small, large = load("mesh-2x2"), load("mesh-3x3")
        assert described(small) is described(small)
        assert described(large) == ["mesh-3x3"]
        assert described(small) == ["mesh-2x2"]
        del small, large
        gc.collect(1)  # they are young, and a test run's heap is large
    assert asked == ["mesh-2x2", "mesh-3x3"] * 20
    assert described.__doc__ == "What it says."
