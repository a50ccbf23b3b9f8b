"""The forms of other tools: Morpher's XML, CGRA-ME's DOT, networkx, and the table of names."""

from __future__ import annotations

import json
import re
from itertools import chain
from pathlib import Path

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings

from tests.strategies import dfgs, foreign_dfgs
from vividc.dfg import Opcode, from_networkx, load, parse_dot, to_dot, to_json, to_networkx
from vividc.dfg.forms.attributes import EDGE_ALIASES, NODE_ALIASES, OPERANDS
from vividc.dfg.forms.json_form import from_json
from vividc.dfg.forms.json_lines import ElementLines
from vividc.dfg.forms.morpher_xml import parse_morpher_xml
from vividc.dfg.forms.text import to_text
from vividc.dfg.ir import DFG, Edge, EdgeKind, Node
from vividc.errors import DFGError, VividcWarning
from vividc.machine.foreign_names import NAME_ROWS, is_known, row_of
from vividc.machine.opcodes import ORDER, PRED, LatencyClass

DOC = Path(__file__).parents[3] / "docs" / "dfg-formats.md"

# As the generator writes: a second root, and attributes without a blank between.
XML = """<MutexBB>
<BB1 name="body_0">
\t<BB2 name="body_1"/>
</BB1>
</MutexBB>
<DFG count="4">
<Node idx="3" ASAP="0" ALAP="0"BB="entry"CONST="4094">
<OP>LOADB</OP>
<BasePointerName size="1">start</BasePointerName>
<Inputs>
</Inputs>
<Outputs>
\t<Output idx="5" nextiter="0" NPB="0" type="P"/>
\t<Output idx="9" nextiter="1" type="PS"/>
</Outputs>
<RecParents>
</RecParents>
</Node>

<Node idx="5" ASAP="1" ALAP="1"BB="body_0"CONST="-1">
<OP>ADD</OP>
<Inputs>
\t<Input idx="3"/>
</Inputs>
<Outputs>
\t<Output idx="5" nextiter="1" type="I1"/>
\t<Output idx="7" nextiter="0" type="I2"/>
\t<Output idx="9" nextiter="0" type="I1"/>
</Outputs>
</Node>
<Node idx="7" ASAP="2" ALAP="2"BB="a &lt;b&gt;">
<OP>CMERGE</OP>
<Inputs/>
<Outputs>
\t<Output idx="9" nextiter="0" type="I2"/>
</Outputs>
</Node>
<!-- the last -->
<Node idx="9" ASAP="3" ALAP="3">
<OP>OSTOREH</OP>
<Outputs/>
</Node>
</DFG>
"""
MORPHER = DFG(
    "mac_LN1",
    (
        Node(3, Opcode.LOAD, name="start", width=1),
        Node(5, Opcode.GENERIC, name="ADD"),
        Node(7, Opcode.GENERIC, name="CMERGE"),
        Node(9, Opcode.STORE, width=2),
    ),
    (
        Edge(3, 5, PRED),
        Edge(3, 9, ORDER, 1, kind=EdgeKind.ORDER),
        Edge(5, 5, 0, 1),
        Edge(5, 7, 1),
        Edge(5, 9, 0),
        Edge(7, 9, 1),
    ),
)


def test_morpher_xml(tmp_path: Path) -> None:
    path = tmp_path / "mac_LN1_PartPred_DFG.xml"
    path.write_text(XML)
    assert load(path) == MORPHER


