"""Lines in the IR of our numba target: numba's own, without the rest of its debug information."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba.core import types
from numba.core.lowering import get_func_body_first_lineno

from vividc.frontend.numba import lines
from vividc.frontend.numba.target import numba_module


def plain(a):
    a[0] = 1.0


def of_one_line(a): a[0] = 1.0  # fmt: skip


def documented(a):
    """What it does.

    At length.
    """

    a[0] = 1.0


@functools.cache
@functools.wraps(plain)
def decorated(
    a,
):
    # A comment.
    return (
        a
        + 1
    )  # fmt: skip


def outer() -> Callable[..., Any]:
    def plain(a):

        a[0] = 2.0

    return plain


def in_two_lines(a, b, n):
    for i in range(n):
        b[i] = a[i] + a[i] * a[i]
    b[0] = b[1] + np.sum(a)


FUNCTIONS = [plain, of_one_line, documented, decorated.__wrapped__, outer, outer(), in_two_lines]


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda f: f.__qualname__)
def test_the_first_statement_is_where_numba_finds_it(function: Any) -> None:
    assert lines.first_line(function) == get_func_body_first_lineno(function)


def test_a_file_is_parsed_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "three.py"
    file.write_text("".join(f"def f{n}(a):\n\n    a[0] = {n}\n" for n in range(3)))
    names: dict[str, Any] = {}
    exec(compile(file.read_text(), str(file), "exec"), names)
    parsed: list[str] = []
    parse = lines.ast.parse
    monkeypatch.setattr(lines.ast, "parse", lambda text: parsed.append(text) or parse(text))
    assert [lines.first_line(names[f"f{n}"]) for n in range(3)] == [3, 6, 9]
    assert len(parsed) == 1


def test_what_has_no_file_is_left_to_numba() -> None:
    names: dict[str, Any] = {}
    exec(compile("def made(a):\n    a[0] = 1.0\n", "<no file>", "exec"), names)
    assert lines.first_line(names["made"]) is None


def test_functions_have_lines_and_no_types() -> None:
    array = types.Array(types.float32, 1, "C")
    text = "\n".join(numba_module(in_two_lines, (array, array, types.int32), types.none).texts)
    begin = in_two_lines.__code__.co_firstlineno
    assert "DISubprogram" in text
    assert not re.search("DIBasicType|DICompositeType|DIDerivedType", text)
    for line in (begin + 1, begin + 2, begin + 3):
        assert len(re.findall(rf"!DILocation\([^)]*line: {line}\D", text)) == 1
