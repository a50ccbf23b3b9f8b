"""Certificates: what is checked without a solver, and that every falsehood is noticed."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import pytest
from fabrics import grid
from graphs import GraphBuilder, accumulator, blending, chain

from vividc import arch
from vividc.dfg.forms.json_form import from_json
from vividc.errors import VividcError
from vividc.machine.opcodes import Opcode
from vividc.mapper import (
    Bound,
    Finding,
    Mapping,
    MapResult,
    Objective,
    Place,
    Refutation,
    Subject,
    check_certificate,
    map_dfg,
    mapper_names,
    read_result,
)
from vividc.mapper.bounds.refutations import (
    BY_MODEL,
    BY_SCHEDULE,
    WITHIN_ADDED,
    by_bound,
    by_contexts,
)

FABRIC = arch.load("mesh-2x2")
VERDICTS = ("confirmed", "trusted", "wrong")


def ring(length: int, distance: int = 1) -> Any:
    """A recurrence of `length` additions over `distance` iterations."""
    nodes = [{"id": number, "op": "add", "label": f"n{number}"} for number in range(length)]
    around = [{"src": n, "dst": (n + 1) % length, "operand": 0} for n in range(length)]
    around[-1]["distance"] = distance
    return from_json({"name": "ring", "nodes": nodes, "edges": around})


def checked(result: MapResult, **changes: Any) -> list[Finding]:
    assert result.subject is not None
    return list(check_certificate(replace(result, **changes), result.subject))


def wrong(findings: list[Finding]) -> str:
    return "\n".join(finding.what for finding in findings if finding.verdict == "wrong")


GRAPHS = [ring(3), ring(5, 2), chain(9), accumulator(), ring(1)]


@pytest.mark.parametrize("number", range(len(GRAPHS)))
def test_a_real_certificate_holds(number: int) -> None:
    result = map_dfg(GRAPHS[number], FABRIC, workers=1)
    findings = checked(result)
    assert wrong(findings) == ""
    assert findings[0] == Finding("confirmed", f"the mapping is legal at II {result.ii}")
    assert [f.verdict for f in findings].count("confirmed") >= 1 + len(result.bounds)


@pytest.mark.parametrize("number", range(len(GRAPHS)))
def test_no_bound_above_the_real_one_is_confirmed(number: int) -> None:
    """A bound that claims one more than its witness proves is found out."""
    result = map_dfg(GRAPHS[number], FABRIC, workers=1)
    for bound in result.bounds:
        false = (replace(bound, ii=bound.ii + 1),)
        assert f"{bound.name} {bound.ii + 1}" in wrong(checked(result, bounds=false))


@pytest.mark.parametrize("mapper", mapper_names())
@pytest.mark.parametrize("ii", [None, 1, 4, 600])
def test_what_any_mapper_says_of_an_ii_holds(mapper: str, ii: int | None) -> None:
    result = map_dfg(ring(3), FABRIC, mapper, ii, workers=1)
    assert result.status == {None: "optimal", 4: "feasible"}.get(ii, "infeasible")
    findings = checked(result)
    assert wrong(findings) == ""
    assert [found.what for found in findings if found.verdict == "trusted"] == [findings[-1].what]


def test_bounds_of_kernels_hold() -> None:
    fabric = arch.load("vivid-tile")
    result = map_dfg(blending(), fabric, workers=1)
    assert wrong(checked(result)) == ""


def test_the_bounds_of_an_fu_that_is_kept_busy_hold() -> None:
    node = ring(1).placed[0]
    slow = replace(FABRIC, occupancies={node.latency_class: 3})
    result = map_dfg(chain(5), slow, workers=1)
    assert {bound.name for bound in result.bounds} >= {"ResMII", "FU occupancy"}
    assert wrong(checked(result)) == ""
    kept = next(bound for bound in result.bounds if bound.name == "FU occupancy")
    assert "FU occupancy 4" in wrong(checked(result, bounds=(replace(kept, ii=4),)))


@pytest.mark.parametrize("name", ["openedge-3x3", "hycube-3x3", "torus-3x3"])
def test_certificates_hold_on_published_arrays(name: str) -> None:
    result = map_dfg(ring(3), arch.load(name), workers=1)
    read = MapResult.from_json(json.loads(json.dumps(result.to_json())))
    assert read == result
    assert wrong(checked(read)) == ""


def test_an_infeasible_result_holds() -> None:
    alone = map_dfg(ring(3), FABRIC, ii=2)
    assert wrong(checked(alone)) == ""
    assert "infeasible is claimed" in wrong(checked(alone, refuted=()))
    nowhere = replace(FABRIC, pes=tuple(replace(pe, classes=frozenset()) for pe in FABRIC.pes))
    impossible = map_dfg(ring(3), nowhere)
    assert impossible.status == "infeasible"
    assert wrong(checked(impossible)) == ""


def test_a_node_that_nothing_can_serve_is_confirmed() -> None:
    nodes = [{"id": number, "op": "op"} for number in range(7)]
    many = [{"src": n, "dst": 6, "distance": 0} for n in range(6)]
    g = GraphBuilder("delayed")
    total = g.op(Opcode.ADD, g.source(Opcode.IV), g.const(1))
    g.carry(total, g.op(Opcode.LIVE_OUT, name="%a"), 0, g.source(Opcode.LIVE_IN, name="%a"))
    crowded = from_json({"name": "crowded", "nodes": nodes, "edges": many})
    for dfg, name in ((crowded, "operands"), (g.build(), "live-out entry")):
        result = map_dfg(dfg, FABRIC)
        assert result.status == "infeasible"
        assert result.bounds[0].name == name
        assert {finding.verdict for finding in checked(result)[:-1]} == {"confirmed"}


RESULT = map_dfg(ring(3), FABRIC, workers=1)
LAST = max(place.time for place in RESULT.mapping.places.values()) if RESULT.mapping else -1


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"ii": 2}, "the mapping has II 3, the result says 2"),
        ({"lower_bound": 2}, "optimal is claimed at II 3 with a lower bound of 2"),
        ({"lower_bound": 5}, "nothing refutes II 3"),
        ({"mapping": None}, "II 3 is claimed without a mapping"),
        ({"mapping": None, "ii": None}, "there is no mapping"),
        ({"status": "timeout"}, "the status is timeout, but there is a mapping"),
        ({"status": "feasible"}, "feasible is claimed at II 3, but no smaller II is open"),
        ({"status": "feasible", "lower_bound": 1}, "the lower bound 1 is not the one that follows"),
        ({"refuted": (Refutation(3, "me"),)}, "II 3 is said to be refuted, and is mapped"),
        ({"refuted": (Refutation(2, "me"),)}, ""),
        ({"bounds": (Bound("moon", 3, "full"),)}, "moon 3: full (no bound of this name is known)"),
        (
            {"bounds": (Bound("moon", 3, "full"),)},
            "optimal is claimed at II 3 with a lower bound of 1",
        ),
        ({"bounds": (Bound("moon", 9, "full"),)}, "moon 9 is above the II 3 of the mapping"),
        ({"bounds": (Bound("RecMII", 3, "r", (0, 1, 2), (0,), 1),)}, "RecMII 3: r"),
        ({"bounds": (Bound("RecMII", 3, "r", (0, 1, 2), (0, 1, 99), 1),)}, "RecMII 3: r"),
        ({"bounds": (Bound("RecMII", 3, "r", (0, 1, 2), (0, 1, 2), 77),)}, "RecMII 3: r"),
        ({"bounds": (Bound("RecMII", 3, "r", (0, 1, 2), (), 77),)}, "RecMII 3: r"),
        ({"bounds": (Bound("RecMII", 3, "r", (0, 1, 2), (0, 1, 2), 1),)}, ""),
        ({"bounds": (Bound("RecMII", 3, "r", (0, 1, 2)),)}, ""),
        ({"bounds": (*RESULT.bounds, Bound("ResMII", 1, "r", (0,), (0,)))}, "edges and a distance"),
        ({"objective": Objective("hops", 9, None, None, 9)}, "hops 9: the mapping has"),
        ({"objective": Objective("beauty", 0, None, None, 9)}, "no objective is called beauty"),
        ({"objective": Objective("added objective", 0, None, None, 9)}, "nothing was added"),
        ({"objective": Objective("hops", None, None, 1, 9)}, "this one has None"),
        ({"objective": Objective("length", LAST + 1, None, LAST + 2, 9)}, "has less than"),
        ({"objective": Objective("length", LAST + 1, None, 3, LAST - 1)}, "this one issues in"),
        ({"objective": Objective("length", LAST + 1, 9, 3, LAST)}, ""),
        ({"bounds": ()}, "the lower bound 3 is given no reason: nothing refutes II 1"),
        ({"bounds": (Bound("RecMII", 3, "r", (0, 2, 1)),)}, "RecMII 3: r"),
        ({"bounds": (Bound("RecMII", 3, "r", (0, 9)),)}, "the graph has no node 9"),
        ({"bounds": (Bound("ResMII", 3, "r", (0, 0, 0, 1, 2)),)}, "ResMII 3: r"),
        ({"bounds": (Bound("control port", 3, "r", (0, 1, 2)),)}, "control port 3: r"),
        ({"bounds": (Bound("banks", 3, "r", (0, 1, 2)),)}, "banks 3: r"),
        ({"bounds": (Bound("stages", 3, "r"),)}, ""),
        ({"bounds": (Bound("stages", 4, "r"),)}, "stages 4: r"),
        ({"bounds": (Bound("lifetime", 513, "r", (0, 1)),)}, "lifetime 513: r"),
        ({"bounds": (Bound("placement", 513, "r", (0,)),)}, "placement 513: r"),
        ({"bounds": (Bound("live-out entry", 513, "r", (0,)),)}, "live-out entry 513: r"),
        ({"bounds": (Bound("operands", 513, "r", (0,)),)}, "operands 513: r"),
        ({"bounds": (Bound("operands", 513, "r", (0, 1)),)}, "operands 513: r"),
    ],
)
def test_a_false_statement_is_found(changes: dict[str, Any], what: str) -> None:
    found = wrong(checked(RESULT, **changes))
    assert what in found
    assert bool(found) == bool(what)


def test_a_moved_operation_is_found() -> None:
    assert RESULT.mapping is not None
    places = {**RESULT.mapping.places, 0: Place(0, 17)}
    moved = Mapping(3, places, RESULT.mapping.routes)
    assert "the mapping breaks a rule" in wrong(checked(RESULT, mapping=moved))


def test_what_a_solver_said_is_trusted_and_named() -> None:
    feasible = {"status": "feasible", "bounds": (), "lower_bound": 3}
    refuted = (Refutation(1, "the joint model"), Refutation(2, "the joint model"))
    findings = checked(RESULT, **feasible, refuted=refuted)
    trusted = [finding.what for finding in findings if finding.verdict == "trusted"]
    assert trusted[:2] == ["II 1 refuted by the joint model", "II 2 refuted by the joint model"]
    assert trusted[2] == "the II is at least 3"
    assert trusted[3].startswith("mapped by auto in ")
    assert len(trusted) == 4


def test_a_result_is_read_back_with_graph_and_fabric() -> None:
    document = json.loads(json.dumps(RESULT.to_json()))
    assert document["schema"] == "vividc.mapping/2"
    assert document["bounds"][0]["edges"] == [2, 0, 1] or len(document["bounds"][0]["edges"]) == 3
    assert {"python", "ortools"} <= set(document["versions"])
    read = MapResult.from_json(document)
    assert read == RESULT
    assert read.subject is not None
    assert (read.subject.dfg, read.subject.fabric) == (ring(3), FABRIC)
    assert wrong(list(check_certificate(read, read.subject))) == ""
    assert read.mapping is not None
    assert read.mapping.plot().shapes == RESULT.mapping.plot().shapes  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("graph", None, "graph: not a JSON object"),
        (
            "graph",
            {"schema": "vividc.dfg/1", "name": "x", "nodes": [{}], "edges": []},
            "id is missing",
        ),
        ("fabric_yaml", "", "not made from YAML"),
        ("fabric_yaml", "rows: [", "mapping file: fabric_yaml:1: not YAML"),
        ("fabric_yaml", 3, "not of type str"),
        ("schema", "vividc.mapping/1", "expected 'vividc.mapping/2'"),
    ],
)
def test_a_damaged_document_is_refused(key: str, value: object, message: str) -> None:
    with pytest.raises(VividcError, match=message):
        read_result({**RESULT.to_json(), key: value})


def test_a_result_without_its_graph_asks_for_it() -> None:
    with pytest.raises(VividcError, match="does not know its graph"):
        replace(RESULT, subject=None).to_json()
    about = Subject(ring(3), FABRIC)
    assert replace(RESULT, subject=None).to_json(about) == RESULT.to_json()


def test_explain_names_the_recurrence_by_its_labels() -> None:
    text = RESULT.explain()
    assert "what binds: the recurrence (RecMII)" in text
    assert "add #0 (n0)" in text


def test_explain_names_the_resource_and_its_users() -> None:
    text = map_dfg(chain(9), grid(2, 2), workers=1).explain()
    assert "what binds: the issue slots of FUs (ResMII)" in text
    assert "9 on all 4 PEs" in text


def test_explain_names_the_routing_bottleneck() -> None:
    """A value that crosses a row of PEs needs more than the bounds say."""
    refuted = replace(
        RESULT,
        status="feasible",
        lower_bound=2,
        bounds=(),
        refuted=(Refutation(1, "the joint model at a complete horizon"),),
    )
    text = refuted.explain()
    assert "what binds: places and routes; II 1 passes every bound" in text
    assert "II 2 neither mapped nor refuted" in text
    assert "fullest in this mapping: the FU of PE" in text


@pytest.mark.parametrize(
    ("by", "binds"),
    [
        (BY_MODEL, "places and routes; II 9 passes every bound and cannot be routed"),
        (BY_MODEL + WITHIN_ADDED, "places and routes within the added constraints; II 9"),
        (BY_SCHEDULE, "dependences and resources together; II 9 has no schedule"),
        (by_contexts(8), "the configuration memory of 8 contexts"),
        (by_bound(10), "the recurrence (RecMII)"),
    ],
)
def test_explain_names_what_refuted_the_only_ii(by: str, binds: str) -> None:
    """The bounds may be far below an II that was asked for."""
    refuted = (Refutation(9, by),)
    result = replace(RESULT, status="infeasible", ii=None, mapping=None, refuted=refuted)
    assert f"what binds: {binds}" in result.explain()


def test_explain_blames_no_bound_of_1() -> None:
    """An II of 1 needs no reason; neither does a search that ended without a mapping."""
    assert "what binds" not in map_dfg(chain(3), FABRIC, workers=1).explain()
    assert (
        "what binds"
        not in replace(
            RESULT, status="timeout", ii=None, mapping=None, lower_bound=1, bounds=()
        ).explain()
    )
