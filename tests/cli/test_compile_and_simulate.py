"""A kernel goes through compile, simulate --check and disasm; what is wrong is said, and where."""

import json
import os
import shutil

import numpy as np
import pytest
from click.testing import CliRunner

import vividc
from vividc.cli import main

SOURCE = """\
import vividc


@vividc.kernel("int32(int32[::1], float32[::1], int32)")
def count(x, y, n):
    found = 0
    for i in range(n):
        if x[i] > 2:
            found += 1
        y[i] = y[i] + y[i]
    return found
"""


def run(*args):
    return CliRunner().invoke(main, [*map(str, args)])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A kernel, its program, and inputs; tests copy what they change."""
    folder = tmp_path_factory.mktemp("kernel")
    (folder / "k.py").write_text(SOURCE)
    result = run("compile", folder / "k.py", "-o", folder / "k.vivid", "--json")
    assert result.exit_code == 0, result.stderr
    (folder / "compile.json").write_text(result.stdout)
    inputs = {"x": np.arange(8, dtype=np.int32), "y": np.ones(8, np.float32), "n": 8}
    np.savez(folder / "in.npz", **inputs)
    return folder


@pytest.fixture
def own(folder, tmp_path):
    shutil.copytree(folder, tmp_path / "own")
    return tmp_path / "own"


def test_compile_reports_every_region(folder):
    out = json.loads((folder / "compile.json").read_text())
    assert out["schema"] == "vividc.compile/1"
    assert (out["kernel"], out["fabric"]) == ("count", "vivid-tile")
    assert out["output"] == str(folder / "k.vivid")
    loops = [region for region in out["regions"] if region["kind"] == "loop"]
    assert loops
    for loop in loops:
        assert loop["status"] in ("optimal", "feasible")
        assert loop["ii"] >= loop["lower_bound"] >= loop["mii"] >= 1
        assert loop["bounds"][0]["ii"] == loop["mii"]
    assert 0 < loop["utilization"] <= 1
    file, _, line = loop["loc"].rpartition(":")
    assert file == str(folder / "k.py")
    assert 5 <= int(line) <= 10


def test_compile_for_people(folder, own):
    result = run("compile", folder / "k.py", "-o", own / "again.vivid")
    assert result.exit_code == 0, result.stderr
    assert vividc.load(own / "again.vivid").name == "count"
    assert "count on vivid-tile" in result.stdout
    assert "written:" in result.stdout
    assert result.stderr == ""


def test_sizes_are_said_kept_and_demanded(own):
    command = ("compile", own / "k.py", "-o", own / "s.vivid")
    result = run(*command, "--sizes", "n=8,x=8", "--explain")
    assert result.exit_code == 0, result.stderr
    assert "for x 8, n = 8 only" in result.stdout
    result = run(*command, "--sizes", "n=8", "--sizes", "x=8", "--json")
    assert json.loads(result.stdout)["sizes"] == {"x": [8], "n": 8}
    assert json.loads((own / "compile.json").read_text())["sizes"] == {}
    simulate = ("simulate", own / "s.vivid", "--inputs")
    assert run(*simulate, own / "in.npz", "--check").exit_code == 0
    np.savez(own / "other.npz", x=np.zeros(9, np.int32), y=np.ones(9, np.float32), n=9)
    result = run(*simulate, own / "other.npz", "--check")
    assert result.exit_code == 2
    assert "count was compiled for x 8, n = 8 only, and got x 9, n = 9" in result.stderr
    assert "hint: compile it for these sizes" in result.stderr


@pytest.mark.parametrize(
    ("sizes", "told"),
    [
        ("n", "'n' is not NAME=SIZE"),
        ("x=8x", "'x=8x' is not NAME=SIZE"),
        ("x=-8x2", "is not NAME=SIZE"),
        ("n=8,n=9", "n is given twice"),
        ("z=8", "count(x, y, n) has no parameter 'z'"),
        ("x=8x2", "x of count: expected 1 dimension(s), got 2"),
        ("n=3000000000", "n of count: 3000000000 does not fit int32"),
    ],
)
def test_sizes_that_cannot_be(folder, tmp_path, sizes, told):
    result = run("compile", folder / "k.py", "-o", tmp_path / "s.vivid", "--sizes", sizes)
    assert result.exit_code == 2
    assert told in result.stderr
    assert not (tmp_path / "s.vivid").exists()


def test_default_output_is_named_for_the_kernel(folder, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run("compile", folder / "k.py").exit_code == 0
    assert os.listdir(tmp_path) == ["count.vivid"]


def test_simulate_updates_arrays_and_returns(folder, own):
    args = ("--inputs", folder / "in.npz", "--outputs", own / "out.npz", "--check", "--json")
    result = run("simulate", folder / "k.vivid", *args)
    assert result.exit_code == 0, result.stderr
    out = json.loads(result.stdout)
    assert out["schema"] == "vividc.simulate/1"
    assert out["value"] == 5
    assert out["check"] == {"passed": True, "mismatches": []}
    assert out["cycles"] == out["stats"]["cycles"] > 8
    with np.load(own / "out.npz") as archive:
        assert archive["return"] == 5
        np.testing.assert_array_equal(archive["x"], np.arange(8))
        np.testing.assert_array_equal(archive["y"], np.full(8, 2.0, np.float32))


def test_engines_give_the_same_but_for_their_name(folder):
    found = {}
    for engine in ("reference", "native"):
        args = ("--inputs", folder / "in.npz", "--engine", engine, "--json")
        result = run("simulate", folder / "k.vivid", *args)
        assert result.exit_code == 0, result.stderr
        found[engine] = json.loads(result.stdout)
        assert found[engine]["stats"].pop("engine") == engine
    assert found["reference"] == found["native"]
    result = run("simulate", folder / "k.vivid", "--inputs", folder / "in.npz", "--engine", "fast")
    assert result.exit_code == 2
    assert "'fast' is not one of 'auto', 'native', 'reference'" in result.stderr


def test_simulate_for_people(folder):
    result = run("simulate", folder / "k.vivid", "--inputs", folder / "in.npz", "--check")
    assert result.exit_code == 0, result.stderr
    for text in ("count on vivid-tile", "cycles: ", "value: 5", "check: agrees with numba"):
        assert text in result.stdout


def test_mismatch_is_exit_code_5_and_names_the_element(own):
    other = own / "other.py"
    other.write_text(SOURCE.replace("y[i] + y[i]", "y[i] + y[i] * x[i]").replace("> 2", "> 3"))
    args = ("--inputs", own / "in.npz", "--check", "--kernel", f"{other}:count")
    result = run("simulate", own / "k.vivid", *args, "--json")
    assert result.exit_code == 5
    wrong = {item["name"]: item for item in json.loads(result.stdout)["check"]["mismatches"]}
    assert wrong["y"] == {
        "name": "y", "index": [0], "simulated": 2.0, "reference": 1.0, "count": 7,
    }  # fmt: skip
    assert (wrong["return"]["simulated"], wrong["return"]["reference"]) == (5, 4)
    assert "mismatch: y[0] is 2.0, the reference gives 1.0 (7 elements differ)" in result.stderr
    assert "mismatch: return is 5, the reference gives 4" in result.stderr


def test_tolerance_decides_for_floats_only(own):
    other = own / "other.py"
    other.write_text(SOURCE.replace("y[i] + y[i]", "y[i] + y[i] + y[i]"))
    args = ("--inputs", own / "in.npz", "--check", "--kernel", other)
    assert run("simulate", own / "k.vivid", *args, "--atol", "0.9").exit_code == 5
    assert run("simulate", own / "k.vivid", *args, "--atol", "1.1").exit_code == 0


def test_changed_source_is_not_run(own):
    path = own / "k.py"
    assert run("compile", path, "-o", own / "k.vivid").exit_code == 0
    path.write_text(SOURCE + "\nraise SystemExit('was run')\n")
    result = run("simulate", own / "k.vivid", "--inputs", own / "in.npz", "--check")
    assert result.exit_code == 2
    assert "was changed since" in result.stderr
    assert "hint: name it: --source FILE.py:count" in result.stderr
    assert "was run" not in result.stderr


def test_a_source_beside_the_program_is_run_if_it_is_named(own, tmp_path):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    first = own / "k.py"
    assert run("compile", first, "-o", elsewhere / "k.vivid").exit_code == 0
    args = ("simulate", elsewhere / "k.vivid", "--inputs", own / "in.npz", "--check")
    text = first.read_text()
    first.unlink()
    result = run(*args)
    assert result.exit_code == 2
    assert "was not found" in result.stderr
    (elsewhere / "k.py").write_text(text)
    result = run(*args)
    assert result.exit_code == 2
    assert "was not compiled there by you on this computer" in result.stderr
    assert f"--source {elsewhere / 'k.py'}:count" in result.stderr
    result = run(*args, "--source", f"{elsewhere / 'k.py'}:count")
    assert result.exit_code == 0
    assert result.stderr == f"vividc: --check runs {elsewhere / 'k.py'}\n"


def test_kernel_with_other_parameters_is_refused(own):
    other = own / "other.py"
    other.write_text(
        SOURCE.replace("count(x, y, n)", "count(x, y, m)").replace("range(n)", "range(m)")
    )
    args = ("--inputs", own / "in.npz", "--check", "--kernel", other)
    result = run("simulate", own / "k.vivid", *args)
    assert result.exit_code == 2
    assert "hint: expected: x: int32[:], y: float32[:], n: int32" in result.stderr


def test_failed_run_leaves_the_old_outputs(own):
    (own / "out.npz").write_bytes(b"old")
    np.savez(own / "bad.npz", x=np.zeros(8, np.int32), y=np.ones(8, np.float32), n=10**6)
    args = ("--inputs", own / "bad.npz", "--outputs", own / "out.npz")
    result = run("simulate", own / "k.vivid", *args)
    assert result.exit_code == 2, result.stderr
    assert result.stdout == ""
    assert (own / "out.npz").read_bytes() == b"old"


def test_cycle_limit(folder):
    args = ("--inputs", folder / "in.npz", "--cycle-limit", "5")
    result = run("simulate", folder / "k.vivid", *args)
    assert result.exit_code == 4
    assert "after 5 cycles" in result.stderr
    assert "Traceback" not in result.stderr


def test_disasm(folder):
    result = run("disasm", folder / "k.vivid")
    assert result.exit_code == 0
    assert result.stdout.startswith("program count on vivid-tile")
    out = json.loads(run("disasm", folder / "k.vivid", "--json").stdout)
    assert out["schema"] == "vividc.disasm/1"
    assert out["text"] + "\n" == result.stdout


@pytest.mark.parametrize("command", [["disasm"], ["simulate", "--inputs", "in.npz"]])
def test_damaged_program_is_a_message(own, command):
    path = own / "k.vivid"
    path.write_bytes(path.read_bytes()[:100])
    name, *rest = command
    result = run(name, path, *rest)
    assert result.exit_code == 2
    assert str(path) in result.stderr
    assert "Traceback" not in result.output


def test_kernel_option_needs_check(folder):
    args = ("--inputs", folder / "in.npz", "--kernel", folder / "k.py")
    result = run("simulate", folder / "k.vivid", *args)
    assert result.exit_code == 2
    assert "--source needs --check" in result.stderr


def test_narrowed_arithmetic_warns_and_strict_fp_refuses(own):
    path = own / "f64.py"
    path.write_text(
        "import vividc\n\n\n"
        '@vividc.kernel("void(float32[::1])")\n'
        "def scale(x):\n"
        "    for i in range(len(x)):\n"
        "        x[i] = 0.1 * x[i]\n"
    )
    result = run("compile", path, "-o", own / "f64.vivid", "--json")
    assert result.exit_code == 0, result.stderr
    (warning,) = json.loads(result.stdout)["warnings"]
    assert f"{path}:7" in warning
    assert result.stderr.startswith("vividc: warning: ")
    refused = run("compile", path, "-o", own / "strict.vivid", "--strict-fp")
    assert refused.exit_code == 2
    assert f"{path}:7" in refused.stderr
    assert not (own / "strict.vivid").exists()


def test_fabric_from_a_file(own):
    fabric = own / "unit.yaml"
    fabric.write_text("extends: vivid-tile\nlatencies: {all: 1}\n")
    args = ("--fabric", fabric, "-o", own / "unit.vivid", "--json")
    out = json.loads(run("compile", own / "k.py", *args).stdout)
    assert out["fabric"] == "unit"
    fabric.write_text("extends: vivid-tile\nlatencies: {all: 0}\n")
    result = run("compile", own / "k.py", *args)
    assert result.exit_code == 2
    assert f"{fabric}:2" in result.stderr


def test_no_output_replaces_an_input(own):
    source, program, inputs = own / "k.py", own / "k.vivid", own / "in.npz"
    commands = [
        ("compile", f"{source}:count", "-o", source),
        ("simulate", program, "--inputs", inputs, "--outputs", inputs),
        ("simulate", program, "--inputs", inputs, "--trace", program),
    ]
    before = {path: path.read_bytes() for path in (source, program, inputs)}
    for command in commands:
        result = run(*command)
        assert result.exit_code == 2
        assert "is an input, which would be lost" in result.stderr
    assert before == {path: path.read_bytes() for path in before}


def test_access_outside_an_array_is_refused_before_the_host_makes_it(own, monkeypatch):
    def run_reference(kernel, arguments):
        raise AssertionError("the host would write outside its array")

    monkeypatch.setattr("vividc.cli.commands.simulate.run_reference", run_reference)
    np.savez(own / "short.npz", x=np.ones(8, np.int32), y=np.ones(2, np.float32), n=8)
    result = run("simulate", own / "k.vivid", "--inputs", own / "short.npz", "--check")
    assert result.exit_code == 2
    assert "an out-of-bounds access" in result.stderr