def test_two_operations_of_one_index_become_one_node_with_a_warning() -> None:
    shared = XML.replace('idx="7"', 'idx="9"')
    with pytest.warns(VividcWarning, match="share the ids 9"):
        dfg = parse_morpher_xml(shared.replace('<Output idx="9" nextiter="0" type="I2"/>', ""))
    assert [node.op for node in dfg.nodes] == [Opcode.LOAD, Opcode.GENERIC, Opcode.STORE]


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("<OP>CMERGE</OP>", "", "x.xml:37: the <Node> has no <OP> (idx 7)"),
        ('idx="5" ASAP', "ASAP", "x.xml:20: <Node> has no idx"),
        ('idx="5" ASAP', 'idx="five" ASAP', "x.xml:20: idx 'five' of <Node> is no integer"),
        ('idx="5" ASAP', "idx=5 ASAP", "x.xml:20: an attribute of <Node> is malformed: ' idx=5"),
        ('type="P"', 'type="Q"', "x.xml:13: the type 'Q' of an <Output> is none of P, I1, I2"),
        ('nextiter="1" type="PS"', 'nextiter="-1"', "x.xml:14: edges[1]: distance -1 is negative"),
        ('idx="7" nextiter', 'idx="77" nextiter', "x.xml:27: edges[3]: dst 77 is no node"),
        ('count="4"', 'count="5"', "announces 5 nodes and holds 4"),
        ("</DFG>", "", "<DFG> is not closed: the file ends early"),
        ('<Node idx="7"', '<Node idx="5"><OP>A</OP></Node><Node idx="7"', "announces 4"),
        ("</Outputs>\n</Node>\n<!--", "<!--", "x.xml:37: a <Node> begins inside node 7"),
        ("<DFG", "<Graph", "the XML has no <DFG> element"),
        ("<Inputs/>", "<<Inputs/>", "x.xml:33: no tag of XML"),
    ],
)
def test_wrong_xml_names_its_line(old: str, new: str, problem: str) -> None:
    assert old in XML
    with pytest.raises(DFGError) as error:
        parse_morpher_xml(XML.replace(old, new, 1), "x.xml")
    assert problem in str(error.value)


CGRA_ME = """digraph G {
input0[opcode=input][argNo=0][argType=value];
const1[opcode=const][value=3];
phi2[opcode=phi];
mul3[opcode=mul];
add4[opcode=add];
output5[opcode=output];
input0->mul3[operand=0]; //input->mul
const1->mul3[operand=1];
mul3->add4[operand=RHS];
phi2->add4[operand=lhs];
add4->phi2[operand=1];
add4->output5[operand=0];
output5->output5[operand=1];
}
"""


def test_cgra_me_dot_and_its_inferred_distances() -> None:
    with pytest.warns(VividcWarning, match=r"1 iteration is taken for add4 -> phi2, output5 -> ou"):
        dfg = parse_dot(CGRA_ME)
    assert [node.op.value for node in dfg.nodes][:3] == ["generic", "const", "generic"]
    assert dfg.nodes[1].const == 3
    assert [node.label for node in dfg.nodes][-1] == "output5"
    assert [edge.distance for edge in dfg.edges] == [0, 0, 0, 0, 1, 0, 1]
    assert [edge.port for edge in dfg.edges] == [0, 1, 1, 0, 1, 0, 1]


def test_another_cycle_without_distances_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "loop.dot"
    path.write_text("digraph { add0 -> mul1; mul1 -> add0; }")
    with pytest.raises(DFGError, match=r"loop\.dot: a cycle of distance 0 holds back nodes .*add0"):
        load(path)


def test_graphviz_dot_as_networkx_writes_it() -> None:
    text = 'strict digraph "g 1" {\n0 [op=load];\n1 [op="add"];\n0 -> 1 [key=0, distance=0];\n}\n'
    dfg = parse_dot(text)
    assert (dfg.name, dfg.edges) == ("g 1", (Edge(0, 1, 0),))


@settings(max_examples=40)
@given(dfg=dfgs())
def test_networkx_round_trip(dfg: DFG) -> None:
    graph = to_networkx(dfg)
    assert from_networkx(graph) == dfg
    assert from_networkx(graph.copy()) == dfg
    assert nx.number_of_nodes(graph) == len(dfg.nodes)


@settings(max_examples=20)
@given(dfg=foreign_dfgs())
def test_networkx_round_trip_of_foreign_graphs(dfg: DFG) -> None:
    assert from_networkx(to_networkx(dfg)) == dfg


def test_a_foreign_networkx_graph() -> None:
    graph = nx.DiGraph()
    graph.add_node(("x", 1), op="LOADB")
    graph.add_node("k", op="const", value=np.int64(7))
    graph.add_node("m", label="MUL (2)")
    graph.add_edge(("x", 1), "m", operand=np.int32(0), distance=np.int64(2))
    graph.add_edge("k", "m")
    dfg = from_networkx(graph)
    assert dfg.nodes == (
        Node(0, Opcode.LOAD, width=1),
        Node(1, Opcode.CONST, const=7),
        Node(2, Opcode.GENERIC, name="MUL"),
    )
    assert dfg.nodes[0].label == "('x', 1)"
    assert dfg.edges == (Edge(0, 2, 0, 2), Edge(1, 2, 1))


