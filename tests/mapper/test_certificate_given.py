"""Certificates of problems of which something was decided before: PEs allowed, words resident."""

from __future__ import annotations

import json
from typing import Any

import pytest
from fabrics import grid
from graphs import GraphBuilder, accumulator

from vividc import arch
from vividc.dfg.forms.json_form import from_json
from vividc.errors import VividcError
from vividc.machine.opcodes import Opcode
from vividc.mapper import MapResult, Subject, check_certificate, map_dfg, mapping_from_json

FABRIC = arch.load("mesh-2x2")
ALONE = from_json(
    {"name": "alone", "nodes": [{"id": n, "op": "op"} for n in range(3)], "edges": []}
)


def written(result: MapResult) -> Any:
    return json.loads(json.dumps(result.to_json()))


def wrong(result: MapResult, subject: Subject | None = None) -> list[str]:
    about = subject or result.subject
    assert about is not None
    return [str(found) for found in check_certificate(result, about) if found.verdict == "wrong"]


def test_a_result_within_allowed_pes_holds() -> None:
    """Found by a user: `vividc verify` called it wrong, since the file did not say so."""
    result = map_dfg(ALONE, FABRIC, allowed={n: frozenset({0}) for n in range(3)}, workers=1)
    assert (result.status, result.ii) == ("optimal", 3)
    read = MapResult.from_json(written(result))
    assert (read, read.subject) == (result, result.subject)
    assert wrong(read) == []
    assert "ResMII 3" in wrong(read, Subject(ALONE, FABRIC))[0]


def test_a_node_that_may_lie_nowhere_is_confirmed_infeasible() -> None:
    result = map_dfg(ALONE, FABRIC, allowed={0: frozenset()})
    assert result.status == "infeasible"
    assert wrong(MapResult.from_json(written(result))) == []
    assert wrong(result, Subject(ALONE, FABRIC)) != []


def test_a_mapping_outside_the_allowed_pes_is_wrong() -> None:
    document = written(map_dfg(ALONE, FABRIC, allowed={0: frozenset({2})}, workers=1))
    document["allowed"] = [{"node": 0, "pes": [1]}]
    assert "not permitted" in wrong(MapResult.from_json(document))[0]


def test_resident_constants_count_and_are_kept() -> None:
    g = GraphBuilder("sum")
    g.op(Opcode.ADD, g.const(7), g.source(Opcode.LIVE_IN, name="%a"))
    dfg, fabric = g.build(), grid(1, 1, constants=2)
    held = frozenset({("const", 7), ("const", 8), ("live_in", "%b")})
    full = map_dfg(dfg, fabric, resident={0: held})
    assert full.status == "infeasible"
    known = map_dfg(dfg, fabric, resident={0: held | {("live_in", "%a")}}, workers=1)
    assert (known.status, known.ii) == ("optimal", 1)
    for result in (full, known):
        read = mapping_from_json(written(result), dfg, fabric)
        assert read.subject == result.subject
        assert wrong(read) == []


def test_a_file_from_before_is_read() -> None:
    document = written(map_dfg(accumulator(), FABRIC, workers=1))
    del document["allowed"], document["resident"]
    read = MapResult.from_json(document)
    assert read.subject == Subject(accumulator(), FABRIC)
    assert wrong(read) == []


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("allowed", None, "allowed: missing, or not a list"),
        ("allowed", {"0": [0]}, "allowed: missing, or not a list"),
        ("allowed", [3], r"allowed\[0\]: not a JSON object"),
        ("allowed", [{"node": 77, "pes": [0]}], r"allowed\[0\].node: the graph has no node 77"),
        ("allowed", [{"node": 0, "pes": [4]}], r"allowed\[0\].pes: the fabric has no PE 4"),
        ("allowed", [{"node": 0, "pes": [True]}], r"allowed\[0\].pes: not a list of integers"),
        ("allowed", [{"node": 0, "pes": []}] * 2, r"allowed\[1\].node: node 0 is there already"),
        ("resident", [{"pe": -1, "entries": []}], r"resident\[0\].pe: the fabric has no PE -1"),
        ("resident", [{"pe": 0}], r"resident\[0\].entries: missing, or not a list"),
        ("resident", [{"pe": 0, "entries": [{}]}], r"resident\[0\].entries\[0\].entry: neither"),
        ("resident", [{"pe": 0, "entries": [{"const": "7"}]}], r"entries\[0\].const: missing, or"),
        ("resident", [{"pe": 0, "entries": [{"live_in": 7}]}], r"entries\[0\].live_in: missing"),
    ],
)
def test_what_was_given_is_checked_when_read(key: str, value: object, message: str) -> None:
    document = written(map_dfg(ALONE, FABRIC, workers=1))
    with pytest.raises(VividcError, match=f"mapping file: .*{message}") as caught:
        MapResult.from_json({**document, key: value})
    assert caught.value.hint == "write the mapping anew with `vividc map`"
