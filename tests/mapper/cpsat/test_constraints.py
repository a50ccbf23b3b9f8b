"""Each constraint family decides some problem: without it there is a solution, with it none."""

from __future__ import annotations

from dataclasses import replace

import pytest
from fabrics import grid
from graphs import GraphBuilder
from random_graphs import random_loop
from test_drop_one_options import OPTION_FAMILIES

from vividc.arch.fabric import Fabric, Scratchpad
from vividc.dfg.ir import DFG, Control
from vividc.machine.opcodes import LatencyClass, Opcode
from vividc.mapper.deadline import Deadline
from vividc.mapper.engines.cpsat import (
    CONSTRAINT_FAMILIES,
    Prepared,
    Search,
    Window,
    build,
    folded,
    windowed,
)
from vividc.mapper.engines.cpsat.run import Verdict, run
from vividc.mapper.problem import MapProblem

SLOW_MUL = {LatencyClass.IMUL: 2, LatencyClass.LOAD: 2}
FABRICS: dict[str, Fabric] = {
    "one PE": grid(1, 1, registers=3, max_stages=3),
    "pair": grid(1, 2, max_stages=3),
    "one read port": grid(1, 2, registers=3, write_ports=2, max_stages=3),
    "one write port": grid(1, 2, registers=3, read_ports=2, max_stages=3),
    "slow multiply": grid(1, 3, registers=1, latencies=SLOW_MUL, max_stages=3),
    "two constants": grid(1, 3, constants=2, max_stages=3),
}
DECIDED_BY = [
    ("each_node_starts_once", "slow multiply", 1, 4, 1),
    ("one_issue_per_fu_and_slot", "slow multiply", 21, 4, 2),
    ("one_completion_per_fu_and_slot", "slow multiply", 16, 4, 2),
    ("links_are_driven", "slow multiply", 16, 4, 2),
    ("registers_are_written", "one PE", 10, 3, 3),
    ("registers_keep_words", "one write port", 16, 4, 2),
    ("registers_last_one_ii", "one PE", 10, 3, 3),
    ("reads_find_the_word", "one PE", 10, 3, 3),
    ("operands_arrive", "one PE", 8, 6, 5),
    ("one_word_per_link_and_slot", "pair", 16, 4, 2),
    ("reads_fit_ports", "one PE", 10, 3, 3),
    ("writes_fit_ports", "one write port", 16, 4, 2),
    ("constants_fit_store", "two constants", 20, 3, 3),
    ("one_live_out_per_pe_and_slot", "pair", 36, 4, 1),
    ("edges_without_a_word_are_ordered", "two constants", 20, 3, 3),
]


def _verdict(problem: Prepared, *dropped: str) -> Verdict:
    search = Search(Deadline.after(30), workers=1, light=True)
    return run(build(problem, dropped).model, search, lambda _: None).verdict


@pytest.mark.parametrize(("family", "fabric", "seed", "size", "ii"), DECIDED_BY)
def test_the_family_refutes_a_problem_that_the_others_allow(
    family: str, fabric: str, seed: int, size: int, ii: int
) -> None:
    task = MapProblem(random_loop(seed, size), FABRICS[fabric])
    problem = windowed(task, ii, 2 * ii)
    assert _verdict(problem) == "refuted"
    assert _verdict(problem, family) == "found"


def _two_words_meet() -> DFG:
    g = GraphBuilder("meet")
    g.op(Opcode.ADD, g.op(Opcode.ADD), g.op(Opcode.ADD))
    return g.build()


@pytest.mark.parametrize(("registers", "verdict"), [(1, "refuted"), (2, "found")])
def test_two_words_at_a_time_need_two_registers(registers: int, verdict: str) -> None:
    fabric = grid(1, 1, registers=registers, read_ports=2, write_ports=2)
    windows = {0: Window(0, 0), 1: Window(1, 1), 2: Window(3, 3)}
    problem = Prepared(MapProblem(_two_words_meet(), fabric), 8, windows)
    assert _verdict(problem) == verdict
    assert _verdict(problem, "words_fit_registers") == "found"


@pytest.mark.parametrize(("ii", "verdict"), [(1, "refuted"), (2, "found")])
def test_control_results_take_turns(ii: int, verdict: str) -> None:
    g = GraphBuilder("exits")
    for _ in range(2):
        g.mark(g.op(Opcode.ICMP_EQ), control=Control.EXIT)
    problem = windowed(MapProblem(g.build(), grid(1, 2)), ii, 2)
    assert _verdict(problem) == verdict
    assert _verdict(problem, "one_control_result_per_slot") == "found"


@pytest.mark.parametrize(("ii", "verdict"), [(1, "refuted"), (2, "found")])
def test_accesses_of_a_slot_fit_the_banks(ii: int, verdict: str) -> None:
    fabric = replace(grid(2, 2), scratchpad=Scratchpad(1024, banks=2))
    g = GraphBuilder("loads")
    for _ in range(3):
        g.op(Opcode.LOAD, name="a")
    problem = windowed(MapProblem(g.build(), fabric), ii, 2)
    assert _verdict(problem) == verdict
    assert _verdict(problem, "accesses_fit_banks") == "found"


@pytest.mark.parametrize(("cols", "verdict"), [(1, "refuted"), (2, "found")])
def test_a_live_out_leaves_the_old_word_to_its_readers(cols: int, verdict: str) -> None:
    g = GraphBuilder("variable")
    value = g.op(Opcode.ADD, g.source(Opcode.LIVE_IN, name="%x"))
    g.op(Opcode.LIVE_OUT, value, name="%x")
    problem = windowed(MapProblem(g.build(), grid(1, cols)), 4, 4)
    assert _verdict(problem) == verdict
    assert _verdict(problem, "live_outs_spare_words_still_read") == "found"


@pytest.mark.parametrize(("ii", "verdict"), [(1, "refuted"), (2, "found")])
def test_the_cyclic_problem_needs_routed_edges_ordered(ii: int, verdict: str) -> None:
    g = GraphBuilder("ring")
    a, b = g.op(Opcode.ADD), g.op(Opcode.ADD)
    g.carry(a, b, 0, 0, distance=0)
    g.carry(b, a, 0, 0)
    problem = folded(MapProblem(g.build(), grid(1, 2)), ii)
    assert _verdict(problem) == verdict
    assert _verdict(problem, "routed_edges_are_ordered") == "found"


def test_every_family_is_tested() -> None:
    by_hand = {
        "words_fit_registers",
        "one_control_result_per_slot",
        "accesses_fit_banks",
        "live_outs_spare_words_still_read",
        "routed_edges_are_ordered",
    }
    tested = by_hand | {family for family, *_ in DECIDED_BY} | {*OPTION_FAMILIES}
    assert tested == {family.__name__ for family in CONSTRAINT_FAMILIES}


def test_two_builds_give_the_same_model() -> None:
    problem = windowed(MapProblem(random_loop(3, 6), FABRICS["pair"]), 4, 4)
    texts = [str(build(replace(problem)).model.proto) for _ in range(2)]
    assert texts[0] == texts[1]
