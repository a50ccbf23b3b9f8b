"""The mappers' table goes on where an earlier run stopped, and says what it measured."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from benchmarks import mappers

GRAPH = {
    "name": "pair",
    "nodes": [{"id": 0, "op": "add"}, {"id": 1, "op": "add"}],
    "edges": [{"src": 0, "dst": 1, "distance": 0}, {"src": 1, "dst": 1, "distance": 1}],
}


@pytest.fixture
def output(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    graphs = tmp_path / "graphs"
    graphs.mkdir()
    (graphs / "pair.json").write_text(json.dumps(GRAPH), encoding="utf-8")
    monkeypatch.setenv(mappers.FOLDER_VARIABLE, str(graphs))
    return tmp_path


def rows(output: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in (output / mappers.ROWS).read_text().splitlines()]


def test_a_row_is_measured_once(output: Path) -> None:
    first = list(mappers.sections(["mesh-2x2"], ["cpsat"], 20, output))
    (row,) = rows(output)
    assert (row["graph"], row["mapper"]) == ("pair", "cpsat")
    assert (row["ii"], row["status"]) == (1, "optimal")
    memory = row["most_mb"]
    assert memory is None or (isinstance(memory, int) and memory > 10)
    again = list(mappers.sections(["mesh-2x2"], ["cpsat", "ims"], 20, output))
    assert [r["mapper"] for r in rows(output)] == ["cpsat", "ims"]
    assert len(first[-1]) < len(again[-1])


def test_another_limit_is_another_measurement(output: Path) -> None:
    for limit in (20, 21):
        list(mappers.sections(["mesh-2x2"], ["cpsat"], limit, output))
    assert [row["time_limit_s"] for row in rows(output)] == [20, 21]


def test_a_refusal_is_a_row(output: Path) -> None:
    *_, table = mappers.sections(["openedge-2x2"], ["ims"], 20, output)
    assert "refused" in table[-2]


def test_the_summary_counts(output: Path) -> None:
    *_, table = mappers.sections(["mesh-2x2"], ["cpsat"], 20, output)
    (line,) = (line for line in table if line.startswith("| cpsat |"))
    cells = [cell.strip() for cell in line.split("|")]
    assert cells[2:7] == ["20", "1", "1", "1", "1"]
    assert cells[8:10] == ["1 of 1", "1 of 1"]


def test_the_table_holds_all_rows_that_were_kept(output: Path) -> None:
    list(mappers.sections(["mesh-2x2"], ["cpsat"], 20, output))
    *_, table = mappers.sections(["mesh-1x2"], ["ims"], 10, output)
    assert [line for line in table if line.startswith("## ")] == ["## mesh-2x2", "## mesh-1x2"]
    assert any(line.startswith("| pair | 2 | cpsat | 20 | 1 |") for line in table)


def test_the_load_that_rows_were_measured_under_is_said(
    output: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "getloadavg", lambda: (6.0, 6.0, 6.0))
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    *_, table = mappers.sections(["mesh-2x2"], ["cpsat"], 20, output)
    assert "Load of the 2 cores when rows began: 6.0 on average, 6.0 at most." in table
    assert any(line.startswith("Seconds are about 3.0 times") for line in table)


def test_no_graphs_are_said_to_be_none(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv(mappers.FOLDER_VARIABLE, str(tmp_path))
    ((line,),) = mappers.sections(["mesh-2x2"], [], 1, None)
    assert mappers.FOLDER_VARIABLE in line
