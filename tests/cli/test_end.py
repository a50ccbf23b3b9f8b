"""How the process of a command ends."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]

SCRIPT = """
import atexit, os, sys, threading
from vividc_main import main

at_once = os._exit
def _exit(code):
    os.write(1, b"at once\\n")
    at_once(code)
os._exit = _exit
atexit.register(print, "exit function")
print("before")
sys.argv[1:] = ARGUMENTS
BEFORE
main()
"""


def ran(*arguments: str, before: str = "") -> subprocess.CompletedProcess[str]:
    script = SCRIPT.replace("ARGUMENTS", str(list(arguments))).replace("BEFORE", before)
    run = [sys.executable, "-c", script]
    return subprocess.run(run, check=False, cwd=ROOT, capture_output=True, text=True, timeout=120)


def test_memory_is_left_to_the_system_but_nothing_else_is():
    run = ran("--version")
    assert run.returncode == 0
    assert run.stdout.splitlines()[0] == "before"
    assert run.stdout.splitlines()[-2:] == ["exit function", "at once"]


def test_the_exit_code_stays():
    run = ran("no-such-command")
    assert (run.returncode, run.stdout) == (2, "before\nexit function\nat once\n")
    assert "no-such-command" in run.stderr


def test_threads_are_waited_for():
    before = "threading.Timer(0.2, print, ['thread']).start()"
    run = ran("--version", before=before)
    assert run.returncode == 0
    assert run.stdout.splitlines()[-2:] == ["thread", "exit function"]


def test_who_looks_on_sees_the_end():
    run = ran("--version", before="sys.setprofile(lambda *_: None)")
    assert run.returncode == 0
    assert run.stdout.splitlines()[-1] == "exit function"


SHOWN = "import gc; gc.set_threshold({}); atexit.register(lambda: print(gc.get_threshold()[0]))"


def test_garbage_is_looked_for_seldom():
    run = ran("--version", before=SHOWN.format(700))
    assert "50000" in run.stdout.splitlines()


def test_garbage_is_not_looked_for_where_it_was_not():
    run = ran("--version", before=SHOWN.format(0))
    assert "0" in run.stdout.splitlines()
