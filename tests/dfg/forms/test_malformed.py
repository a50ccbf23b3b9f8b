"""Malformed graphs: one message with file, line, node or edge, reason and way out; exit code 2."""

from __future__ import annotations

import contextlib
import json
import warnings
from pathlib import Path

import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.dfg.forms.test_formats import CGRA_ME, XML
from vividc import arch
from vividc.cli import main
from vividc.dfg import DFG, load, to_dot, to_json, to_text
from vividc.dfg.forms.json_form import from_json
from vividc.errors import DFGError, VividcError, VividcWarning
from vividc.mapper import map_dfg

NODES = '{"name": "g", "nodes": [\n {"id": 0, "op": "add"},\n {"id": 1, "op": "mul"}],\n "edges": ['


def edges(*found: str) -> str:
    return NODES + ",\n  ".join(["", *found])[1:] + "]}"


CASES = {
    "zero-distance cycle": (
        edges('{"src": 0, "dst": 1}', '{"src": 1, "dst": 0, "distance": 0}'),
        ["g.json: a cycle of distance 0 holds back nodes", "1 (mul)", "has distance 1 or more"],
    ),
    "self loop of distance 0": (
        edges('{"src": 1, "dst": 1, "distance": 0}'),
        ["g.json: a cycle of distance 0 holds back nodes 1 (mul) -> 1 (mul)"],
    ),
    "dangling edge": (
        edges('{"src": 0, "dst": 1}', '{"src": 0, "dst": 7}'),
        ["g.json:6: edges[1]: dst 7 is no node"],
    ),
    "duplicate id": (
        NODES.replace('"id": 1', '"id": 0') + "]}",
        ["g.json:3: nodes[1]: two nodes have id 0: the other is nodes[0]"],
    ),
    "empty graph": ('{"name": "g", "nodes": [], "edges": []}', ["g.json: the graph has no nodes"]),
    "negative distance": (
        edges('{"src": 0, "dst": 1, "distance": -2}'),
        ["g.json:5: edges[0]: distance -2 is negative; it counts iterations"],
    ),
    "fractional distance": (
        edges('{"src": 0, "dst": 1, "distance": 1.0}'),
        ["g.json:5: edges[0]: distance 1.0 is no integer"],
    ),
    "huge distance": (
        edges('{"src": 0, "dst": 1, "distance": 1000000000000000000000}'),
        ["edges[0]: distance 1000000000000000000000 is more than 1048576 iterations"],
    ),
    "missing field": (edges('{"src": 0}'), ["g.json:5: edges[0]: dst is missing"]),
    "missing op": (
        '{"name": "g", "nodes": [{"id": 0}], "edges": []}',
        ["g.json:1: nodes[0]: op is missing"],
    ),
    "empty op": (
        '{"name": "g", "nodes": [{"id": 0, "op": ""}], "edges": []}',
        ["g.json:1: nodes[0]: op is empty"],
    ),
    "wrong types": (
        edges('{"src": [0], "dst": {}, "distance": "1", "operand": 1.5, "kind": 3}'),
        ["src [0]: an id is", "dst {}: an id is", "distance '1' is no integer", "operand 1.5"],
    ),
    "wrong const": (
        '{"name": "g", "nodes": [{"id": 0, "op": "add", "const": [1]}], "edges": []}',
        ["g.json:1: nodes[0]: const [1] is neither a number nor text"],
    ),
    "parallel edges into one operand": (
        edges('{"src": 0, "dst": 1, "operand": 0}', '{"src": 0, "dst": 1, "operand": 0}'),
        ["g.json:6: edges[1]: operand 0 of node 1 is fed by edges[0] already"],
    ),
    "array": ("[1, 2]", ["g.json: expected an object with nodes and edges"]),
    "no nodes": ('{"name": "g", "edges": []}', ["nodes is missing"]),
    "nodes no array": (
        '{"name": "g", "nodes": 3, "edges": {}}',
        ["nodes is not an array", "edges"],
    ),
    "truncated": (edges('{"src": 0, "dst": 1}')[:-2], ["g.json:5: not JSON"]),
    "number without end": (
        '{"name": "g", "nodes": [{"id": ' + "9" * 5000 + "}]}",
        ["g.json:1: a number of 5000 digits\nhint: a constant is a word"],
    ),
    "deep": ('{"nodes":' + "[" * 200_000, ["g.json: not a DFG: the JSON is nested too deeply"]),
}