@pytest.mark.parametrize(
    ("graph", "problem"),
    [
        (nx.Graph(), "undirected"),
        (nx.MultiDiGraph(), "has no nodes"),
        (nx.DiGraph([("a", "a")]), "a cycle of distance 0"),
        ({}, "the graph cannot be {}"),
    ],
)
def test_a_wrong_networkx_graph_is_refused(graph: nx.Graph, problem: str) -> None:
    with pytest.raises(Exception, match=problem) as error:
        from_networkx(graph)
    assert type(error.value).__name__ in {"DFGError", "ArgumentError"}


@pytest.mark.parametrize(
    ("attributes", "problem"),
    [
        ({"distance": -1}, "distance -1 is negative"),
        ({"distance": 0.5}, "distance 0.5 is no integer"),
        ({"distance": None}, "distance None is no integer"),
        ({"operand": "left"}, "operand 'left' is neither"),
        ({"kind": "soft"}, "kind 'soft' is not one of"),
    ],
)
def test_wrong_networkx_attributes_are_refused(attributes: dict[str, object], problem: str) -> None:
    graph = nx.MultiDiGraph()
    graph.add_edge("a", "b", **attributes)
    if attributes.get("distance", 0) is None:
        assert from_networkx(graph).edges[0].distance == 0
        return
    with pytest.raises(DFGError, match=re.escape(problem)):
        from_networkx(graph)


def test_the_documented_table_is_the_code_s() -> None:
    rows = re.findall(r"^\| ((?:`[\w.]+` ?)+)\| `(\w+)`(.*?)\| (\w+) \|$", DOC.read_text(), re.M)
    documented = [
        (tuple(re.findall(r"`([^`]+)`", names)), opcode, latency)
        for names, opcode, _, latency in rows
    ]
    assert documented == [(r.names, r.opcode.value, r.latency_class.value) for r in NAME_ROWS]
    for (_, opcode, rest, _), row in zip(rows, NAME_ROWS, strict=True):
        if opcode in {"load", "store"}:
            assert f", {row.width} byte" in rest


def test_every_name_has_one_meaning() -> None:
    names = [name for row in NAME_ROWS for name in row.names]
    assert len(names) == len(set(names))
    assert all(name == name.lower() for name in names)
    assert is_known("CMERGE")
    assert is_known("icmp.eq")
    assert not is_known("frobnicate")
    assert row_of("OloadH") is not None


def test_a_foreign_name_has_its_latency_class() -> None:
    assert Node(0, Opcode.GENERIC, name="CGT").latency_class is LatencyClass.COMPARE
    assert Node(0, Opcode.GENERIC, name="MULT").latency_class is LatencyClass.IMUL
    assert Node(0, Opcode.GENERIC, name="frobnicate").latency_class is LatencyClass.GENERIC


@pytest.mark.parametrize("name", ["copy", "copy.json", "copy.txt", "copy.dfg", "copy.xml"])
def test_the_content_decides_the_form(tmp_path: Path, name: str) -> None:
    forms = {
        "json": json.dumps(to_json(MORPHER)),
        "dot": "// a comment\n/* and\nmore */\n" + to_dot(MORPHER),
        "text": "\n" + to_text(MORPHER),
        "bom": "\ufeff" + json.dumps(to_json(MORPHER)),
    }
    for text in forms.values():
        (tmp_path / name).write_text(text, encoding="utf-8")
        assert load(tmp_path / name) == MORPHER


def test_labels_survive_json() -> None:
    dfg = from_json({"name": "d", "nodes": [{"id": "a.b", "op": "add"}], "edges": []})
    assert dfg.nodes[0].label == "a.b"
    assert from_json(to_json(dfg)).nodes[0].label == "a.b"


