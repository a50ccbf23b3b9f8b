"""Every how-to runs: its Python blocks and shell blocks, in order, in an empty folder."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted(
    page
    for page in (ROOT / "docs").glob("*.md")
    if re.search(r"```(python|sh)\n", page.read_text())
)

RUN_PAGE = r"""
import json, re, subprocess, sys
for language, text in json.load(sys.stdin):
    named = re.match(r"# file: (\S+)\n", text)
    if named:
        with open(named.group(1), "w", encoding="utf-8") as file:
            file.write(text)
        continue
    print(text, flush=True)
    if language == "sh":
        subprocess.run(["bash", "-ec", text], stdin=subprocess.DEVNULL, check=True)
    else:
        exec(compile(text, "<string>", "exec"), {"__name__": "__main__"})
"""
"""Each Python block has its own names."""
SLOW = {"render-your-own"}
"""Pages that compile all kernels of a renderer, which takes minutes."""


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
def test_how_to_runs(page: Path, tmp_path: Path) -> None:
    """In one process a page: importing vividc for each block takes longer than most blocks."""
    bin_folder = str(Path(sys.executable).parent)
    environment = os.environ | {
        "PATH": f"{bin_folder}{os.pathsep}{os.environ['PATH']}",
        "PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}",
    }
    done = subprocess.run(
        [sys.executable, "-c", RUN_PAGE],
        input=json.dumps(blocks(page)),
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, f"{page.name}:\n{done.stdout}\n{done.stderr}"
