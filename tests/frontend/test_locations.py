"""Source lines survive, however the file was named when Python compiled it."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from pathlib import Path

import numba
import numpy as np
import pytest

from vividc.errors import VividcWarning
from vividc.frontend import KernelFunction
from vividc.frontend.llvm.metadata import Locations

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


@numba.njit
def tenth(v):
    return v * 0.1  # here


def power_of_an_array(x, n):
    x[1:] = np.power(x[1:], 2.5)  # here


def expression_of_arrays(x, n):
    y = x[1:]
    x[1:] = y**2.5 + np.sin(np.arange(7))  # here


def where(x, n):
    x[:] = np.where(x > 0.1, x, 0.3)  # here


def mean_of_integers(x, n):
    x[0] = np.mean(x.astype(np.int32))  # here


def over_lines(x, n):
    for i in range(n):
        x[i] = (
            x[i] * 0.1  # here: the line of the operand, or of the statement
        )


def in_a_helper(x, n):
    x[0] = tenth(x[1])


@pytest.mark.parametrize(
    "function",
    [power_of_an_array, expression_of_arrays, where, mean_of_integers, over_lines, in_a_helper],
    ids=lambda function: function.__name__,
)
def test_a_warning_names_the_line_of_the_kernel(function: Callable[..., object]) -> None:
    with pytest.warns(VividcWarning) as told:
        KernelFunction(function, "void(float32[::1], int32)", None).lower()
    lines, first = inspect.getsourcelines(tenth.py_func if function is in_a_helper else function)
    expected = first + next(number for number, line in enumerate(lines) if "# here" in line)
    for warning in told:
        match = re.match(r"(.+):(\d+): ", str(warning.message))
        assert match is not None
        assert Path(match[1]).resolve() == Path(__file__).resolve()
        assert int(match[2]) in range(expected - (function is over_lines), expected + 1)