@pytest.mark.parametrize("case", CASES, ids=str)
def test_a_malformed_graph_is_one_message_and_exit_code_2(case: str, tmp_path: Path) -> None:
    text, expected = CASES[case]
    path = tmp_path / "g.json"
    path.write_text(text)
    out = CliRunner().invoke(main, ["map", str(path), "--fabric", "mesh-2x2"])
    assert (out.exit_code, out.stdout) == (2, "")
    assert out.stderr.startswith("vividc: ")
    assert "Traceback" not in out.stderr
    for part in expected:
        assert part in out.stderr


@pytest.mark.parametrize(
    "data",
    [b"\x00\x01\x02", b"\xff\xfe{\x00", b"\x7fELF\x02", b"", b"\x89PNG\r\n\x1a\n", b"PK\x03"],
)
@pytest.mark.parametrize("name", ["g.json", "g.dot", "g.xml", "g.dfg", "g"])
def test_garbage_is_refused_in_every_form(data: bytes, name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(VividcError, match=name):
        load(tmp_path / name)


def test_a_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(VividcError, match="cannot be read"):
        load(tmp_path)


def graph(**fields: object) -> DFG:
    nodes = [{"id": number, "op": "add"} for number in range(4)]
    return from_json({"name": "g", "nodes": nodes, "edges": [], **fields})


def test_a_disconnected_graph_is_mapped() -> None:
    result = map_dfg(graph(), arch.load("mesh-2x2"), workers=1)
    assert (result.status, result.ii) == ("optimal", 1)


def test_a_self_loop_of_distance_1_is_a_recurrence() -> None:
    loop = graph(edges=[{"src": 2, "dst": 2, "distance": 1}])
    result = map_dfg(loop, arch.load("mesh-2x2"), workers=1)
    assert (result.status, result.ii) == ("optimal", 1)
    assert result.bounds[0].ii == 1


def test_a_graph_without_operations_maps_at_ii_1() -> None:
    for nodes in ([], [{"id": 0, "op": "const", "const": 1}]):
        result = map_dfg(graph(nodes=nodes), arch.load("mesh-2x2"), workers=1)
        assert (result.status, result.ii) == ("optimal", 1)
        assert result.mapping is not None
        assert result.mapping.places == {}


def test_a_graph_too_large_for_the_contexts_is_proved_impossible() -> None:
    """Four PEs with 512 contexts issue at most 2,048 operations an iteration."""
    nodes = [{"id": number, "op": "add"} for number in range(2100)]
    links = [{"src": n, "dst": n + 1} for n in range(2098, -1, -1)]
    huge = from_json({"name": "huge", "nodes": nodes, "edges": links})
    result = map_dfg(huge, arch.load("mesh-2x2"), workers=1, time_limit_s=20)
    assert result.status == "infeasible"
    assert "2100 on all 4 PEs" in result.explain()


@pytest.mark.parametrize(("ii", "why"), [(1, "the lower bound 2"), (9999, "contexts")])
def test_an_ii_that_cannot_be_is_proved_so(ii: int, why: str, tmp_path: Path) -> None:
    path = tmp_path / "g.json"
    found = '{"src": 0, "dst": 1}', '{"src": 1, "dst": 0, "distance": 1}'
    path.write_text(edges(*found))
    out = CliRunner().invoke(main, ["map", str(path), "--fabric", "mesh-2x2", "--ii", str(ii)])
    assert out.exit_code == 3
    assert f"proved infeasible at II {ii}" in out.stderr
    assert why in out.stderr


def _samples() -> list[bytes]:
    dfg = graph(edges=[{"src": 0, "dst": 1}, {"src": 1, "dst": 2, "distance": 1, "operand": 0}])
    texts = (edges('{"src": 0, "dst": 1}'), json.dumps(to_json(dfg)), to_dot(dfg), to_text(dfg))
    return [text.encode() for text in (*texts, XML, CGRA_ME)]


SAMPLES = _samples()
PIECES = [b"{", b"}", b"[", b"]", b'"', b"\\", b"<", b">", b"/", b"-", b"9" * 40, b"\x00", b"\xff"]


@settings(max_examples=200)
@given(
    sample=st.sampled_from(SAMPLES),
    cuts=st.lists(
        st.tuples(
            st.floats(0, 1),
            st.integers(0, 12),
            st.sampled_from(PIECES) | st.binary(max_size=4) | st.just(b""),
        ),
        min_size=1,
        max_size=4,
    ),
    name=st.sampled_from(["f.json", "f.dot", "f.xml", "f.dfg", "f.bin"]),
)
def test_mutated_bytes_load_or_are_refused(
    sample: bytes,
    cuts: list[tuple[float, int, bytes]],
    name: str,
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    for place, length, piece in cuts:
        at = int(place * len(sample))
        sample = sample[:at] + piece + sample[at + length :]
    path = tmp_path_factory.getbasetemp() / name
    path.write_bytes(sample)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VividcWarning)
        try:
            load(path)
        except VividcError as error:
            message = str(error)
        else:
            message = name
    assert name in message


KEYS = (
    *("nodes", "edges", "id", "op", "src", "dst", "distance", "operand", "const", "name"),
    *("schema", "source", "kind", "init", "label"),
)


@settings(max_examples=150)
@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
        lambda inner: (
            st.lists(inner, max_size=3)
            | st.dictionaries(
                st.sampled_from(KEYS),
                inner,
                max_size=6,
            )
        ),
        max_leaves=25,
    )
)
def test_any_json_value_loads_or_is_refused(value: object) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VividcWarning)
        for data in (value, {"nodes": [value], "edges": [value]}):
            with contextlib.suppress(VividcError):
                assert isinstance(from_json(data), DFG)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("g.xml", "<DFG></Outputs" + "A" * 300_000),
        ("g.xml", '<DFG><Node a="1" ' + 'b="2" ' * 100_000 + "c></DFG>"),
        ("g.xml", "<DFG><Node " + "'" * 99_999),
        ("g.dot", "#" * 300_000 + "\nx"),
        ("g.dot", "/" * 300_000 + "\nx"),
        ("g.dot", "/**/" * 100_000 + "x"),
        ("g.dot", "digraph {" + "/*" * 100_000),
        ("g.dfg", "#" * 300_000 + "\nx"),
        ("g.json", '{"nodes": "' + "\\" * 300_001),
    ],
)
def test_no_text_is_tried_in_all_ways(tmp_path: Path, name: str, text: str) -> None:
    """Each took minutes to ages while a part of it could be matched in several ways."""
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(DFGError) as raised:
        load(path)
    assert len(str(raised.value)) < 1000


def test_edges_that_name_no_operand_are_counted_once(tmp_path: Path) -> None:
    """A search from 0 for each took a minute for fifty thousand of them."""
    edges = ",".join('{"src": 1, "dst": 2}' for _ in range(50_000))
    path = tmp_path / "g.json"
    path.write_text(
        f'{{"nodes": [{{"id": 1, "op": "in"}}, {{"id": 2, "op": "x"}}], "edges": [{edges}]}}'
    )
    with pytest.warns(VividcWarning, match="unknown operation"):
        graph = load(path)
    assert max(edge.port for edge in graph.edges) == 50_001  # without those of PRED and BASE
