"""`vividc compile --dfg --plot`: each region's graph and mapping as files."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

import vividc
from vividc import dfg
from vividc.cli import main

KERNEL = """\
import vividc


@vividc.kernel("void(int32[::1], int32)")
def double(x, n):
    for i in range(n):
        x[i] *= 2
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "k.py").write_text(KERNEL)
    return tmp_path


def test_graphs_and_pictures_of_all_regions(here: Path) -> None:
    run = CliRunner().invoke(main, ["compile", "k.py", "--dfg", "graphs", "--plot", "pictures"])
    assert run.exit_code == 0
    program = vividc.load("double.vivid")
    for number, region in enumerate(program.regions):
        name = f"{number}-{region.name}"
        for ending in (".json", ".dot"):
            assert dfg.load(here / "graphs" / f"{name}{ending}") == region.dfg
        assert "<svg" in (here / "pictures" / f"{name}-dfg.svg").read_text()
        drawn = here / "pictures" / f"{name}-mapping.svg"
        assert drawn.is_file() is (region.mapping is not None)
    assert len(list((here / "graphs").iterdir())) == 2 * len(program.regions)


def test_folders_are_checked_before_anything_is_compiled(here: Path) -> None:
    run = CliRunner().invoke(main, ["compile", "k.py", "--plot", "no/such/folder"])
    assert run.exit_code == 2
    assert "--plot" in run.stderr
    run = CliRunner().invoke(main, ["compile", "k.py", "--dfg", "k.py"])
    assert run.exit_code == 2
    assert not (here / "double.vivid").exists()


def test_json_says_what_binds_with_its_operations(here: Path) -> None:
    dot = Path(__file__).parents[2] / "kernels" / "dot.py"
    run = CliRunner().invoke(main, ["compile", str(dot), "--json"])
    [loop] = [one for one in json.loads(run.stdout)["regions"] if one["kind"] == "loop"]
    binds = loop["binds"]
    assert (binds["what"], binds["bound"]) == ("the recurrence", "RecMII")
    [operation] = binds["operations"]
    [edge] = binds["edges"]
    assert operation["op"] == "fma"
    assert operation["loc"].endswith("dot.py:12")
    assert (edge["src"], edge["dst"], edge["distance"]) == (operation["id"], operation["id"], 1)