def test_unknown_operations_are_warned_of_once_or_refused(tmp_path: Path) -> None:
    path = tmp_path / "g.json"
    ops = ["zip", "zap", "add", "zip"]
    nodes = [{"id": f"n{number}", "op": op} for number, op in enumerate(ops)]
    path.write_text(json.dumps({"name": "d", "nodes": nodes, "edges": []}))
    with pytest.warns(VividcWarning) as caught:
        load(path)
    (warning,) = caught
    assert "unknown operation 'zip' (node n0), 'zap' (node n1)" in str(warning.message)
    with pytest.raises(DFGError, match=r"g\.json: unknown operation 'zip' .*\nhint: rename it"):
        load(path, unknown_ops="refuse")
    with pytest.raises(DFGError, match="'any' is none of generic and refuse"):
        load(path, unknown_ops="any")  # type: ignore[arg-type]


def test_lines_of_json_elements() -> None:
    text = '\n{"a": [1, {"nodes": [2]}],\n "nodes": [\n{"id": 0},\n\n{"id": 1}], "edges":[]\n}'
    assert ElementLines(text) == {"nodes[0]": 4, "nodes[1]": 6}
    assert ElementLines("[1]") == {}
    assert ElementLines('{"edges": {}}') == {}


def read_json(edges: list[dict[str, object]], ops: tuple[str, ...] = ("load", "add")) -> DFG:
    nodes = [{"id": number, "op": op} for number, op in enumerate(ops)]
    return from_json({"name": "d", "nodes": nodes, "edges": edges})


def test_the_same_names_mean_the_same_in_all_forms() -> None:
    wanted = (Edge(0, 1, 1, 1),)
    for edge in (
        {"distance": 1, "operand": 1},
        {"dist": 1, "port": 1},
        {"dist": 1, "operand": "RHS"},
        {"distance": 1, "port": "data"},
    ):
        graph = nx.MultiDiGraph()
        graph.add_nodes_from([(0, {"operation": "load"}), (1, {"opcode": "add"})])
        graph.add_edge(0, 1, **edge)
        attributes = ", ".join(f'{key}="{value}"' for key, value in edge.items())
        dot = f"digraph {{ 0 [op=load]; 1 [operation=add]; 0 -> 1 [{attributes}] }}"
        for dfg in (
            read_json([{"src": 0, "dst": 1, **edge}]),
            parse_dot(dot),
            from_networkx(graph),
        ):
            assert dfg.edges == wanted
            assert [node.op for node in dfg.nodes] == [Opcode.LOAD, Opcode.GENERIC]


def test_names_of_nodes_in_json() -> None:
    nodes = [{"id": 0, "opcode": "const", "value": 7}, {"id": 1, "operation": "add", "name": "sum"}]
    dfg = from_json({"name": "d", "nodes": nodes, "edges": []})
    assert dfg.nodes == (
        Node(0, Opcode.CONST, const=7),
        Node(1, Opcode.GENERIC, name="add", label="sum"),
    )


def test_cgra_me_operands_of_any_order_take_what_is_free() -> None:
    """As its `OpGraph::serialize` writes, with tags of its header."""
    dfg = parse_dot(
        """digraph G {
        input0 [opcode=input]; const1 [opcode=const, constVal="3"]; mul2 [opcode=mul];
        add3 [opcode=add]; load4 [opcode=load, memName="x"]; fma5 [opcode=fma];
        input0 -> mul2 [operand="any2input"]; const1 -> mul2 [operand="any2input"];
        mul2 -> add3 [operand="RHS", bitwidth=32]; mul2 -> add3 [operand=any2input];
        mul2 -> load4 [operand="addr"]; load4 -> load4 [kind=alias, dist=1];
        input0 -> fma5 [operand=any3input]; mul2 -> fma5 [operand=any3input];
        add3 -> fma5 [operand=any3input];
        }"""
    )
    assert dfg.nodes[1] == Node(1, Opcode.CONST, const=3, label="const1")
    assert dfg.nodes[4] == Node(4, Opcode.LOAD, name="x", label="load4")
    assert [edge.port for edge in dfg.edges] == [0, 1, 1, 0, 0, ORDER, 0, 1, 2]
    assert [edge.distance for edge in dfg.edges] == [0, 0, 0, 0, 0, 1, 0, 0, 0]


def test_a_branch_s_operands_follow_its_condition() -> None:
    tags = ("branch_cond", "branch_true", "BRANCH_FALSE")
    edges = [{"src": 0, "dst": 1, "operand": tag} for tag in reversed(tags)]
    assert [edge.port for edge in read_json([*edges], ("icmp", "br")).edges] == [2, 1, 0]


