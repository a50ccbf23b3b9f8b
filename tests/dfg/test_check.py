"""Every invariant is reported when it is broken, and a legal graph has nothing to report."""

from __future__ import annotations

import pytest
from hypothesis import given, settings

from tests.strategies import dfgs, foreign_dfgs
from vividc.dfg.check import check
from vividc.dfg.forms.text import parse
from vividc.dfg.ir import DFG, Edge, EdgeKind, Node
from vividc.machine.opcodes import ORDER, Opcode


@settings(max_examples=60)
@given(dfg=dfgs())
def test_executable_graphs_are_legal(dfg: DFG) -> None:
    assert check(dfg) == []


@settings(max_examples=30)
@given(dfg=foreign_dfgs())
def test_foreign_graphs_are_legal(dfg: DFG) -> None:
    assert check(dfg) == []


HEAD = """%0 = iv
%1 = const 0x00000001
%2 = live_in "&x"
%3 = add %0, %1
%4 = icmp.slt %0, %1
%5 = fadd %1, %1
"""


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("%1 = iv", "2 nodes have id 1"),
        ("%6 = mov %99", "its src 99 is no node"),
        ("%6 = add %6@1(init=%88), %1", "its init 88 is no node"),
        ("%6 = live_out %3", "(live_out) has no name"),
        ("%6 = mov %1 shift 2", "only memory operations have shift and offset"),
        ('%6 = load "x" %0 shift 32 base %2', "shift 32 is not in 0 .. 31"),
        ('%6 = load "x" %0 width 3 base %2', "an access of 3 bytes"),
        ('%6 = load "x" %0 signed base %2', "only a load of less than a word is signed"),
        ('%6 = store "x" %0, %1 width 2 signed base %2', "only a load of less than a word"),
        ("%6 = mov %1 width 1", "only memory operations have a width"),
        ("%6 = const 0x100000000", "is not a 32-bit word"),
        ("%6 = mov %0, %1", "mov has no port 1"),
        ("%6 = mov %0 base %2", "mov has no port 4"),
        ('%6 = live_out "%v" %3 if %4', "live_out has no port 3"),
        ("%6 = add %0, 0: %1, %1", "2 edges feed port 0"),
        ("%6 = add %0", "(add): nothing feeds port 1"),
        ('%6 = store "x" %0, %1', "nothing feeds its base port"),
        ("%6 = fadd %4, %1", "pred read as f32"),
        ("%6 = select %5, %1, %1", "f32 read as pred"),
        ("%6 = mov %7", "live_out 7 has no result"),
        ("%6 = add %0, %3@-1", "distance -1 is negative"),
        ("%6 = mov %3@0(init=%1)", "only a data edge of distance 1 or more has an init"),
        ("%6 = mov %3@1(init=%0)", "its init 0 is neither a constant nor a live-in"),
        ("%6 = mov %0@1(init=%1)", "keeps no iv"),
        ("%6 = add %6, %0", "a cycle of distance 0 holds back nodes 6"),
        ("%6 = iv %3", "iv has no port 0"),
        ("%6 = iv after %8", "iv has no input"),
        ("%6 = mov %3 after %0", "iv happens at no time"),
        ('%6 = live_out "%w" %1', "a live-out reads an operation, not const"),
        ('%6 = load "x" %0 base %3', "a base address is a constant or a live-in"),
        ('%6 = live_out "%v" %4', "2 different words are written to %v"),
        ("%6 = mov %4 exit\n%9 = mov %4 exit", "nodes 6, 9 are all marked exit"),
        ("%6 = mov %3 trip\n%9 = mov %3 trip", "nodes 6, 9 are all marked trip"),
        ("%6 = iv branch", "has no result to mark branch"),
        ("%6 = fabs %5 trip", "is marked trip, but is a float"),
        ("%6 = mov %4 exit\n%9 = mov %4 trip", "is a loop: it has no branch or trip node"),
        ("%6 = mov %3 unless_exit", "only memory and live-outs are unless_exit"),
        ('%6 = store "x" %0, %1 base %2 control %4', "a control edge leaves the exit node"),
        ("%6 = mov %4 exit\n%9 = mov %3 control %6", "enters a store or live-out"),
    ],
)
def test_a_broken_invariant_is_named(line: str, problem: str) -> None:
    legal = f'dfg "d"\n{HEAD}%7 = live_out "%v" %3\n%8 = store "x" %0, %1 shift 2 base %2\n'
    assert check(parse(legal)) == []
    assert any(problem in found for found in check(parse(legal + line))), check(parse(legal + line))


def test_an_order_edge_counts_in_a_cycle() -> None:
    text = """dfg "d"
%0 = iv
%1 = const 0x00000000
%2 = load "x" %0 shift 2 base %1 after %3
%3 = store "x" %0, %2 shift 2 base %1
"""
    (problem,) = check(parse(text))
    assert problem.startswith("a cycle of distance 0 holds back nodes 3 (store) -> 2 (load) -> 3")


def test_order_edges_have_no_operand_port() -> None:
    nodes = (Node(0, Opcode.GENERIC, name="a"), Node(1, Opcode.GENERIC, name="b"))
    dfg = DFG("d", nodes, (Edge(0, 1, 0, kind=EdgeKind.ORDER),))
    assert check(dfg) == [f"edge 0 -> 1 (port 0, distance 0): the port of order edges is {ORDER}"]


def test_all_problems_are_listed() -> None:
    problems = check(parse('dfg "d"\n%0 = iv\n%1 = add %0\n%2 = mov %0 unless_exit\n'))
    assert len(problems) == 2


def test_a_foreign_memory_operation_may_have_any_operands() -> None:
    text = 'dfg "d"\n%0 = generic "ADD"\n%1 = load\n%2 = store %0, %1, %1\n%3 = generic "M" %2\n'
    assert check(parse(text)) == []


def test_a_word_may_go_to_several_homes() -> None:
    twice = f'dfg "d"\n{HEAD}%7 = live_out "%v" %3\n%8 = live_out "%v" %3\n'
    assert check(parse(twice)) == []
