"""Every failure is one message on stderr with its exit code, and never a traceback."""

import ctypes
import re
import subprocess
import sys
from importlib import import_module

import click
import numpy as np
import pytest
from click.testing import CliRunner

from tests.fuzz.file_scenes import SCENES
from vividc.cli import main
from vividc.errors import InternalError, MappingFailed, TimeLimit, VividcError


def run_failing(monkeypatch, error, **env):
    @click.command("map")
    def command():
        raise error

    monkeypatch.setitem(main.commands, "map", command)
    return CliRunner(env=env).invoke(main, ["map"])


@pytest.mark.parametrize(
    ("error", "code", "text"),
    [
        (VividcError("wrong", loc="a.py:3", hint="do right"), 2, "a.py:3: wrong\nhint: do right"),
        (MappingFailed("no way"), 3, "no way"),
        (TimeLimit("too slow"), 4, "too slow"),
        (InternalError("broken"), 1, "broken\nThis is a bug of vividc"),
        (KeyboardInterrupt(), 130, "interrupted"),
        (
            MemoryError("Unable to allocate 9 GiB"),
            2,
            "not enough memory: Unable to allocate 9 GiB\n",
        ),
        (MemoryError(), 2, "not enough memory\nhint: the input is too large"),
        (
            RuntimeError("can't start new thread"),
            2,
            "a thread or a process cannot be started: can't start new thread\nhint: allow more",
        ),
        (BlockingIOError(11, "Resource temporarily unavailable"), 2, "a thread or a process"),
        (ZeroDivisionError("oops"), 1, "ZeroDivisionError: oops (at "),
    ],
)
def test_errors_are_messages(monkeypatch, error, code, text):
    result = run_failing(monkeypatch, error)
    assert result.exit_code == code
    assert result.stdout == ""
    assert result.stderr.startswith(f"vividc: {text}")
    assert "Traceback" not in result.output


def test_traceback_on_request(monkeypatch):
    result = run_failing(monkeypatch, ZeroDivisionError("oops"), VIVIDC_DEBUG="1")
    assert result.exit_code == 1
    assert "Traceback" in result.stderr


@pytest.mark.parametrize(
    "args", [["nothing"], ["--nothing"], ["map"], ["map", "x.json", "--ii", "0"], ["disasm"]]
)
def test_wrong_usage_is_exit_code_2(args):
    result = CliRunner().invoke(main, args)
    assert result.exit_code == 2
    assert "Usage:" in result.stderr


@pytest.mark.parametrize("name", main.commands)
def test_a_list_of_commands_says_of_each_what_it_says(name):
    command = import_module(f"vividc.cli.commands.{name}").command
    listed = main.commands[name]
    assert command.name == name
    for length in (45, 200):
        assert listed.get_short_help_str(length) == command.get_short_help_str(length)


def test_lists_and_versions_load_no_compiler():
    """Of modules, not of seconds: what a user waits for."""
    code = (
        "import sys, vividc; from vividc.cli import main\n"
        "assert vividc.__version__\n"
        "for args in (['--help'], ['--version']): main(args, standalone_mode=False)\n"
        "context = main.make_context('vividc', [], resilient_parsing=True)\n"
        "found = main.shell_complete(context, 's')\n"
        "assert [item.value for item in found] == ['simulate']\n"
        "heavy = {'numba', 'llvmlite', 'ortools', 'numpy', 'pydantic', 'networkx', 'rich'}\n"
        "assert heavy.isdisjoint(sys.modules), heavy & set(sys.modules)\n"
        "assert len(sys.modules) < 400, len(sys.modules)\n"
    )
    run = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, text=True)
    assert (run.returncode, run.stderr) == (0, "")


def test_a_kernel_that_needs_no_solver_is_compiled_without_one(tmp_path):
    """A fifth of a second of each compilation, mostly pandas, which OR-Tools imports."""
    code = (
        "import sys; from vividc.cli import main\n"
        "main(['compile', 'kernels/saxpy.py:saxpy', '-o', sys.argv[1]], standalone_mode=False)\n"
        "assert {'ortools', 'pandas'}.isdisjoint(sys.modules)\n"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "saxpy.vivid")]
    run = subprocess.run(command, check=False, capture_output=True, text=True)
    assert (run.returncode, run.stderr) == (0, "")


def test_help_names_every_command():
    result = CliRunner().invoke(main, ["--help"])
    assert result.exit_code == 0
    for name in ("compile", "simulate", "map", "disasm"):
        assert f"  {name} " in result.stdout


def test_installed_entry_point_runs():
    done = subprocess.run(
        [sys.executable, "-c", "from vividc.cli import main; main()", "map", "missing.json"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("vividc: missing.json: ")


@pytest.mark.parametrize("name", ["compile", "simulate", "map", "disasm"])
def test_help_of_each_command(name):
    result = CliRunner().invoke(main, [name, "--help"])
    assert result.exit_code == 0
    summary = " ".join(result.output.split())
    assert "--json" in summary


def test_interrupt_that_a_callback_swallows_is_no_bug(monkeypatch):
    def interrupt():
        raise KeyboardInterrupt

    @click.command("map")
    def command():
        ctypes.CFUNCTYPE(None)(interrupt)()
        raise RuntimeError("no compiled object yet")

    monkeypatch.setitem(main.commands, "map", command)
    hook = sys.unraisablehook
    result = CliRunner().invoke(main, ["map"])
    assert (result.exit_code, result.stderr) == (130, "vividc: interrupted\n")
    assert sys.unraisablehook is hook


@pytest.mark.parametrize("closed", [">&-", ">&- 2>&-"])
def test_a_closed_stream_takes_nothing_and_stops_nothing(closed, tmp_path):
    (tmp_path / "g.dot").write_text("digraph { a [op=add]; a -> a [dist=1] }")
    command = f"{sys.executable} -m vividc map g.dot --fabric mesh-2x2 -o m.json {closed}"
    done = subprocess.run(command, shell=True, cwd=tmp_path, capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
    assert (tmp_path / "m.json").read_bytes().startswith(b"{")


def test_a_picture_that_memory_does_not_hold_is_a_message(tmp_path):
    """In a child, whose address space is limited."""
    script = """
import resource, sys
import vividc.cli.commands.render
from vividc.cli import main
used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + (300 << 20),) * 2)
main(sys.argv[1:])
"""
    np.savez(tmp_path / "scene.npz", **SCENES["table"]())
    run = subprocess.run(
        [sys.executable, "-c", script, "render", tmp_path / "scene.npz", "--size", "8000x8000"],
        check=False,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert run.returncode == 2, run.stderr
    assert re.match(
        r"vividc: not enough memory: Unable to allocate .*\nhint: the input is too large",
        run.stderr,
    )
