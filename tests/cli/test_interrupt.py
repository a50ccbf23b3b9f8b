"""An interrupt before any command runs: the module that loads at that moment does not matter."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

# The signal comes when the module is looked for: no time is waited for.
SCRIPT = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job has none

class Interrupt:
    def find_spec(self, name, path=None, target=None):
        if name == sys.argv[1]:
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Interrupt())
from vividc_main import main
main()
"""


@pytest.mark.parametrize("module", ["vividc", "numba.core", "vividc.cli.main"])
def test_an_interrupt_while_modules_load_is_one_line(module):
    run = subprocess.run(
        [sys.executable, "-c", SCRIPT, module],
        check=False,
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert (run.returncode, run.stdout, run.stderr) == (130, "", "vividc: interrupted\n")
