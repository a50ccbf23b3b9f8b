"""JSON output is strict JSON whatever the results hold."""

import json
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType

import numpy as np

from vividc.cli.reports.report import plain, print_json, print_table


class Colour(Enum):
    RED = "red"


@dataclass(frozen=True)
class Row:
    name: str
    cells: tuple[int, ...]


def test_plain_values():
    assert plain(np.float32(0.5)) == 0.5
    assert plain(np.int64(3)) == 3
    assert plain(float("nan")) == "nan"
    assert plain(np.float32("-inf")) == "-inf"
    assert plain(Row("a", (1, 2))) == {"name": "a", "cells": [1, 2]}
    assert plain(MappingProxyType({Colour.RED: Colour.RED, 3: None})) == {"red": "red", "3": None}
    assert plain(np.arange(3)) == [0, 1, 2]


def test_one_object_with_its_schema(capsys):
    print_json("vividc.test/1", {"a": np.float64("inf"), "b": Row("x", ())})
    out = json.loads(capsys.readouterr().out)
    assert out == {"schema": "vividc.test/1", "a": "inf", "b": {"name": "x", "cells": []}}


def test_tables_show_text_as_it_is(capsys):
    print_table("[bold]t", ("name", "n"), [("loop[0]", None), ("x[/]", 1)], numeric=("n",))
    out = capsys.readouterr().out
    for text in ("[bold]t", "loop[0]", "x[/]", "-"):
        assert text in out


def test_numbers_are_on_the_right_whatever_the_column_is_called(capsys):
    columns = ("stage", "DRAM bytes", "mode")
    print_table("t", columns, [("blend", 7, "gpu"), ("sorting", 12345, "x")], numeric=columns[1:2])
    lines = capsys.readouterr().out.splitlines()
    short = next(line for line in lines if "blend" in line)
    long = next(line for line in lines if "sorting" in line)
    assert short.index("7") == long.index("5")
    assert short.index("blend") == long.index("sorting")
    assert short.index("gpu") == long.index("x")
