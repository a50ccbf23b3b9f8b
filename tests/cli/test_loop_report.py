"""`--explain`, `--unroll`, `--jam`, `--threads`, `--no-transform`: what is done with loops."""

import json

import pytest
from click.testing import CliRunner

from vividc.cli import main

SOURCE = """\
import vividc


@vividc.kernel("void(int32[::1], int32[::1])")
def double(x, y):
    for i in range(len(x)):
        y[i] = 2 * x[i]
"""


def run(*args):
    return CliRunner().invoke(main, [*map(str, args)])


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "k.py"
    path.write_text(SOURCE)
    return path


def loops(file, *args):
    result = run("compile", file, "-o", file.with_suffix(".vivid"), "--json", *args)
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)["loops"]


def test_json_says_what_was_done_with_each_loop(file):
    (loop,) = loops(file)
    assert loop["loc"].endswith("k.py:6")
    assert loop["cycles_before"] == 1
    assert loop["cycles_after"] < 1
    assert [item["kind"] for item in loop["transforms"] if item["chosen"]] == ["unrolling"]


def test_a_loop_is_left_alone_on_request(file):
    for request in (["--no-transform"], ["--unroll", "6=1"]):
        (loop,) = loops(file, *request)
        assert loop["cycles_after"] == 1
        assert not any(item["chosen"] for item in loop["transforms"])


def test_a_factor_is_obeyed(file):
    (loop,) = loops(file, "--no-transform", "--unroll", "6=4")
    (item,) = loop["transforms"]
    assert (item["kind"], item["factor"], item["chosen"]) == ("unrolling", 4, True)


def test_tables_for_people(file):
    result = run("compile", file, "-o", file.with_suffix(".vivid"), "--explain")
    assert result.exit_code == 0
    assert "Loops of the source" in result.stdout
    assert "Transformations" in result.stdout


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["--unroll", "six=2"], "LINE=N"),
        (["--unroll", "6=3"], "power of two"),
        (["--unroll", "1=2"], "lines with loops: 6"),
        (["--jam", "6=2"], "no loop is inside it"),
    ],
)
def test_wrong_factors_are_refused(file, args, message):
    output = file.with_suffix(".vivid")
    result = run("compile", file, "-o", output, *args)
    assert result.exit_code == 2
    assert message in result.stderr
    assert not output.exists()


def test_threads_of_a_parallel_loop(tmp_path):
    path = tmp_path / "k.py"
    parallel = SOURCE.replace("import vividc", "import vividc\nfrom numba import prange", 1)
    path.write_text(parallel.replace("in range", "in prange"))
    (loop,) = loops(path, "--threads", "2", "--no-transform")
    (item,) = loop["transforms"]
    assert (item["kind"], item["factor"], item["chosen"]) == ("threads", 2, True)


@pytest.mark.parametrize(("count", "reason"), [("9", "threads cannot be 9"), ("4", "prange")])
def test_threads_that_cannot_be(file, count, reason):
    result = run("compile", file, "-o", file.with_suffix(".vivid"), "--threads", count)
    assert result.exit_code == 2
    assert reason in result.stderr


def test_a_loop_cannot_be_both_flattened_and_left(file):
    result = run("compile", file, "--flatten", "6", "--no-flatten", "6")
    assert result.exit_code == 2
    assert "--flatten 6 and --no-flatten 6" in result.stderr


CHAIN = """\
import numpy as np
import vividc


@vividc.kernel("float32(float32[::1])")
def total(x):
    s = np.float32(0.0)
    for i in range(len(x)):
        s += x[i]
    return s
"""


def test_what_would_save_cycles_is_told_in_json_and_in_a_table(tmp_path):
    path = tmp_path / "k.py"
    path.write_text(CHAIN)
    output = path.with_suffix(".vivid")
    result = run("compile", path, "-o", output, "--json", "--explain")
    assert result.exit_code == 0, result.stderr
    (hint,) = json.loads(result.stdout)["advice"]
    assert hint["option"] == "--reassociate"
    assert hint["loc"].endswith("k.py:8")
    assert hint["saved"] == hint["before"] - hint["after"] > 0
    result = run("compile", path, "-o", output, "--explain")
    assert "What would save cycles" in result.stdout
    assert f"{hint['saved']:,.0f}" in result.stdout
    result = run("compile", path, "-o", output, "--json", "--explain", "--reassociate")
    left = json.loads(result.stdout)["advice"]
    assert "--reassociate" not in {hint["option"] for hint in left}
    path.write_text(CHAIN.replace("s += x[i]", "s = s * x[i] + x[i]"))
    result = run("compile", path, "-o", output, "--explain", "--sizes", "x=240")
    assert "no change is known that would save 3%" in result.stdout


def test_without_explain_nothing_is_tried(file):
    result = run("compile", file, "-o", file.with_suffix(".vivid"), "--json")
    assert json.loads(result.stdout)["advice"] is None


MEETING = """\
import vividc


@vividc.kernel("void(float32[::1], int32[::1])")
def chain(x, places):
    for i in range(2, len(x)):
        a = x[i - 2]
        x[i] = a * a
        {store}
"""


@pytest.mark.parametrize(
    ("store", "told", "assumed"),
    [
        ("pass", "known: accesses at {file}:7 and {file}:8 meet 2 iterations later", False),
        (
            "x[places[i]] = a",
            "{file}:8 and {file}:9 may meet",
            True,
        ),
    ],
)
def test_recurrences_through_memory_are_known_or_assumed(tmp_path, store, told, assumed):
    path = tmp_path / "k.py"
    path.write_text(MEETING.format(store=store))
    result = run("compile", path, "-o", path.with_suffix(".vivid"), "--json", "--no-transform")
    assert result.exit_code == 0, result.stderr
    made = json.loads(result.stdout)
    (loop,) = made["loops"]
    assert loop["binds"].endswith(told.format(file=path))
    assert ("; assumed: accesses at " in loop["binds"]) == assumed
    assert loop["memory_order_assumed"] == assumed
    assert made["regions"][-1]["memory_order_assumed"] == assumed
    table = run("compile", path, "-o", path.with_suffix(".vivid"), "--explain").stdout
    assert ("memory order assumed" in " ".join(table.split())) == assumed
