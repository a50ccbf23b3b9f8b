"""Options of loops: what they may be, keywords from before there were any, and the command line."""

from __future__ import annotations

from dataclasses import fields
from typing import Any
from unittest.mock import Mock

import click
import pytest
from click.testing import CliRunner

import vividc
from vividc import LoopOptions
from vividc.cli.loops import loop_options as flags
from vividc.errors import ArgumentError


def test_lines_may_be_text() -> None:
    assert LoopOptions(unroll={"12": 4}) == LoopOptions(unroll={12: 4})  # type: ignore[dict-item]


def test_what_is_given_may_change_later() -> None:
    factors = {12: 4}
    options = LoopOptions(unroll=factors)
    factors[12] = 3
    assert options.unroll == {12: 4}


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"auto": "none"}, "auto cannot be 'none'\nhint: give True or False"),
        ({"unroll": [3]}, "unroll cannot be [3]\nhint: write unroll={12: 64} for the loop on line"),
        ({"unroll": {3: 3}}, "unroll cannot take 3\nhint: a power of two up to 64"),
        ({"jam": {3: True}}, "jam cannot take True\nhint: a power of two up to 64"),
        ({"jam": {3: 128}}, "jam cannot take 128\nhint: a power of two up to 64"),
        ({"unroll": {"first": 2}}, "unroll cannot take 'first' for a line\nhint: lines of a file"),
        ({"unroll": {"9" * 5000: 2}}, "for a line\nhint: lines of a file are numbered from 1"),
        ({"flatten": {0: True}}, "flatten cannot take 0 for a line"),
        ({"flatten": {12: 1}}, "flatten cannot take 1\nhint: True, or False"),
        ({"threads": 9}, "threads cannot be 9\nhint: give 1 to 8"),
        ({"threads": True}, "threads cannot be True\nhint: give 1 to 8"),
    ],
)
def test_options_that_make_no_sense_are_refused(given: dict[str, Any], says: str) -> None:
    with pytest.raises(ArgumentError) as caught:
        LoopOptions(**given)
    assert says in str(caught.value)


@vividc.kernel("void(int32[::1])")
def double(x):
    for i in range(len(x)):
        x[i] *= 2


LOOP = double.py_func.__code__.co_firstlineno + 2


@pytest.mark.parametrize(
    ("flat", "new"),
    [
        ({"transform": "none"}, "LoopOptions(auto=False)"),
        ({"unroll": {str(LOOP): 4}, "jam": None}, f"LoopOptions(unroll={{{LOOP}: 4}})"),
        (
            {"transform": "none", "flatten": {LOOP: False}, "threads": 1},
            f"LoopOptions(auto=False, flatten={{{LOOP}: False}}, threads=1)",
        ),
    ],
)
def test_flat_keywords_work_and_the_warning_says_what_to_write(
    flat: dict[str, Any], new: str
) -> None:
    with pytest.warns(DeprecationWarning, match="write loops=") as warned:
        old = vividc.compile(double, **flat)
    (warning,) = warned
    assert str(warning.message) == f"{', '.join(flat)}: write loops=vividc.{new}"
    assert warning.filename == __file__
    options = eval(new, {"LoopOptions": LoopOptions})
    assert old.to_bytes() == vividc.compile(double, loops=options).to_bytes()


@pytest.mark.parametrize(
    ("flat", "says"),
    [
        ({"transform": "fast"}, "transform cannot be 'fast'"),
        ({"threads": 9}, "threads cannot be 9"),
        ({"loops": LoopOptions(), "jam": {3: 2}}, "loops cannot go with jam"),
        ({"loops": {"jam": {3: 2}}}, "loops cannot be {'jam': {3: 2}}"),
    ],
)
def test_keywords_that_make_no_sense_are_refused(flat: dict[str, Any], says: str) -> None:
    with pytest.raises(ArgumentError) as caught:
        vividc.compile(double, **flat)
    assert says in str(caught.value)


def test_an_unknown_keyword_is_a_type_error() -> None:
    with pytest.raises(TypeError, match="unexpected keyword argument 'unrol'"):
        vividc.compile(double, unrol={3: 2})  # type: ignore[call-arg]


def parsed(*args: str) -> LoopOptions:
    """What a command with the options gets."""
    seen = Mock(__name__="command", spec=[])
    command = click.command(flags(seen))
    done = CliRunner().invoke(command, args, standalone_mode=False)
    assert done.exception is None
    (options,) = seen.call_args.kwargs.values()
    assert isinstance(options, LoopOptions)
    return options


CASES: list[tuple[tuple[str, ...], dict[str, Any]]] = [
    ((), {}),
    (("--no-transform",), {"auto": False}),
    (("--unroll", "12=4", "--unroll", "3=1"), {"unroll": {12: 4, 3: 1}}),
    (("--jam", "8=2"), {"jam": {8: 2}}),
    (("--flatten", "5", "--no-flatten", "9"), {"flatten": {5: True, 9: False}}),
    (("--threads", "4"), {"threads": 4}),
    (("--no-restructure",), {"restructure": False}),
]


@pytest.mark.parametrize(("args", "given"), CASES)
def test_the_command_line_says_the_same(args: tuple[str, ...], given: dict[str, Any]) -> None:
    assert parsed(*args) == LoopOptions(**given)


def test_every_field_has_an_option() -> None:
    assert {name for _, given in CASES for name in given} == {f.name for f in fields(LoopOptions)}
