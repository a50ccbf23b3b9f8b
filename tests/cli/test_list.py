"""`vividc list`: every name that can be given, with a line on each."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.shell_completion import ShellComplete
from click.testing import CliRunner

from vividc import arch
from vividc.cli import main
from vividc.machine.opcodes import OPCODES
from vividc.mapper import mapper_names

KNOWN = {
    "fabrics": (*arch.preset_names(), *arch.family_names()),
    "accelerators": arch.accelerator_names(),
    "mappers": mapper_names(),
    "opcodes": tuple(op.value for op in OPCODES),
}


@pytest.mark.parametrize("what", KNOWN)
def test_all_are_listed_with_a_line_on_each(what: str) -> None:
    run = CliRunner().invoke(main, ["list", what, "--json"])
    assert run.exit_code == 0
    rows = json.loads(run.stdout)[what]
    assert tuple(row["name"] for row in rows) == KNOWN[what]
    assert all(set(row) == set(rows[0]) for row in rows)
    assert all(row.get("what", "is a row of a table") for row in rows)
    assert CliRunner().invoke(main, ["list", what]).stdout.startswith(what.capitalize())


def test_kernels_of_files(tmp_path: Path) -> None:
    file = tmp_path / "some.py"
    file.write_text(
        "import vividc\n\n\n"
        '@vividc.kernel("void(float32[:, ::1], int64)")\n'
        "def clear(a, n):\n    for i in range(n):\n        a[i, 0] = 0\n"
    )
    run = CliRunner().invoke(main, ["list", "kernels", str(file), "--json"])
    assert json.loads(run.stdout)["kernels"] == [
        {"name": f"{file}:clear", "signature": "clear(a: float32[:, ::1], n: int64)"}
    ]


@pytest.mark.parametrize(
    ("args", "incomplete", "found"),
    [
        (["compile", "--fabric"], "vivid-tile-n", ["vivid-tile-ne", "vivid-tile-nw"]),
        (["map", "--fabric"], "mesh", ["mesh-4x4"]),
        (["map", "--mapper"], "s", ["sat-kms", "spr"]),
        (["area"], "vivid-u", ["vivid-unit"]),
        (["simulate", "p.vivid", "--fabric"], "vivid", ["vivid", "vivid-unit"]),
        (["verify", "m.json", "--fabric"], "vivid-8", ["vivid-8x8"]),
        (["area", "vivid", "--costs"], "vivid-4", ["vivid-45nm"]),
        (["compile", "--precision"], "exp", ["exp=", "exp2="]),
        (["compile", "--precision"], "exp=fp1", ["exp=fp16"]),
        (["opt", "--passes"], "contract,norm", ["contract,normalize"]),
        (["compile", "--effort"], "f", ["fast"]),
    ],
)
def test_a_shell_completes_names(args: list[str], incomplete: str, found: list[str]) -> None:
    shell = ShellComplete(main, {}, "vividc", "_VIVIDC_COMPLETE")
    assert [item.value for item in shell.get_completions(args, incomplete)] == found


def test_a_shell_completes_kernels_without_running_their_file(tmp_path: Path) -> None:
    file = tmp_path / "two.py"
    file.write_text(
        "import vividc\nfrom vividc import kernel\nraise SystemExit('it ran')\n"
        "@vividc.kernel('void(int32[::1])')\ndef one(x):\n    x[0] = 1\n"
        "@kernel('void(int32[::1])')\ndef two(x):\n    x[0] = 1\n"
        "@vividc.jit\ndef other(x):\n    x[0] = 1\n"
    )
    shell = ShellComplete(main, {}, "vividc", "_VIVIDC_COMPLETE")
    for begun, found in ((":", ["one", "two"]), (":t", ["two"])):
        offered = shell.get_completions(["compile"], f"{file}{begun}")
        assert [item.value for item in offered] == [f"{file}:{name}" for name in found]
    [files] = shell.get_completions(["compile"], "tw")
    assert files.type == "file"
    file.write_text("def (")
    assert shell.get_completions(["compile"], f"{file}:") == []


def test_mistakes_are_told() -> None:
    assert "vividc list kernels FILE.py" in CliRunner().invoke(main, ["list", "kernels"]).stderr
    wrong = CliRunner().invoke(main, ["list", "mappers", "x.py"])
    assert (wrong.exit_code, "leave x.py out" in wrong.stderr) == (2, True)
    assert CliRunner().invoke(main, ["list", "nothing"]).exit_code == 2
    assert CliRunner().invoke(main, ["list", "kernels", "absent.py"]).exit_code == 2
