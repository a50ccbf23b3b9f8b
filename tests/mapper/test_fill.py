"""Loops that begin while a straight region ends: neither is in the other's way."""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import replace

import pytest

from tests.mapper.random_graphs import random_loop, random_region
from tests.mapper.test_drain import Event, events, ports, tile
from vividc.dfg.ir import DFG
from vividc.errors import MappingFailed
from vividc.machine.opcodes import Opcode
from vividc.mapper import map_dfg
from vividc.mapper.bounds.straight import straight_lower_bound
from vividc.mapper.check.verify import violations
from vividc.mapper.engines.list_schedule import list_schedule
from vividc.mapper.mapping import Mapping
from vividc.mapper.problem import Fill, MapProblem
from vividc.mapper.resources.fill import fill_of, first_begin

_MORE, _FIT = 40, 8


def around(seed: int) -> tuple[DFG, Mapping, MapProblem, Mapping]:
    """A mapped loop, and a region before it with its schedule; a fourth of the regions branches."""
    tried = (random_loop(number, 14) for number in range(seed * 100, seed * 100 + 100))
    loop = next(dfg for dfg in tried if all(node.control is None for node in dfg.nodes))
    mapping = map_dfg(loop, tile(), effort="fast").mapping
    assert mapping is not None
    region = random_region(seed, 40, memory=0.2 * (seed % 2))
    nodes = tuple(replace(n, control=None) if seed % 4 else n for n in region.nodes)
    problem = MapProblem(DFG(region.name, nodes, region.edges), tile())
    return loop, mapping, problem, list_schedule(problem)


def begun(found: Iterator[Event], begin: int, ii: int, length: int) -> set[Event]:
    """Of a loop's iterations, by cycles of the region before it."""
    every = set()
    for *what, time in found:
        assert isinstance(time, int)
        every |= {(*what, cycle) for cycle in range(begin + time, length, ii)}
    return every


def demand_apart(
    loop: DFG, mapping: Mapping, problem: MapProblem, found: Mapping, begin: int
) -> None:
    """Whatever a loop takes that begins in a cycle, the region does not."""
    fabric, length, ii = problem.fabric, found.ii, mapping.ii
    own = set(events(problem.dfg, fabric, found))
    theirs = begun(events(loop, fabric, mapping), begin, ii, length)
    assert not theirs & {event for event in own if event[0] != "reg"}
    reads = begun(ports(loop, fabric, mapping), begin, ii, length)
    reads |= set(ports(problem.dfg, fabric, found))
    for pe in fabric.pes:
        for cycle in range(length):
            assert sum(at[0] == pe.id and at[2] == cycle for at in reads) <= pe.read_ports
    firsts: dict[tuple[object, ...], int] = {}
    for kind, *place, cycle in theirs:
        assert isinstance(cycle, int)
        if kind == "write":
            firsts[tuple(place)] = min(firsts.get(tuple(place), cycle), cycle)
    for kind, *place, cycle in own:
        assert isinstance(cycle, int)
        first = firsts.get(tuple(place), length)
        assert kind != "reg" or cycle <= first
        assert kind != "write" or cycle < first


@pytest.mark.parametrize("seed", range(16))
def test_nothing_is_taken_twice(seed: int) -> None:
    loop, mapping, problem, found = around(seed)
    fill = fill_of(loop, problem.fabric, mapping, found.ii)
    begin = first_begin(fill, problem, found)
    if begin is not None:
        demand_apart(loop, mapping, problem, found, begin)
    least = random.Random(seed).randrange(found.ii)
    later = first_begin(fill, problem, found, least)
    assert later is None or later >= max(least, begin or 0)


def test_schedules_leave_what_the_loop_takes() -> None:
    """Where there is room for both."""
    fits = sum(leaves_what_the_loop_takes(seed) for seed in range(16))
    assert fits >= _FIT


def leaves_what_the_loop_takes(seed: int) -> bool:
    loop, mapping, problem, alone = around(seed)
    fabric, begin = problem.fabric, max(1, alone.ii - 4)
    there = fill_of(loop, fabric, mapping, _MORE, begin, 4)
    try:
        found = list_schedule(replace(problem, fill=there))
    except MappingFailed:
        return False
    assert violations(problem.dfg, fabric, found, straight=True) == []
    bound = straight_lower_bound(replace(problem, fill=there)).ii
    assert bound >= straight_lower_bound(problem).ii
    assert found.ii >= straight_lower_bound(problem).ii
    fill = fill_of(loop, fabric, mapping, found.ii)
    fits = first_begin(fill, problem, found, begin) == begin
    if fits:
        demand_apart(loop, mapping, problem, found, begin)
        for node in (node for node in problem.dfg.placed if node.control is not None):
            acts = found.places[node.id].time + fabric.latency(node)
            assert acts + fabric.controller.control_latency <= begin
    return fits


def test_accesses_come_before_those_of_the_loop_that_they_may_meet() -> None:
    nothing = frozenset[object]()
    accesses = frozenset({(13, "a", True), (17, "b", False)})
    fill = Fill(*[nothing] * 6, accesses, 9, {}, {}, begin=10, expected=20)  # type: ignore[arg-type]
    problem = MapProblem(random_region(1, 30, memory=0.5), tile(), fill=fill)
    for node in problem.dfg.placed:
        if node.is_memory and node.control is None:
            assert node.name == "a"
            assert problem.tail(node) == 20 - 3 + 1


def test_what_the_loop_reads_is_written_before() -> None:
    problem = MapProblem(random_region(3, 30, memory=0.0), tile())
    out = next(node for node in problem.dfg.placed if node.op is Opcode.LIVE_OUT)
    key, nothing = ("live_in", out.name), frozenset[object]()
    read = {(2, key): 5, (3, key): 4}
    fill = Fill(*[nothing] * 7, 9, read, {}, begin=10, expected=20)  # type: ignore[arg-type]
    allowed = {out.id: frozenset({2})}
    assert replace(problem, fill=fill, allowed=allowed).tail(out) == 20 - 5 + 1
    assert replace(problem, fill=fill).tail(out) == 20 - 4 + 1
    assert problem.tail(out) == 0