def test_a_wrong_operand_names_all_that_are_known() -> None:
    with pytest.raises(DFGError) as error:
        parse_dot("digraph {\n a -> b [operand=left] }", "x.dot")
    assert str(error.value).startswith("x.dot:2: edges[0]: operand 'left' is neither a port number")
    for tag in ("pred", "base", "LHS", "RHS", "addr", "data", "any2input", "branch_true"):
        assert tag in str(error.value)
    with pytest.raises(DFGError, match=r"operand 0 of node 1 is fed by edges\[0\] already"):
        read_json([{"src": 0, "dst": 1, "operand": name} for name in ("LHS", 0)])


def test_keys_without_a_meaning_are_warned_of_once_each(tmp_path: Path) -> None:
    path = tmp_path / "g.json"
    path.write_text(
        '{"name": "g", "stats": {}, "nodes": [{"id": 0, "op": "add"},\n'
        '{"id": 1, "op": "add", "latency": -3},\n{"id": 2, "op": "add", "latency": 2}],\n'
        '"edges": [{"src": 0, "dst": 1, "ctype": "I1"},\n{"src": 1, "dst": 2, "distnace": 1}]}'
    )
    with pytest.warns(VividcWarning) as caught:
        load(path)
    (warning,) = caught
    text = str(warning.message)
    assert f"{path}:2: unknown key 'latency' of nodes[1], " in text
    assert f"{path}:5: unknown key 'distnace' of edges[1]: ignored; a node has id, op (opco" in text
    assert "an edge has src, dst, kind, distance (dist), operand (port)" in text


def test_keys_without_a_meaning_in_dot_and_networkx() -> None:
    styled = 'digraph { a [shape=box, label="add"]; a -> a [color=red, dist=1, weight=3, len=2] }'
    assert parse_dot(styled).nodes[0].name == "add"
    with pytest.warns(VividcWarning, match=r"^x\.dot:2: unknown key 'latency' of nodes\[0\]: ign"):
        parse_dot("digraph {\n a [latency=2] }", "x.dot")
    graph = nx.MultiDiGraph(name="g")
    graph.add_edge("a", "b", distnace=1)
    with pytest.warns(VividcWarning, match=r"networkx graph 'g': unknown key 'distnace' of edges"):
        from_networkx(graph)


def test_numpy_s_numbers_are_numbers() -> None:
    graph = nx.MultiDiGraph()
    graph.add_node("c", op="const", const=np.float32(1.5))
    graph.add_node("d", op="const", const=np.uint8(7))
    graph.add_edge("c", "a")
    graph.add_edge("d", "a", distance=np.int16(2))
    dfg = from_networkx(graph)
    assert [node.const for node in dfg.nodes] == [0x3FC00000, 7, None]
    assert [edge.distance for edge in dfg.edges] == [0, 2]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("g.json", '{"name": "\\"12",\n"nodes": [{"id": 0, "op": "const", "const": -%s}]}'),
        ("g.json", '{"name": "0", "x": 0.%s,\n "nodes": [{"id": %s}]}'),
        ("g.dfg", 'dfg "d"\n%%0 = const %s'),
        ("g.dfg", 'dfg "d"\n%%%s = mov %%0'),
    ],
)
def test_a_number_of_thousands_of_digits_has_its_line(name: str, text: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text(text % (("9" * 5000,) * text.count("%s")))
    with pytest.raises(DFGError, match=rf"{name}:2: a number of 5000 digits"):
        load(path)


def test_a_long_unknown_name_is_cut_inside_its_quotes(tmp_path: Path) -> None:
    path = tmp_path / "g.json"
    path.write_text(json.dumps({"name": "g", "nodes": [{"id": 0, "op": "z" * 80}], "edges": []}))
    with pytest.warns(VividcWarning, match=r"unknown operation 'z{35}\.\.\.' \(node 0\): taken"):
        load(path)


def test_all_operands_and_aliases_are_documented() -> None:
    text = DOC.read_text()
    for name in (*OPERANDS, *chain(*NODE_ALIASES.values()), *chain(*EDGE_ALIASES.values())):
        assert f"`{name}`" in text
