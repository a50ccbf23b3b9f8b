"""Source lines survive, however the file was named when Python compiled it."""

from __future__ import annotations

from pathlib import Path

import pytest

from vividc.frontend.llvm_text import Locations

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


NODES = """
!1 = !DIFile(filename: "k.c", directory: "/src")
!2 = distinct !DISubprogram(name: "f", scope: !1, file: !1, line: 7)
!3 = !DILocation(line: 8, column: 1, scope: !5)
!5 = !DILexicalBlock(scope: !2, file: !1, line: 7)
"""


@pytest.mark.parametrize(
    ("old", "new", "place"),
    [
        ("", "", "/src/k.c:8"),
        ("scope: !2, file: !1", "scope: !2", "/src/k.c:8"),
        ("scope: !2, file: !1", "scope: !2, file: !3", None),
        ("scope: !2, file: !1", "scope: !5", None),
        ("scope: !5", "scope: !99", None),
        ("scope: !5", "scope: !5, inlinedAt: !3", "/src/k.c:8"),
        ("line: 8", "line: 0", None),
        ("line: 8", f"line: {'9' * 5000}", None),
        ("line: 8, ", "", None),
        ('filename: "k.c", ', "", None),
    ],
)
def test_nodes_of_lines_may_point_anywhere(old: str, new: str, place: str | None) -> None:
    """LLVM reads modules whose places lead nowhere, or in a circle."""
    assert old in NODES
    found = Locations(NODES.replace(old, new), "k.ll")("ret void, !dbg !3")
    assert (found and str(found)) == place
