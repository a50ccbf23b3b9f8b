"""Names and values of users in messages: one line, no control characters, not too long."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

import vividc
from vividc.cli import main
from vividc.errors import VividcError, VividcWarning, printable, quoted

NAME = "a\nb\x1b[31mred"
SHOWN = r"a\nb\x1b[31mred"


@pytest.mark.parametrize(
    ("text", "shown"),
    [("add_1 \u65e5 \u2192", "add_1 \u65e5 \u2192"), (NAME, SHOWN), ("\x9b\u202e", r"\x9b\u202e")],
)
def test_control_characters_are_escapes(text: str, shown: str) -> None:
    assert printable(text) == shown


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        ("abc", "'abc'"),
        ("a" * 30, "'aaaaaaaaaaaaaaa...'"),
        (list(range(30)), "[0, 1, 2, 3, 4, ...]"),
        (10**30, "10000000000000000..."),
        (10**5000, "a number of too many digits"),
    ],
    ids=["short", "text", "list", "number", "long number"],
)
def test_a_value_keeps_its_closing_mark(value: object, shown: str) -> None:
    assert quoted(value, 20) == shown


def test_no_name_of_a_graph_reaches_the_terminal_raw(tmp_path: Path) -> None:
    node = {"id": NAME, "op": NAME}
    loop = {"src": NAME, "dst": NAME, "distance": 1}
    path, mapping = tmp_path / "g.json", tmp_path / "m.json"
    damaged = [{**loop, "src": NAME + "z"}, {**loop, "distance": 0}]
    runs = [
        ("map", path, "--fabric", "mesh-2x2", "-o", mapping),
        ("verify", mapping),
        ("map", path, "--fabric", "mesh-2x2", "--ii", "999"),
    ]
    printed = ""
    for edge, commands in ((loop, runs), *((edge, runs[:1]) for edge in damaged)):
        path.write_text(json.dumps({"name": NAME, "nodes": [node], "edges": [edge]}))
        for command in commands:
            done = CliRunner().invoke(main, [str(part) for part in command])
            assert SHOWN in done.output
            printed += done.output
    assert "\x1b" not in printed
    assert "\nb" not in printed


def test_a_message_has_a_bound_whatever_a_file_holds() -> None:
    error = VividcError("`" + "A" * 60_000 + "` is no name\n" + "x\n" * 500, hint="y" * 9000)
    text = str(error)
    assert len(text) < 2000
    assert text.startswith("`AAA")
    assert "\n... and 462 more lines\nhint: yyy" in text
    assert str(VividcError("short", hint="as it is")) == "short\nhint: as it is"


def test_a_warning_names_the_line_of_the_users_call(tmp_path: Path) -> None:
    graph = tmp_path / "g.json"
    graph.write_text('{"name": "g", "nodes": [{"id": "a", "op": "frobnicate"}], "edges": []}')

    @vividc.jit
    def halved(a):
        return a * 0.5

    for call in (lambda: vividc.dfg.load(graph), lambda: halved(3.0)):
        with pytest.warns(VividcWarning) as caught:
            call()
        assert {warning.filename for warning in caught} == {__file__}
