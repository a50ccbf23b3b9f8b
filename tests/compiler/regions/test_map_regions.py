"""Regions are mapped in an order, and what the first ones take must leave room for the last."""

from __future__ import annotations

from collections.abc import Callable
from collections.abc import Mapping as ReadOnly
from dataclasses import replace

import numpy as np
import pytest

import vividc
from vividc import arch
from vividc.arch.fabric import Fabric
from vividc.compiler.driver import lower
from vividc.compiler.regions import one_straight
from vividc.compiler.regions.earlier import Earlier
from vividc.compiler.regions.map_regions import MapOptions, map_kernel
from vividc.dfg.regions import Kernel
from vividc.errors import MappingFailed
from vividc.mapper import all_bounds, mii
from vividc.mapper.engines.list_schedule import list_schedule
from vividc.mapper.mapping import Mapping
from vividc.mapper.problem import MapProblem
from vividc.mapper.resources.banks import Meets


@vividc.kernel("void(float32[:, ::1])")
def sums(a):
    """Each row's sum, in its first element."""
    for i in range(a.shape[0]):
        total = np.float32(0.0)
        for j in range(a.shape[1]):
            total += a[i, j]
        a[i, 0] = total


def test_straight_regions_that_leave_no_room_are_scheduled_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """All of them, not only the one that found no room: those before it took it."""
    tried: list[tuple[str, bool]] = []

    def crowded(
        problem: MapProblem, goes_on: Callable[[], bool], *, frugal: bool, meets: Meets
    ) -> Mapping:
        tried.append((problem.dfg.name, frugal))
        if not frugal and len(tried) > 1:
            raise MappingFailed("no constant store has room")
        return list_schedule(problem, goes_on, frugal=frugal, meets=meets)

    monkeypatch.setattr(one_straight, "list_schedule", crowded)
    program = vividc.compile(sums, loops=vividc.LoopOptions(auto=False))
    frugal = [is_frugal for _, is_frugal in tried]
    assert frugal == sorted(frugal)
    first = frugal.index(True)
    assert first > 1
    assert [name for name, _ in tried[first : first + 2]] == [name for name, _ in tried[:2]]
    a = np.arange(12, dtype=np.float32).reshape(3, 4)
    vividc.simulate(program, a)
    assert a[:, 0].tolist() == [6.0, 22.0, 38.0]


def test_straight_regions_that_were_crowded_are_scheduled_frugally_at_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """In the next kernel that has them, as in another stage of a plan."""
    tried: list[bool] = []

    def crowded(
        problem: MapProblem, goes_on: Callable[[], bool], *, frugal: bool, meets: Meets
    ) -> Mapping:
        tried.append(frugal)
        if not frugal:
            raise MappingFailed("no constant store has room")
        return list_schedule(problem, goes_on, frugal=frugal, meets=meets)

    monkeypatch.setattr(one_straight, "list_schedule", crowded)
    kernel, fabric, earlier = lower(sums), machine(32), Earlier()
    first = map_kernel(kernel, fabric, MapOptions(), earlier)
    assert tried[:2] == [False, True]
    assert len(earlier.crowded) == 1
    assert not earlier.hopeless
    tried.clear()
    earlier.straight.clear()
    second = map_kernel(kernel, fabric, MapOptions(), earlier)
    assert tried
    assert all(tried)
    assert isinstance(first, tuple)
    assert isinstance(second, tuple)
    assert [r.ii for r in first[1].values()] == [r.ii for r in second[1].values()]


@vividc.kernel("void(float32[::1], float32[::1], float32[:, ::1], float32, float32)")
def small_before_large(x, y, a, p, q):
    for i in range(len(x)):
        x[i] = x[i] * p + q
    for j in range(a.shape[1]):
        y[j] = a[0, j] + a[1, j] + a[2, j] + a[3, j] + a[4, j] + a[5, j] + a[6, j] + a[7, j]


def machine(constants: int) -> Fabric:
    """A tile whose stores have so many entries."""
    tile = arch.load("vivid-tile")
    assert isinstance(tile, Fabric)
    return replace(tile, pes=tuple(replace(pe, constants=constants) for pe in tile.pes))


def loops_of(kernel: Kernel) -> list[int]:
    return [index for index, region in enumerate(kernel.regions) if region.kind == "loop"]


@pytest.mark.parametrize(("constants", "largest_first"), [(32, False), (6, True)])
def test_the_largest_loop_comes_first_where_entries_are_scarce(
    constants: int, largest_first: bool
) -> None:
    kernel, fabric, told = lower(small_before_large), machine(constants), []
    made = map_kernel(kernel, fabric, MapOptions(progress=told.append))
    assert isinstance(made, tuple)
    small, large = (kernel.regions[index] for index in loops_of(kernel))
    assert len(small.dfg.placed) < len(large.dfg.placed)
    begun = list(dict.fromkeys(line.split(":")[0] for line in told))
    order = [name for name in begun if name in (small.name, large.name)]
    assert order == ([large.name, small.name] if largest_first else [small.name, large.name])
    assert list(made[1])[:2] == loops_of(kernel)
    if largest_first:  # nothing that another loop holds has raised its bound
        alone = mii(all_bounds(MapProblem(large.dfg, fabric)))
        assert made[1][loops_of(kernel)[1]].lower_bound == alone


def test_a_kernel_that_has_lost_with_its_first_loop_maps_no_other() -> None:
    kernel, fabric, told = lower(small_before_large), machine(32), []
    asked: list[dict[int, tuple[int, int]]] = []

    def is_lost(known: ReadOnly[int, tuple[int, int]]) -> bool:
        asked.append(dict(known))
        return True

    options = MapOptions(progress=told.append)
    assert map_kernel(kernel, fabric, options, is_lost=is_lost) is None
    small, large = loops_of(kernel)
    (known,) = asked
    assert sorted(known) == [small, large]
    assert known[large][0] == mii(all_bounds(MapProblem(kernel.regions[large].dfg, fabric)))
    assert {line.split(":")[0] for line in told} == {kernel.regions[small].name}
