"""Before any command runs: an interrupt, whatever module loads at that moment, and bad settings."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

# The signal comes when the module is looked for: no time is waited for.
SCRIPT = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job has none

MODULE = sys.argv[1]

class Interrupt:
    def find_spec(self, name, path=None, target=None):
        if name == MODULE:
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Interrupt())
"""
AS_SCRIPT = (
    SCRIPT + "from vividc_main import main\nsys.argv[1:] = ['simulate', 'x.vivid']\nmain()\n"
)


@pytest.mark.parametrize("module", ["vividc", "numba.core", "vividc.cli.main"])
def test_an_interrupt_while_modules_load_is_one_line(module):
    run = subprocess.run(
        [sys.executable, "-c", AS_SCRIPT, module],
        check=False,
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert (run.returncode, run.stdout, run.stderr) == (130, "", "vividc: interrupted\n")


def test_as_a_module_too(tmp_path):
    """The interrupt is set by a module that Python runs at its start."""
    (tmp_path / "sitecustomize.py").write_text(SCRIPT.replace("sys.argv[1]", "'numba.core'"))
    run = subprocess.run(
        [sys.executable, "-m", "vividc", "simulate", "x.vivid"],
        check=False,
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=120,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
    )
    assert (run.returncode, run.stdout, run.stderr) == (130, "", "vividc: interrupted\n")


def test_damaged_settings_of_numba_are_named(tmp_path):
    (tmp_path / ".numba_config.yaml").write_text("a: [")
    run = subprocess.run(
        [sys.executable, "-c", "from vividc_main import main; main()", "simulate", "x.vivid"],
        check=False,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=120,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert (run.returncode, run.stdout) == (2, "")
    said = "vividc: .numba_config.yaml: numba cannot read its settings: ParserError: while parsing"
    assert run.stderr.startswith(said)
    assert run.stderr.count("\n") == 2
