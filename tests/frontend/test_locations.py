"""Source lines survive, however the file was named when Python compiled it."""

from __future__ import annotations

from pathlib import Path

import pytest

SOURCE = """import vividc


@vividc.kernel("void(float32[::1], float32[::1])")
def double(x, y):
    for i in range(len(x)):
        y[i] = x[i] + x[i]
"""


@pytest.mark.parametrize("relative", [True, False])
def test_lines_survive(relative: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "k.py"
    path.write_text(SOURCE, encoding="utf-8")
    scope: dict[str, object] = {"__name__": "k"}
    exec(compile(SOURCE, "k.py" if relative else str(path), "exec"), scope)
    function = scope["double"].lower()  # type: ignore[attr-defined]
    lines = {instr.loc.line for block in function.blocks for instr in block.instrs if instr.loc}
    assert lines == {6, 7}
    assert function.file == str(path)
