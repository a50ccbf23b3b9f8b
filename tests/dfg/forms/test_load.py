"""Reading DFG files: our own, foreign ones, and broken ones."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import given, settings

from tests.strategies import dfgs, foreign_dfgs
from vividc.dfg.forms.dot import parse_dot, to_dot
from vividc.dfg.forms.json_form import from_json, original_ids, to_json
from vividc.dfg.forms.load import load
from vividc.dfg.forms.text import to_text
from vividc.dfg.ir import DFG, Edge, EdgeKind, Node
from vividc.errors import DFGError, VividcWarning
from vividc.machine.opcodes import ORDER, PRED, Opcode

DATA = Path(__file__).parents[2] / "data"
# Graphs published with other mappers, where the checkout has them beside it.
PUBLISHED = Path(__file__).parents[4] / "shared" / "dfgs"
FILES = sorted([*DATA.glob("foreign_*.json"), *PUBLISHED.glob("*.json")])


@pytest.mark.filterwarnings("ignore:.*share the ids:vividc.VividcWarning")
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_published_graph_loads_whole(path: Path) -> None:
    data = json.loads(path.read_text())
    dfg = load(path)
    assert {node.id for node in dfg.nodes} == set(original_ids(data))
    kinds = Counter("order" if edge.kind is EdgeKind.ORDER else None for edge in dfg.edges)
    assert kinds == Counter(edge.get("kind") for edge in data["edges"])
    distances = Counter(edge.distance for edge in dfg.edges)
    assert distances == Counter(edge["distance"] for edge in data["edges"])
    ports = [(edge.dst, edge.port) for edge in dfg.edges if edge.is_data]
    assert len(ports) == len(set(ports))


@pytest.mark.parametrize("path", FILES[:8], ids=lambda path: path.stem)
def test_every_form_reads_back_a_published_graph(path: Path, tmp_path: Path) -> None:
    dfg = load(path)
    for ending, text in (
        (".dfg", to_text(dfg)),
        (".dot", to_dot(dfg)),
        (".json", json.dumps(to_json(dfg))),
    ):
        copy = tmp_path / f"copy{ending}"
        copy.write_text(text)
        assert load(copy) == dfg


@settings(max_examples=40)
@given(dfg=dfgs())
def test_json_and_dot_round_trip(dfg: DFG) -> None:
    for read in (from_json(json.loads(json.dumps(to_json(dfg)))), parse_dot(to_dot(dfg))):
        assert read == dfg
        assert [node.loc for node in read.nodes] == [node.loc for node in dfg.nodes]


@settings(max_examples=20)
@given(dfg=foreign_dfgs())
def test_foreign_graphs_round_trip(dfg: DFG) -> None:
    assert from_json(to_json(dfg)) == dfg
    assert parse_dot(to_dot(dfg)) == dfg


def test_foreign_names_and_ports() -> None:
    dfg = load(DATA / "foreign_accumulate.json")
    assert dfg.nodes == (
        Node(41, Opcode.LOAD, width=1),
        Node(7, Opcode.GENERIC, name="ADD"),
        Node(3, Opcode.GENERIC, name="MUL"),
        Node(12, Opcode.STORE),
        Node(5, Opcode.CONST, const=16),
        Node(6, Opcode.LIVE_IN, name="6"),
    )
    assert dfg.edges == (
        Edge(41, 3, 0),
        Edge(41, 3, 1),
        Edge(3, 7, 1),
        Edge(7, 7, 0, 1),
        Edge(5, 7, 2),
        Edge(6, 12, 0),
        Edge(7, 12, 1),
        Edge(3, 12, PRED),
        Edge(12, 41, ORDER, 1, kind=EdgeKind.ORDER),
    )


def test_names_as_ids_are_numbered_in_file_order() -> None:
    dfg = load(DATA / "foreign_names.json")
    assert [node.id for node in dfg.nodes] == [0, 1, 2]
    assert dfg.by_id[1] == Node(1, Opcode.CONST, const=8)
    data = json.loads((DATA / "foreign_names.json").read_text())
    assert original_ids(data) == {0: "x", 1: "8", 2: "y"}


def test_a_constant_of_unknown_word_is_a_live_in() -> None:
    nodes = [{"id": "k", "op": "const"}, {"id": "a", "op": "add"}]
    dfg = from_json({"name": "d", "nodes": nodes, "edges": [{"src": "k", "dst": "a"}]})
    assert dfg.nodes[0] == Node(0, Opcode.LIVE_IN, name="k")


def test_operands_past_the_third_lie_behind_the_named_ports() -> None:
    edges = [{"src": 0, "dst": 1, "distance": 0, "operand": port} for port in range(5)]
    nodes = [{"id": 0, "op": "a"}, {"id": 1, "op": "b"}]
    dfg = from_json({"name": "d", "nodes": nodes, "edges": edges})
    assert [edge.port for edge in dfg.edges] == [0, 1, 2, 5, 6]


def test_a_published_graph_that_uses_an_id_twice_has_one_node_of_it() -> None:
    nodes = [{"id": 1, "op": "CMERGE"}, {"id": 1, "op": "LOADB"}, {"id": 2, "op": "ADD"}]
    data = {"name": "d", "source": "elsewhere", "nodes": nodes, "edges": []}
    with pytest.warns(VividcWarning, match="share the ids 1;"):
        dfg = from_json(data)
    assert [node.op for node in dfg.nodes] == [Opcode.LOAD, Opcode.GENERIC]


def one(**fields: object) -> dict[str, object]:
    """A graph of one operation that reads itself, changed by `fields`."""
    edge = {"src": 0, "dst": 0, "distance": 1, "operand": 0}
    return {"name": "d", "nodes": [{"id": 0, "op": "ADD"}], "edges": [edge], **fields}


OWN = {"schema": "vividc.dfg/1"}


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        ([], "expected an object"),
        ({"name": "d", "edges": []}, "nodes is missing"),
        (one(edges={}), "edges is not an array"),
        (one(name=3), "name 3 is not a string"),
        (one(nodes=[3]), "nodes[0]: 3 is not an object"),
        (one(nodes=[{"id": 0}]), "nodes[0]: op is missing"),
        (one(nodes=[{"op": "ADD"}]), "nodes[0]: id is missing"),
        (one(nodes=[{"id": True, "op": "ADD"}]), "nodes[0]: id True"),
        (one(nodes=[{"id": -1, "op": "ADD"}]), "nodes[0]: id -1"),
        (one(nodes=[{"id": 0, "op": "A"}, {"id": 0, "op": "B"}]), "two nodes have id 0"),
        (one(edges=[{"src": 0, "dst": 9}]), "edges[0]: dst 9 is no node"),
        (one(edges=[{"dst": 0}]), "edges[0]: src is missing"),
        (one(edges=[{"src": 0, "dst": 0, "distance": -1}]), "distance -1 is negative"),
        (one(edges=[{"src": 0, "dst": 0, "distance": "1"}]), "distance '1' is no integer"),
        (one(edges=[{"src": 0, "dst": 0, "operand": "left"}]), "operand 'left' is neither"),
        (one(edges=[{"src": 0, "dst": 0, "kind": "soft"}]), "kind 'soft' is not one of"),
        (one(schema="vividc.dfg/9"), "schema 'vividc.dfg/9' is unknown"),
        (one(**OWN), "op 'ADD' is not one of"),
        (one(**OWN, nodes=[{"id": 0, "op": "add", "colour": 1}]), "unknown key 'colour'"),
        (one(**OWN, edges=[{"src": 0, "dst": 0, "distance": 1}]), "operand is missing"),
        (one(**OWN, nodes=[{"id": 0, "op": "mov", "unless_exit": 1}]), "neither true nor false"),
    ],
)
def test_wrong_json_is_reported_with_its_place(data: object, problem: str) -> None:
    with pytest.raises(DFGError) as error:
        from_json(data, file="g.json")
    assert str(error.value).startswith("g.json: ")
    assert problem in str(error.value)


def test_all_problems_are_reported_at_once() -> None:
    edges = [{"src": 0, "dst": 9}, {"src": 8, "dst": 0}]
    with pytest.raises(DFGError, match=r"dst 9 is no node\n.*src 8 is no node"):
        from_json(one(edges=edges))


@pytest.mark.parametrize(
    ("name", "text", "problem"),
    [
        ("a.json", '{"name": "d",\n "nodes": [,]}', "a.json:2: not JSON"),
        ("a.json", "[" * 100_000, "a.json"),
        ("a.txt", "", "the ending '.txt' names a form"),
        ("a.dfg", 'dfg "d"\n%0 = what', "a.dfg:2: there is no operation what"),
        ("a.dot", "digraph {\n a -> ;}", "a.dot:2: expected a name"),
        ("a.dfg", 'dfg "d"\n%0 = mov %1', "a.dfg: edge 0"),
        ("a.dfg", 'dfg "d"\n%0 = mov %0', "a cycle of distance 0"),
    ],
)
def test_a_wrong_file_is_named(tmp_path: Path, name: str, text: str, problem: str) -> None:
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(DFGError) as error:
        load(path)
    expected = problem.replace("edge 0", "edge 1 -> 0 (port 0, distance 0): its src 1 is no node")
    assert expected in str(error.value)


def test_a_missing_or_binary_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(DFGError, match=r"none\.json: cannot be read: No such file"):
        load(tmp_path / "none.json")
    (tmp_path / "bits.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(DFGError, match=r"bits\.json: not a text file in UTF-8"):
        load(tmp_path / "bits.json")


FOREIGN_DOT = """/* from elsewhere */
strict digraph "fir" {
  rankdir=LR; graph [label="x"];
  node [opcode=mul]; edge [operand=0];
  load0 [opcode="LOAD"]; // two
  load0:out:n -> mul1 -> "add2" [distance=0];
  mul1 -> add2 [operand=1 dist=0, style=dashed];
  subgraph cluster0 { node [shape=box]; add2 [opcode=add]; add2 -> add2 [distance=1, operand=2] }
  k3 [label="const 5", opcode=""]
}
"""


def test_foreign_dot() -> None:
    dfg = parse_dot(FOREIGN_DOT)
    assert dfg.name == "fir"
    assert dfg.nodes == (
        Node(0, Opcode.LOAD),
        Node(1, Opcode.GENERIC, name="mul"),
        Node(2, Opcode.GENERIC, name="add"),
        Node(3, Opcode.LIVE_IN, name="k3"),
    )
    assert dfg.edges == (Edge(0, 1, 0), Edge(1, 2, 0), Edge(1, 2, 1), Edge(2, 2, 2, 1))


def test_the_operation_in_dot_falls_back_to_label_and_name() -> None:
    dfg = parse_dot('digraph { a1 [label="ADD (3)"]; mul_2; 7 }')
    assert [node.name for node in dfg.nodes] == ["ADD", "mul", "node"]


def test_dot_shows_classes_and_recurrences() -> None:
    text = to_dot(load(DATA / "foreign_accumulate.json"))
    assert 'fillcolor="palegreen"' in text
    assert 'style="dashed", label="1"' in text


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("graph { a -- b }", "x.dot:1: a dataflow graph is directed"),
        ("digraph {\n a", "x.dot:2: the graph is not closed"),
        ("digraph { a [label=<b>] }", "HTML labels are not understood"),
        ("digraph { a -> {b c} }", "an edge to a subgraph"),
        ("digraph { subgraph s { a } -> b }", "an edge from a subgraph"),
        ("digraph { a } digraph { b }", "only one graph"),
        ("digraph { a ? b }", "'?' is not understood"),
        ('digraph { vividc="vividc.dfg/1"; 0 }', "the attribute vividc is missing"),
        ("digraph { a -> b [distance=-2] }", "distance -2 is negative"),
        ("digraph { a -> b [distance=far] }", "distance 'far' is no integer"),
    ],
)
def test_wrong_dot_is_reported(text: str, problem: str) -> None:
    with pytest.raises(DFGError) as error:
        parse_dot(text, file="x.dot")
    assert problem in str(error.value)


def test_a_foreign_graph_of_memory_operations_alone_loads(tmp_path: Path) -> None:
    nodes = [{"id": 0, "op": "load"}, {"id": 1, "op": "store"}]
    path = tmp_path / "copy.json"
    path.write_text(json.dumps({"name": "copy", "nodes": nodes, "edges": [{"src": 0, "dst": 1}]}))
    assert load(path).edges == (Edge(0, 1, 0),)
