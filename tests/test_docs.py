"""Every how-to runs: its Python blocks and shell blocks, in order, in an empty folder."""

from __future__ import annotations

import json
import os
import re
import runpy
import shlex
import subprocess
import sys
import warnings
from pathlib import Path

import pytest
from click.testing import CliRunner

import vividc
from vividc.cli.main import main

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted(
    page
    for page in (ROOT / "docs").glob("*.md")
    if re.search(r"```(python|sh)\n", page.read_text())
)

PLAIN_COMMAND = re.compile(r"^(vividc [^|><;&$*?{~`\\\n]+\n)", re.MULTILINE)
"""A line that only starts vividc: it needs no shell."""
SLOW = {"gemm", "known-sizes", "mappers", "render-your-own"}
"""Pages that compile or map for long: all of a renderer, products in every mode and for known
sizes, one graph by all mappers.
"""


def blocks(page: Path) -> list[tuple[str, str]]:
    """(language, text) of the page's fenced Python and shell blocks."""
    return re.findall(r"```(python|sh)\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, id=page.stem, marks=[pytest.mark.slow] if page.stem in SLOW else [])
        for page in PAGES
    ],
)
def test_how_to_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In this process: importing vividc for each block takes longer than most blocks. Limits are of
    effort: a busy machine has the time it needs.
    """
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}{os.pathsep}{ROOT}")
    monkeypatch.setenv("PATH", str(Path(sys.executable).parent), prepend=os.pathsep)
    monkeypatch.setenv(
        "VIVIDC_CACHE_PROGRAMS", "1"
    )  # pages compile the same for a command and a block
    before = set(sys.modules)
    try:
        with vividc.patient(20), warnings.catch_warnings():
            warnings.simplefilter("default")
            for language, text in blocks(page):
                run_block(language, text)
    finally:
        for name in set(sys.modules) - before:
            if Path(getattr(sys.modules[name], "__file__", None) or "/").is_relative_to(tmp_path):
                del sys.modules[name]


def test_the_first_block_of_the_readme_runs_as_it_stands(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    language, text = blocks(ROOT / "README.md")[0]
    assert language == "python"
    (tmp_path / "first.py").write_text(text, encoding="utf-8")
    with vividc.patient(20):
        runpy.run_path(str(tmp_path / "first.py"))
    assert re.match(r"\d+ cycles; <Program saxpy\(a, x, y\)", capsys.readouterr().out)


def test_the_version_is_the_same_everywhere() -> None:
    assert f"\nversion: {vividc.__version__}\n" in (ROOT / "CITATION.cff").read_text()
    assert f"\n## {vividc.__version__}" in (ROOT / "CHANGELOG.md").read_text()


def run_block(language: str, text: str) -> None:
    """Run a block, or write the file that it names. Each Python block has its own names."""
    named = re.match(r"# file: (\S+)\n", text)
    print(text)
    if named:
        Path(named.group(1)).write_text(text, encoding="utf-8")
    elif language == "python":
        exec(compile(text, "<string>", "exec"), {"__name__": "__main__"})
    else:
        for part in re.split(PLAIN_COMMAND, text):
            if re.fullmatch(PLAIN_COMMAND, part):
                done = CliRunner().invoke(main, shlex.split(part)[1:])
                assert done.exit_code == 0, done.output
            elif part.strip():
                subprocess.run(["bash", "-ec", part], stdin=subprocess.DEVNULL, check=True)


NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
SLOW_NOTEBOOKS = {"frame"}
"""What compiles a renderer's kernels."""


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(p, id=p.stem, marks=[pytest.mark.slow] if p.stem in SLOW_NOTEBOOKS else [])
        for p in NOTEBOOKS
    ],
)
def test_notebook_runs(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its cells in order, as they are: without what a run would leave in the file."""
    monkeypatch.chdir(path.parent)
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    assert [cell["cell_type"] for cell in cells][:2] == ["markdown", "code"]
    names: dict[str, object] = {}
    with vividc.patient(20):
        for cell in cells:
            if cell["cell_type"] == "code":
                assert cell["outputs"] == []
                assert cell["execution_count"] is None
                exec(compile("".join(cell["source"]), f"{path.name}:{cell['id']}", "exec"), names)
