"""`vividc verify`: what `map -o` wrote holds, and a damaged file does not."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from vividc.cli import main

RING = "digraph ring { a [op=add]; b [op=mul]; a -> b [distance=0]; b -> a [distance=1]; }"


def run(*args: object) -> Result:
    return CliRunner().invoke(main, [str(arg) for arg in args])


@pytest.fixture
def mapping(tmp_path: Path) -> Path:
    (tmp_path / "ring.dot").write_text(RING)
    path = tmp_path / "m.json"
    picture = tmp_path / "m.png"
    done = run(
        *("map", tmp_path / "ring.dot", "--fabric", "mesh-2x2", "-o", path, "--plot", picture)
    )
    assert done.exit_code == 0, done.stderr
    assert picture.read_bytes().startswith(b"\x89PNG")
    return path


def damage(path: Path, change: Any) -> None:
    document = json.loads(path.read_text())
    change(document)
    path.write_text(json.dumps(document))


def test_what_map_wrote_is_confirmed(mapping: Path) -> None:
    done = run("verify", mapping)
    assert done.exit_code == 0, done.stderr
    assert "ring on mesh-2x2: optimal at II 2" in done.stdout
    assert "confirmed: the mapping is legal at II 2" in done.stdout
    assert "confirmed: RecMII 2" in done.stdout
    assert done.stdout.endswith("nothing in the file is wrong\n")


def test_json_and_another_graph_or_fabric(mapping: Path) -> None:
    graph = mapping.parent / "ring.dot"
    done = run("verify", mapping, "--dfg", graph, "--fabric", "mesh-2x2", "--json")
    out = json.loads(done.stdout)
    assert (out["schema"], out["valid"], out["ii"]) == ("vividc.verify/1", True, 2)
    graph.write_text(RING.replace("distance=1", "distance=2"))
    assert run("verify", mapping, "--dfg", graph).exit_code == 5
    other = run("verify", mapping, "--fabric", "mesh-3x3")
    assert other.exit_code == 2
    assert "made for 'mesh-2x2', not for 'mesh-3x3'" in other.stderr


@pytest.mark.parametrize(
    ("change", "what"),
    [
        (lambda d: d["mapping"]["places"][0].update(time=9), "wrong: the mapping breaks a rule"),
        (lambda d: d["bounds"][0].update(ii=3), "wrong: RecMII 3"),
        (lambda d: d.update(lower_bound=1), "wrong: optimal is claimed at II 2"),
        (lambda d: d["graph"]["edges"][1].update(distance=2), "wrong: RecMII 2"),
        (lambda d: d["bounds"][0].update(name="foo", ii=1000), "wrong: foo 1000: "),
        (
            lambda d: d["bounds"][0].update(name="foo"),
            "wrong: the lower bound 2 is given no reason",
        ),
        (lambda d: d["bounds"][0].update(distance=77), "wrong: RecMII 2"),
        (lambda d: d["bounds"][0].update(edges=[0]), "wrong: RecMII 2"),
        (lambda d: d.update(refuted=[{"ii": 2, "by": "me"}]), "wrong: II 2 is said to be refuted"),
        (lambda d: d.update(status="feasible"), "wrong: feasible is claimed"),
    ],
)
def test_a_changed_file_is_wrong_and_exit_code_5(mapping: Path, change: Any, what: str) -> None:
    damage(mapping, change)
    done = run("verify", mapping)
    assert done.exit_code == 5
    assert what in done.stdout
    assert done.stdout.endswith("the file is wrong\n")


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("{", "m.json:1: not JSON"),
        ("[]", "not a JSON object"),
        ("{}", "expected 'vividc.mapping/2', found None"),
        ("[" * 100_000, "not a mapping file"),
        ("\x00", "not JSON"),
    ],
)
def test_a_file_of_another_kind_is_exit_code_2(mapping: Path, text: str, what: str) -> None:
    mapping.write_text(text)
    done = run("verify", mapping)
    assert (done.exit_code, done.stdout) == (2, "")
    assert what in done.stderr


def test_plot_checks_its_ending_first(mapping: Path) -> None:
    graph = mapping.parent / "ring.dot"
    done = run("map", graph, "--plot", mapping.parent / "p.pdf")
    assert done.exit_code == 2
    assert "--plot: the ending '.pdf' names no picture format" in done.stderr


def test_unknown_operations_can_be_refused(tmp_path: Path) -> None:
    path = tmp_path / "g.dot"
    path.write_text("digraph { a [op=zap]; }")
    lenient = run("map", path, "--fabric", "mesh-2x2")
    assert lenient.exit_code == 0
    assert "warning: " in lenient.stderr
    assert "unknown operation 'zap' (node a)" in lenient.stderr
    strict = run("map", path, "--fabric", "mesh-2x2", "--unknown-ops", "refuse")
    assert strict.exit_code == 2
    assert "unknown operation 'zap' (node a)" in strict.stderr


def test_a_file_of_another_kind_is_named(tmp_path: Path) -> None:
    path = tmp_path / "graph.json"
    path.write_text(json.dumps({"name": "g", "nodes": [{"id": 0, "op": "add"}], "edges": []}))
    done = run("verify", path)
    assert done.exit_code == 2
    assert f"{path}: schema: expected 'vividc.mapping/" in done.stderr


def test_a_mistake_in_the_fabric_of_a_mapping_file_names_the_file(mapping: Path) -> None:
    damage(mapping, lambda d: d.update(fabric_yaml="name: ring\nrows: many"))
    done = run("verify", mapping)
    assert done.exit_code == 2
    assert f"vividc: {mapping}: fabric_yaml:2: `rows`" in done.stderr


def test_a_reason_is_no_evidence_and_not_repeated(mapping: Path) -> None:
    damage(mapping, lambda d: d["bounds"][0].update(reason="it is well known"))
    done = run("verify", mapping)
    assert done.exit_code == 0
    assert "confirmed: RecMII 2: 2 cycles over distance 1: add #0 (a) -> mul #1 (b)" in done.stdout
    assert "well known" not in done.stdout


def test_added_constraints_are_told(mapping: Path) -> None:
    damage(mapping, lambda d: d.update(constrained=True))
    done = run("verify", mapping)
    assert "ring on mesh-2x2: optimal within the added constraints at II 2" in done.stdout
    assert "trusted: constraints were added that are not in the result" in done.stdout
    assert json.loads(run("verify", mapping, "--json").stdout)["constrained"] is True


def test_what_was_given_is_told(mapping: Path) -> None:
    damage(mapping, lambda d: d.update(allowed=[{"node": 0, "pes": [0, 1, 2, 3]}]))
    done = run("verify", mapping)
    assert done.exit_code == 0
    assert "optimal at II 2 (nodes whose PEs were given: 1)" in done.stdout


def test_a_key_that_is_there_twice_is_refused(mapping: Path) -> None:
    text = mapping.read_text()
    mapping.write_text(text.replace('"ii": 2', '"ii": 1, "ii": 2', 1))
    done = run("verify", mapping)
    assert (done.exit_code, done.stdout) == (2, "")
    assert f"{mapping}: the key 'ii' is there twice" in done.stderr
