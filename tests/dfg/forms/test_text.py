"""The text form is complete: reading what was printed gives an equal graph."""

from __future__ import annotations

import pytest
from hypothesis import given, settings

from tests.strategies import dfgs, foreign_dfgs
from vividc.dfg.forms.text import parse, to_text
from vividc.dfg.ir import DFG, Control, Edge, EdgeKind, Node
from vividc.errors import DFGError, SourceLoc
from vividc.machine.opcodes import BASE, ORDER, PRED, Opcode

GOLDEN = """\
dfg "dot \\"1\\""
%0 = const 0x00000000
%1 = live_in "&x"
%2 = iv
%3 = load "x" %2 shift 2 offset -4 base %1 !kernels/a b.py:4
%4 = fma %3, %3, %4@1(init=%0) if %7
%7 = icmp.slt %2, %0 exit
%8 = live_out "%s" %4 control %7 unless_exit
%9 = store "x" %2, %4 shift 2 base %1 after %3, %9@1 control %7@1
"""


def example() -> DFG:
    loc = SourceLoc("kernels/a b.py", 4)
    nodes = (
        Node(0, Opcode.CONST, const=0),
        Node(1, Opcode.LIVE_IN, name="&x"),
        Node(2, Opcode.IV),
        Node(3, Opcode.LOAD, name="x", shift=2, offset=-4, loc=loc),
        Node(4, Opcode.FMA),
        Node(7, Opcode.ICMP_SLT, control=Control.EXIT),
        Node(8, Opcode.LIVE_OUT, name="%s", unless_exit=True),
        Node(9, Opcode.STORE, name="x", shift=2),
    )
    edges = (
        Edge(2, 3, 0),
        Edge(1, 3, BASE),
        Edge(3, 4, 0),
        Edge(3, 4, 1),
        Edge(4, 4, 2, 1, init=0),
        Edge(7, 4, PRED),
        Edge(2, 7, 0),
        Edge(0, 7, 1),
        Edge(4, 8, 0),
        Edge(7, 8, ORDER, kind=EdgeKind.CONTROL),
        Edge(2, 9, 0),
        Edge(4, 9, 1),
        Edge(1, 9, BASE),
        Edge(3, 9, ORDER, kind=EdgeKind.ORDER),
        Edge(9, 9, ORDER, 1, kind=EdgeKind.ORDER),
        Edge(7, 9, ORDER, 1, kind=EdgeKind.CONTROL),
    )
    return DFG('dot "1"', nodes, edges)


def test_golden() -> None:
    assert to_text(example()) == GOLDEN


def test_reading_gives_the_printed_graph_and_its_lines() -> None:
    read = parse(GOLDEN)
    assert read == example()
    assert [node.loc for node in read.nodes] == [node.loc for node in example().nodes]


@settings(max_examples=60)
@given(dfg=dfgs())
def test_round_trip(dfg: DFG) -> None:
    read = parse(to_text(dfg))
    assert read == dfg
    assert [node.loc for node in read.nodes] == [node.loc for node in dfg.nodes]


@settings(max_examples=30)
@given(dfg=foreign_dfgs())
def test_round_trip_of_foreign_graphs(dfg: DFG) -> None:
    assert parse(to_text(dfg)) == dfg


def test_edge_order_other_than_the_text_is_kept() -> None:
    dfg = example()
    turned = DFG(dfg.name, dfg.nodes, dfg.edges[::-1])
    assert turned != dfg
    assert to_text(turned).splitlines()[-1].startswith("edges ")
    assert parse(to_text(turned)) == turned


@pytest.mark.parametrize("path", ["a.py", 'say "hi".py', '"q".py', "a\nb.py", " a.py ", "C:\\k.py"])
def test_any_path_can_be_a_source_line(path: str) -> None:
    dfg = DFG("d", (Node(0, Opcode.IV, loc=SourceLoc(path, 7)),), ())
    assert parse(to_text(dfg)).nodes[0].loc == SourceLoc(path, 7)


def test_a_generic_node_may_have_any_port() -> None:
    nodes = (Node(0, Opcode.GENERIC, name="a b"), Node(5, Opcode.GENERIC, name="m"))
    dfg = DFG("g", nodes, (Edge(0, 5, 1), Edge(0, 5, 5), Edge(0, 5, PRED), Edge(5, 0, 0, 2)))
    assert '%5 = generic "m" 1: %0, 5: %0 if %0' in to_text(dfg)
    assert parse(to_text(dfg)) == dfg


def test_comments_and_blank_lines_are_skipped() -> None:
    assert parse('# head\n\ndfg "d"\n  # more\n%0 = iv\n') == DFG("d", (Node(0, Opcode.IV),), ())


@pytest.mark.parametrize(
    ("text", "line", "reason"),
    [
        ("%0 = iv", 1, "expected dfg"),
        ('dfg "d"\n%0 = divide %1', 2, "there is no operation divide"),
        ('dfg "d"\n%0 iv', 2, "expected ="),
        ('dfg "d"\n%0 = mov %1,', 2, "an operand must follow"),
        ('dfg "d"\n%0 = const', 2, "expected a number"),
        ('dfg "d"\n%0 = mov %1 sideways', 2, "there is no clause sideways"),
        ('dfg "d"\n%0 = mov %1 exit branch', 2, "already marked exit"),
        ('dfg "d"\n%0 = mov %1 !nowhere', 2, "not a source line"),
        ('dfg "d"\n%0 = mov %1@1(init=2)', 2, "expected a reference"),
        ('dfg "d"\n%0 = mov ; %1', 2, "cannot read"),
        ('dfg "d"\n%0 = iv %', 2, "cannot read"),
        ('dfg "d"\n%0 = iv 7 7', 2, "expected :"),
        ('dfg "d"\n%0 = mov %0@1\nedges 1', 3, "must list each"),
        ('dfg "d"\nedges\n%0 = iv', 3, "nothing may follow"),
        ('dfg "d\\x"', 1, "is not a string"),
    ],
)
def test_errors_name_file_and_line(text: str, line: int, reason: str) -> None:
    with pytest.raises(DFGError) as error:
        parse(text, file="g.dfg")
    assert str(error.value).startswith(f"g.dfg:{line}: ")
    assert reason in str(error.value)


def test_an_empty_text_is_an_error() -> None:
    with pytest.raises(DFGError, match="the text is empty"):
        parse("\n")
