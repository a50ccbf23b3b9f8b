"""Straight regions scheduled while a loop before them ends: neither is in the other's way."""

from __future__ import annotations

import random
from collections.abc import Iterator

import pytest

from tests.mapper.random_graphs import random_loop, random_region
from vividc import arch
from vividc.arch.fabric import Fabric
from vividc.dfg.ir import DFG
from vividc.machine.opcodes import Opcode
from vividc.mapper import map_dfg
from vividc.mapper.bounds.straight import straight_lower_bound
from vividc.mapper.check.verify import violations
from vividc.mapper.engines.list_schedule import list_schedule
from vividc.mapper.mapping import Mapping, Step
from vividc.mapper.problem import Drain, MapProblem
from vividc.mapper.resources.drain import drain_of

Event = tuple[object, ...]


def tile() -> Fabric:
    fabric = arch.load("vivid-tile")
    assert isinstance(fabric, Fabric)
    return fabric


def span(dfg: DFG, fabric: Fabric, mapping: Mapping) -> int:
    return max(mapping.places[node.id].time + fabric.latency(node) for node in dfg.placed)


def behind(seed: int) -> tuple[DFG, Mapping, MapProblem, int]:
    """A mapped loop, the problem of a region behind it, and when that begins."""
    chance, fabric = random.Random(seed), tile()
    tried = (random_loop(number, 14) for number in range(seed * 100, seed * 100 + 100))
    loop = next(dfg for dfg in tried if all(node.control is None for node in dfg.nodes))
    mapping = map_dfg(loop, fabric, effort="fast").mapping
    assert mapping is not None
    end = span(loop, fabric, mapping)
    begin = chance.randrange(mapping.ii, end) if end > mapping.ii else mapping.ii
    left = drain_of(loop, fabric, mapping, begin, max(1, end - begin))
    region = random_region(seed, 30, memory=0.3)
    return loop, mapping, MapProblem(region, fabric, {}, {}, left), begin


def moved(route: tuple[Step, ...]) -> Iterator[Event]:
    """Links that a word is on, by cycle; registers that it is in, and when they are written."""
    before = None
    for step in route:
        yield step.kind, step.pe, step.index, step.time
        if step.kind == "reg" and before != ("reg", step.index):
            yield "write", step.pe, step.index, step.time - 1
        before = (step.kind, step.index)


def events(dfg: DFG, fabric: Fabric, mapping: Mapping) -> Iterator[Event]:
    """What no two may have, the last number being the cycle."""
    for node in dfg.placed:
        place = mapping.places[node.id]
        yield "live-out" if node.op is Opcode.LIVE_OUT else "issue", place.pe, 0, place.time
        if node.op is not Opcode.LIVE_OUT:
            yield "result", place.pe, 0, place.time + fabric.latency(node) - 1
        if node.is_memory:
            yield "memory", 0, 0, place.time
    for route in mapping.routes.values():
        yield from moved(route)


def ports(dfg: DFG, fabric: Fabric, mapping: Mapping) -> Iterator[Event]:
    """Reads of registers, each of which takes a port."""
    for route in mapping.routes.values():
        for step, after in zip(route, (*route[1:], None), strict=False):
            if step.kind == "reg" and (
                after is None or (after.kind, after.index) != ("reg", step.index)
            ):
                yield step.pe, step.index, step.time


def left_over(found: Iterator[Event], begin: int, ii: int, cycles: int) -> set[Event]:
    """Of a loop's iterations, by cycles of the region behind it."""
    every = set()
    for *what, time in found:
        assert isinstance(time, int)
        after = range(time - begin, -1, -ii)
        every |= {(*what, cycle) for cycle in after if cycle < cycles}
    return every


@pytest.mark.parametrize("seed", range(12))
def test_nothing_is_taken_twice(seed: int) -> None:
    loop, mapping, problem, begin = behind(seed)
    fabric, found = problem.fabric, list_schedule(problem)
    assert problem.drain is not None
    assert violations(problem.dfg, fabric, found, straight=True) == []
    theirs = left_over(events(loop, fabric, mapping), begin, mapping.ii, problem.drain.cycles)
    assert not theirs & set(events(problem.dfg, fabric, found))
    reads = left_over(ports(loop, fabric, mapping), begin, mapping.ii, problem.drain.cycles)
    reads |= set(ports(problem.dfg, fabric, found))
    for pe in fabric.pes:
        for cycle in range(found.ii):
            assert sum(at[0] == pe.id and at[2] == cycle for at in reads) <= pe.read_ports


@pytest.mark.parametrize("seed", range(12))
def test_what_waits_for_the_loop_comes_after_it(seed: int) -> None:
    loop, mapping, problem, begin = behind(seed)
    found = list_schedule(problem)
    left = problem.drain
    assert left is not None
    assert found.ii >= straight_lower_bound(problem).ii >= left.cycles
    theirs = {
        (cycle, node.op is Opcode.STORE)
        for node in loop.placed
        if node.is_memory
        for cycle in range(mapping.places[node.id].time - begin, -1, -mapping.ii)
    }
    for node in problem.dfg.placed:
        place = found.places[node.id]
        assert place.time >= problem.release(node, place.pe)
        if node.is_memory:
            stores = node.op is Opcode.STORE
            assert all(cycle < place.time for cycle, other in theirs if stores or other)


def test_accesses_of_other_arrays_may_pass_each_other() -> None:
    nothing = frozenset[object]()
    accesses = frozenset({(3, "a", True), (7, "b", False)})
    left = Drain(*[nothing] * 6, accesses, 9, nothing, nothing)  # type: ignore[arg-type]
    dfg = random_region(1, 30, memory=0.5)
    problem = MapProblem(dfg, tile(), drain=left)
    for node in dfg.placed:
        if node.is_memory:
            assert node.name == "a"
            assert problem.release(node, 0) == 4


def test_a_region_waits_for_entries_that_the_loop_writes() -> None:
    key = ("live_in", "%v")
    nothing = frozenset[object]()
    written = frozenset({(2, key, 6)})
    read = frozenset({(3, key, 8)})
    left = Drain(*[nothing] * 7, 9, read, written)  # type: ignore[arg-type]
    assert left.readable_from == {(2, key): 6}
    assert left.writable_from == {(2, key): 6, (3, key): 8}
