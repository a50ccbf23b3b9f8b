"""`simulate --check` runs a file only if this user compiled it here, or names it."""

from __future__ import annotations

import os
import shutil
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

import vividc
from vividc.cli import main
from vividc.host import compiled_files, store

SOURCE = """\
import pathlib

import vividc

pathlib.Path(__file__).with_name("was_run").touch()


@vividc.kernel("void(int32[::1])")
def twice(x):
    x[0] = x[0] + x[0]
"""


def run(*args: object) -> Result:
    return CliRunner().invoke(main, [*map(str, args)])


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a kernel, its program and inputs, and what compiling recorded in `state`."""
    folder = tmp_path_factory.mktemp("compiled")
    (folder / "k.py").write_text(SOURCE)
    np.savez(folder / "in.npz", x=np.arange(1, 3, dtype=np.int32))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_STATE_HOME", str(folder / "state"))
        patch.setenv("VIVIDC_CACHE_DIR", "")
        result = run("compile", folder / "k.py", "-o", folder / "k.vivid")
    assert result.exit_code == 0, result.stderr
    (folder / "was_run").unlink()
    return folder


@pytest.fixture
def folder(compiled: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """The same folder and records, with no other place for any."""
    for name in ("was_run", "state"):
        if (tmp_path / name).exists():
            shutil.rmtree(tmp_path / name)
    shutil.copytree(compiled / "state", tmp_path / "state")
    (compiled / "was_run").unlink(missing_ok=True)
    (tmp_path / "tmp").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "tmp"))
    monkeypatch.setattr(store, "warned", [])
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setenv("VIVIDC_CACHE_DIR", "")
    return compiled


def check(folder: Path, *more: object) -> Result:
    return run("simulate", folder / "k.vivid", "--inputs", folder / "in.npz", "--check", *more)


def refused(folder: Path, place: Path) -> None:
    result = check(folder)
    assert result.exit_code == 2
    said = f"--check: the kernel's source: {place} was not compiled there by you on this computer"
    assert said in result.stderr
    assert f"hint: it would be run: if you trust it, --source {place}:twice" in result.stderr
    assert not place.with_name("was_run").exists()


def test_what_the_user_compiled_runs_and_is_named_without_any_cache(folder: Path) -> None:
    result = check(folder)
    assert result.exit_code == 0, result.stderr
    assert result.stderr == f"vividc: --check runs {folder / 'k.py'}\n"
    assert (folder / "was_run").exists()


def test_the_name_of_a_kernel_is_no_part_of_the_path(folder: Path) -> None:
    """`k.py` was compiled by the user; what lies beside it is from anyone who may write there."""
    beside = folder / "k.py:evil.py"
    beside.write_text(SOURCE)
    program = vividc.load(folder / "k.vivid")
    replace(program, name="evil.py:twice").save(folder / "evil.vivid")
    result = run(*("simulate", folder / "evil.vivid", "--inputs", folder / "in.npz", "--check"))
    beside.unlink()
    assert result.exit_code == 2
    assert f"--check runs {folder / 'k.py'}\n" in result.stderr
    assert f"{folder / 'k.py'}: has no kernel `evil.py:twice`" in result.stderr


def test_a_file_that_changes_after_it_was_looked_at_does_not_run(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = (folder / "k.py").read_text()

    def swap(*_: object) -> bool:
        (folder / "k.py").write_text(SOURCE.replace("x[0] + x[0]", "x[0]"))
        return True

    monkeypatch.setattr("vividc.cli.reference.is_noted", swap)
    result = check(folder)
    (folder / "k.py").write_text(before)
    assert result.exit_code == 2
    assert "k.py: was changed just now" in result.stderr
    assert not (folder / "was_run").exists()


def test_a_program_and_a_file_from_someone_else_run_nothing(
    folder: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Unpacked from an archive both are the user's own, and their hashes agree."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "another"))
    refused(folder, folder / "k.py")
    result = check(folder, "--source", folder / "k.py")
    assert result.exit_code == 0, result.stderr
    assert result.stderr == f"vividc: --check runs {folder / 'k.py'}\n"


def test_a_copy_elsewhere_is_not_what_was_compiled(folder: Path, tmp_path: Path) -> None:
    """What it imports is another file there."""
    copy = tmp_path / "copy"
    copy.mkdir()
    for name in ("k.py", "k.vivid", "in.npz"):
        shutil.copy(folder / name, copy)
    (folder / "k.py").rename(folder / "away.py")
    try:
        refused(copy, copy / "k.py")
        (copy / "k.py").unlink()
        (copy / "k.py").symlink_to(folder / "k.py")
        (folder / "away.py").rename(folder / "k.py")
        assert check(copy).exit_code == 0  # a link to what was compiled
    finally:
        if (folder / "away.py").exists():
            (folder / "away.py").rename(folder / "k.py")


@pytest.mark.parametrize(
    "name",
    [
        "a" * 5000 + ".py",
        "x\0y.py",
        "a\n\x1b[2J.py",
        "/etc/passwd/k.py",
        "/dev/zero",
        "/",
    ],
)
def test_whatever_a_program_names_is_a_message(folder: Path, tmp_path: Path, name: str) -> None:
    program = vividc.load(folder / "k.vivid")
    named = replace(program, provenance=replace(program.provenance, kernel_file=name))
    named.save(tmp_path / "k.vivid")
    inputs = ("--inputs", folder / "in.npz")
    result = run("simulate", tmp_path / "k.vivid", *inputs, "--check")
    assert result.exit_code == 2
    assert "was not found" in result.stderr
    assert "\x1b" not in result.stderr
    assert len(result.stderr) < 500
    assert run("simulate", tmp_path / "k.vivid", *inputs).exit_code == 0


def test_records_of_another_user_are_not_believed(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stranger = os.geteuid() + 1
    monkeypatch.setattr(os, "geteuid", lambda: stranger)
    refused(folder, folder / "k.py")


@pytest.mark.parametrize("damage", ["cut", "copied", "empty"])
def test_damaged_records_are_not_believed(folder: Path, tmp_path: Path, damage: str) -> None:
    (record,) = (tmp_path / "state" / "vividc" / "compiled").iterdir()
    content = record.read_bytes()
    if damage == "copied":
        record.unlink()
        compiled_files.note("/somewhere/else.py", "0" * 64)
        (other,) = record.parent.iterdir()
        record.write_bytes(other.read_bytes())
    else:
        record.write_bytes(content[:-1] if damage == "cut" else b"")
    record.chmod(0o600)
    refused(folder, folder / "k.py")


def test_without_a_home_records_lie_in_the_folder_of_temporary_files(
    folder: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", "/proc/none")
    refused(folder, folder / "k.py")
    assert run("compile", folder / "k.py", "-o", tmp_path / "k.vivid").exit_code == 0
    assert (tmp_path / "tmp" / f"vividc-{os.geteuid()}").stat().st_mode & 0o777 == 0o700
    result = check(folder)
    assert result.exit_code == 0, result.stderr


def test_the_current_folder_holds_no_records(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Python takes it for temporary files where there is nothing else."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("XDG_STATE_HOME", "/proc/none")
    compiled_files.note("/k.py", "0" * 64)
    assert not compiled_files.is_noted(Path("/k.py"), "0" * 64)
    assert not list(tmp_path.iterdir())


def test_help_says_what_is_executed() -> None:
    text = " ".join(run("simulate", "--help").stdout.split())
    assert "Nothing in P.vivid is executed on this computer." in text
    assert "--source, --kernel FILE[:KERNEL]" in text
