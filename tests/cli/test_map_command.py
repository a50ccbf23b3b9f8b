"""`vividc map` says what was proved, and its exit code says the same."""

import json
from contextlib import contextmanager

import pytest
from click.testing import CliRunner

from vividc import arch, dfg
from vividc.cli import main
from vividc.cli.commands import map as map_command
from vividc.mapper import MapResult, map_dfg, mapping_from_json, registry, verify

CHAIN = {
    "name": "chain",
    "nodes": [{"id": i, "op": op} for i, op in enumerate(["add", "mul", "sub"])],
    "edges": [
        {"src": 0, "dst": 1, "distance": 0},
        {"src": 1, "dst": 2, "distance": 0},
        {"src": 2, "dst": 0, "distance": 1},
    ],
}


@pytest.fixture
def graph(tmp_path):
    path = tmp_path / "chain.json"
    path.write_text(json.dumps(CHAIN))
    return path


def run(*args):
    return CliRunner().invoke(main, ["map", *map(str, args)])


def test_json_object(graph):
    result = run(graph, "--fabric", "mesh-2x2", "--json")
    assert result.exit_code == 0, result.stderr
    out = json.loads(result.stdout)
    assert out["schema"] == "vividc.map/1"
    assert (out["dfg"], out["fabric"], out["status"]) == ("chain", "mesh-2x2", "optimal")
    assert (out["ii"], out["lower_bound"], out["output"]) == (3, 3, None)
    assert out["interrupted"] is False
    assert (out["bounds"][0]["ii"], sorted(out["bounds"][0]["nodes"])) == (3, [0, 1, 2])
    assert (out["operations"], out["pes"]) == (3, 4)
    assert out["binding"] == {"what": "the recurrence", "bound": "RecMII", "refuted_ii": None}
    assert out["fullest"] is None
    assert out["utilization"] == pytest.approx(3 / 12)


def test_the_use_counts_fus_that_are_kept_busy(graph, tmp_path):
    slow = tmp_path / "slow.yaml"
    slow.write_text("extends: mesh-2x2\noccupancy: {imul: 3}\n")
    out = json.loads(run(graph, "--fabric", slow, "--json").stdout)
    assert out["utilization"] == pytest.approx((1 + 3 + 1) / (4 * out["ii"]))


def test_json_names_what_is_fullest_where_the_ii_is_above_the_bounds(graph):
    done = run(graph, "--fabric", "mesh-2x2", "--ii", 5)
    out = json.loads(run(graph, "--fabric", "mesh-2x2", "--ii", 5, "--json").stdout)
    assert (out["ii"], out["lower_bound"]) == (5, 3)
    fu = out["fullest"]["fu"]
    assert set(out["fullest"]) == {"fu", "link", "file"}
    assert f"the FU of PE {fu['pe']} is taken in {fu['slots']} of 5 slots" in done.stdout


def test_mapping_file_reads_back_as_a_legal_mapping(graph, tmp_path):
    path = tmp_path / "m.json"
    result = run(graph, "--fabric", "mesh-2x2", "-o", path)
    assert result.exit_code == 0, result.stderr
    the_dfg, fabric = dfg.load(graph), arch.load("mesh-2x2")
    read = mapping_from_json(json.loads(path.read_text()), the_dfg, fabric)
    assert verify(the_dfg, fabric, read.mapping) == []


def test_a_picture_that_cannot_be_made_loses_nothing_else(graph, tmp_path):
    path, picture = tmp_path / "m.json", tmp_path / "p.png"
    result = run(
        *(graph, "--fabric", "mesh-2x2", "--ii", 300),
        *("-o", path, "--plot", picture, "--json"),
    )
    assert result.exit_code == 2
    out = json.loads(result.stdout)
    assert (out["ii"], out["output"]) == (300, str(path))
    assert json.loads(path.read_text())["mapping"] == out["mapping"]
    assert result.stderr.startswith(f"vividc: {picture}: a picture of ")
    assert result.stderr.endswith("hint: write it as SVG, to a name that ends in .svg\n")
    assert not picture.exists()


def test_an_interrupt_keeps_the_best_mapping(graph, tmp_path, monkeypatch):
    @contextmanager
    def progress(start):
        def tell(line):
            if line.endswith("mapped"):
                raise KeyboardInterrupt

        yield tell

    monkeypatch.setattr(map_command, "progress", progress)
    path = tmp_path / "m.json"
    result = run(graph, "--fabric", "mesh-2x2", "-o", path, "--json")
    assert (result.exit_code, result.stderr) == (130, "vividc: interrupted\n")
    out = json.loads(result.stdout)
    assert (out["interrupted"], out["ii"], out["output"]) == (True, 3, str(path))
    the_dfg, fabric = dfg.load(graph), arch.load("mesh-2x2")
    read = mapping_from_json(json.loads(path.read_text()), the_dfg, fabric)
    assert verify(the_dfg, fabric, read.mapping) == []


def test_table_for_people(graph):
    result = run(graph, "--fabric", "mesh-2x2")
    assert "chain on mesh-2x2" in result.stdout
    assert "RecMII" in result.stdout
    assert result.stderr == ""


def test_infeasible_is_exit_code_3_and_writes_nothing(graph, tmp_path):
    path = tmp_path / "m.json"
    result = run(graph, "--fabric", "mesh-2x2", "--ii", 2, "-o", path, "--json")
    assert result.exit_code == 3
    out = json.loads(result.stdout)
    assert (out["status"], out["mapping"], out["output"]) == ("infeasible", None, None)
    assert result.stderr.startswith("vividc: chain: proved infeasible at II 2")
    assert not path.exists()


def test_a_mapper_that_gives_up_does_not_ask_for_more_time(graph, monkeypatch):
    def idle(problem, request):
        return MapResult("timeout", None, 1, (), None, "idle", 0.1)

    monkeypatch.setitem(registry.BUILT_IN, "idle", idle)
    result = run(graph, "--mapper", "idle", "--time-limit", 8, "--ii", 5)
    assert result.exit_code == 4
    assert "mapper 'idle' gave up after 0.1 s without a mapping at II 5" in result.stderr
    assert "--time-limit" not in result.stderr


@pytest.mark.parametrize(
    ("args", "text"),
    [
        (["--fabric", "nothing"], "unknown fabric `nothing`"),
        (["--mapper", "nothing"], "unknown mapper"),
        (["-o", "/nonexistent/m.json"], "--output: the folder `/nonexistent` does not exist"),
        (["--time-limit", "nan"], "nan is not a finite number"),
    ],
)
def test_wrong_input_is_exit_code_2(graph, args, text):
    result = run(graph, *args)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert text in result.stderr


def test_broken_graph_names_its_line(tmp_path):
    path = tmp_path / "broken.json"
    path.write_text('{"name": "x",\n "nodes": [}')
    result = run(path)
    assert result.exit_code == 2
    assert f"{path}:2" in result.stderr


def test_the_effort_reaches_the_search(graph, monkeypatch):
    asked = []

    def mapped(*args, effort, **how):
        asked.append(effort)
        return map_dfg(*args, effort=effort, **how)

    monkeypatch.setattr(map_command, "map_dfg", mapped)
    for given in ([], ["--effort", "fast"], ["--effort", "normal"]):
        assert run(graph, "--fabric", "mesh-2x2", *given).exit_code == 0
    assert asked == ["prove", "fast", "normal"]
    assert run(graph, "--effort", "all").exit_code == 2
