"""What binds a result in words: a recurrence through memory is told as assumed unless proved."""

from __future__ import annotations

from dataclasses import replace

import pytest
from graphs import GraphBuilder

from vividc import arch
from vividc.dfg.ir import DFG, Edge, EdgeKind
from vividc.errors import SourceLoc
from vividc.machine.opcodes import ORDER, Opcode
from vividc.mapper import map_dfg
from vividc.mapper.report.explain import explain
from vividc.program import BoundReport, RegionReport

MEET = "if accesses that could not be proved apart meet"


def recurrence(*assumed: bool) -> DFG:
    """A store of what was loaded, for which the next iteration's load waits, once for each
    `assumed`.
    """
    graph = GraphBuilder("loop")
    iv = graph.source(Opcode.IV)
    load = graph.load("x", iv)
    store = graph.store("x", iv, graph.op(Opcode.FMUL, load, load))
    graph.mark(load, loc=SourceLoc("rev.py", 4))
    graph.mark(store, loc=SourceLoc("rev.py", 5))
    dfg = graph.build()
    edges = (Edge(store, load, ORDER, 1, kind=EdgeKind.ORDER, assumed=a) for a in assumed)
    return replace(dfg, edges=(*dfg.edges, *edges))


@pytest.mark.parametrize(
    ("edges", "is_assumed"),
    [((True,), True), ((False,), False), ((True, False), False), ((False, True), False)],
)
def test_a_recurrence_that_was_assumed_is_told_as_one(
    edges: tuple[bool, ...], is_assumed: bool
) -> None:
    result = map_dfg(recurrence(*edges), arch.load("vivid-tile"))
    text = explain(result)
    assert result.bounds[0].name == "RecMII"
    assert ("assumed: accesses at rev.py:4 and rev.py:5 may meet" in text) == is_assumed
    assert (MEET in text.splitlines()[0]) == is_assumed
    bounds = tuple(BoundReport(b.name, b.ii, b.reason) for b in result.bounds)
    ii = result.ii
    assert ii is not None
    report = RegionReport("loop1", "loop", ii, ii, ii, "optimal", 0.1, 3, 9, 2, bounds=bounds)
    assert report.rests_on_assumed == is_assumed
    assert (MEET in report.explain()) == is_assumed
