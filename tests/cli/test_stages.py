"""Looking between the stages of a compilation, and running passes on what they left."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from vividc.cli import main
from vividc.compiler import passes
from vividc.compiler.passes import FUNCTION_PASSES, GRAPH_PASSES, STAGES
from vividc.dfg import ir, parse
from vividc.ssa.ir import Function
from vividc.ssa.text import parse as parse_function

SOURCE = """\
import vividc


@vividc.kernel("void(int32[::1], int32[::1])")
def scaled(x, y):
    for i in range(len(x)):
        if x[i] > 3:
            y[i] = 5 * x[i] + 0
"""


def run(*args: object) -> Result:
    return CliRunner().invoke(main, [*map(str, args)])


@pytest.fixture
def kernel(tmp_path: Path) -> Path:
    path = tmp_path / "scaled.py"
    path.write_text(SOURCE)
    return path


def compiled(kernel: Path, *args: object) -> Result:
    output = kernel.with_suffix(".vivid")
    return run("compile", kernel, "--fabric", "mesh-2x2", "-o", output, *args)


def test_a_stage_is_printed_as_text_that_is_read_back(kernel: Path) -> None:
    result = compiled(kernel, "--print-after", "frontend", "--stop-after", "frontend")
    assert result.exit_code == 0
    first, text = result.stdout.split("\n", 1)
    assert first == "# after frontend"
    assert parse_function(text).name == "scaled"
    assert not kernel.with_suffix(".vivid").exists()


def test_all_stages_go_to_files_in_processing_order(kernel: Path) -> None:
    folder = kernel.parent / "stages"
    result = compiled(kernel, "--print-to", folder, "--verify-each")
    assert result.exit_code == 0
    assert kernel.with_suffix(".vivid").exists()
    names = [path.stem.split("-", 1)[1] for path in sorted(folder.iterdir())]
    seen = list(dict.fromkeys(names))
    known = [stage.name for stage in STAGES]
    assert set(seen) <= set(known)
    whole = [name for name in seen if name not in GRAPH_PASSES]
    assert whole == [name for name in known if name in whole]
    assert {"frontend", "normalize", "build-kernel", "optimize", "map", "encode"} <= {*whole}
    for path in folder.iterdir():
        kind = next(stage.leaves for stage in STAGES if path.stem.endswith(stage.name))
        if kind is Function:
            parse_function(path.read_text())
        elif kind is ir.DFG:
            parse(path.read_text())


def test_seconds_of_stages(kernel: Path) -> None:
    result = compiled(kernel, "--time-passes", "--stop-after", "build-kernel")
    assert result.exit_code == 0
    shown = re.findall(r"│ ([a-z-]+) +│ +[\d.]+ │", result.stderr)
    assert shown[0] == "remove-unreachable-blocks"
    after = shown.index("frontend")
    assert shown[after - 1 : after + 3] == ["merge-equal", "frontend", "contract", "choose"]
    assert shown[-1] == "build-kernel"


def test_the_loop_that_tiles_share_is_cut_by_a_stage_of_its_own(kernel: Path) -> None:
    source = SOURCE.replace("import vividc", "import vividc\nfrom numba import prange", 1)
    kernel.write_text(source.replace("in range", "in prange"))
    result = compiled(
        kernel, "--fabric", "vivid", "--print-after", "all", "--stop-after", "cut-parallel-loop"
    )
    whole, cut = re.split("^# after frontend|# after cut-parallel-loop", result.stdout, flags=re.M)[
        1:
    ]
    assert parse_function(whole) != parse_function(cut)


def test_what_breaks_an_invariant_is_named(kernel: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(passes, "check_function", lambda function: ["it is odd"])
    result = compiled(kernel, "--verify-each")
    assert result.exit_code == 1
    assert "remove-unreachable-blocks broke an invariant: it is odd" in result.stderr


def test_printed_stages_do_not_mix_with_json(kernel: Path) -> None:
    result = compiled(kernel, "--json", "--print-after", "all")
    assert result.exit_code == 2
    assert "--print-to" in result.stderr
    assert compiled(kernel, "--json", "--print-to", kernel.parent / "there").exit_code == 0


def test_a_folder_that_cannot_be_made(kernel: Path) -> None:
    result = compiled(kernel, "--print-to", kernel.parent / "no" / "where")
    assert (result.exit_code, "cannot be made" in result.stderr) == (2, True)


def test_passes_run_on_a_function(kernel: Path) -> None:
    folder = kernel.parent / "stages"
    compiled(kernel, "--print-to", folder, "--stop-after", "frontend")
    file = next(folder.glob("*-frontend.txt"))
    same = run("opt", file)
    assert (same.exit_code, same.stdout) == (0, file.read_text())
    file.write_text(
        same.stdout.replace("  return", "  %900 i32 = add 0x00000001, 0x00000002\n  return")
    )
    output = kernel.parent / "tidy.ssa"
    assert run("opt", file, "--passes", "normalize, tidy", "-o", output).exit_code == 0
    assert output.read_text() == same.stdout


def test_every_pass_runs_by_its_name(kernel: Path) -> None:
    folder = kernel.parent / "stages"
    compiled(kernel, "--print-to", folder, "--stop-after", "fold-constants")
    for file, table in (
        (next(folder.glob("*-frontend.txt")), FUNCTION_PASSES),
        (next(folder.glob("*-fold-constants.txt")), GRAPH_PASSES),
    ):
        for name in table:
            assert run("opt", file, "--passes", name).exit_code == 0, name


def test_passes_run_on_a_graph(tmp_path: Path) -> None:
    file = tmp_path / "sum.dfg"
    constants = "%0 = const 0x00000002\n%1 = const 0x00000003\n"
    file.write_text(f'dfg "sum"\n{constants}%2 = add %0, %1\n%3 = live_out "s" %2\n')
    result = run("opt", file, "--passes", "fold-constants,remove-dead-nodes")
    assert result.exit_code == 0
    assert "const 0x00000005" in result.stdout
    assert "add" not in result.stdout


@pytest.mark.parametrize(
    ("text", "args", "message"),
    [
        ('function "f"\nb:\n  return\n', ("--passes", "frob"), "no pass on functions is called"),
        ('dfg "g"\n%0 = iv\n', ("--passes", "tidy"), "no pass on graphs is called"),
        ('function "f"\nb:\n  jump c\n', (), "branches to c, which is no block"),
        ('function "f"\nb:\n  jump\n', (), "odd.txt:3"),
        ("nonsense", (), "odd.txt:1"),
        ("", (), "the text is empty"),
    ],
)
def test_mistakes_are_told(tmp_path: Path, text: str, args: tuple[str, ...], message: str) -> None:
    file = tmp_path / "odd.txt"
    file.write_text(text)
    result = run("opt", file, *args)
    assert result.exit_code == 2
    assert message in result.stderr


def test_the_list_names_stages_and_passes() -> None:
    result = run("opt", "--list")
    assert result.exit_code == 0
    for name in (*(stage.name for stage in STAGES), *FUNCTION_PASSES, *GRAPH_PASSES):
        assert name in result.stdout
    assert run("opt").exit_code == 2
