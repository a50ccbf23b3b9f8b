"""A copy of the process does one piece of work beside it."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from tests.host.processes import scripts

pytestmark = pytest.mark.skipif(
    sys.platform != "linux" or len(os.sched_getaffinity(0)) == 1,
    reason="copies of a process are made on Linux, where there is a second core",
)

BEGIN = """
import os, signal, sys, threading, time
from vividc.errors import TimeLimit
from vividc.host import time_limit
from vividc.host.processes.beside import Beside
here = os.getpid()
"""


def printed(script: str, folder: Path) -> str:
    """What a script prints, which begins as all do."""
    return scripts.printed(BEGIN + script, folder)


def test_it_is_done_elsewhere_and_what_changes_later_is_not_seen(tmp_path: Path) -> None:
    script = """
known = [1, 2]
work = Beside(lambda: (sum(known), os.getpid() != here, len(bytes(1 << 22))))
known.append(4)
print(work.result(), work.result())
work.stop()
"""
    assert printed(script, tmp_path) == "((3, True, 4194304),) None\n"


@pytest.mark.parametrize("end", ["os._exit(1)", "os.kill(os.getpid(), signal.SIGKILL)", "1 / 0"])
def test_what_the_copy_fails_at_is_left_to_the_caller(tmp_path: Path, end: str) -> None:
    script = f"""
def do():
    {end}
print(Beside(do).result())
"""
    assert printed(script, tmp_path) == "None\n"


def test_a_time_limit_ends_the_wait_and_the_copy(tmp_path: Path) -> None:
    script = """
def do():
    time.sleep(2)
    open("done", "w").close()
work = Beside(do)
try:
    with time_limit.limited(0.2, "it was done"):
        work.result()
except TimeLimit:
    work.stop()
    work.stop()
time.sleep(3)
print(os.path.exists("done"), work.result())
"""
    assert printed(script, tmp_path) == "False None\n"


def test_no_copy_is_made_of_a_process_with_threads_or_on_one_core(tmp_path: Path) -> None:
    script = """
thread = threading.Thread(target=time.sleep, args=(0.5,))
thread.start()
print(Beside(lambda: 1).result())
thread.join()
os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
print(Beside(lambda: 1).result())
"""
    assert printed(script, tmp_path) == "None\nNone\n"


def test_where_no_process_can_be_made_the_caller_does_all(tmp_path: Path) -> None:
    script = """
def fork():
    raise BlockingIOError("no more processes")
os.fork = fork
work = Beside(lambda: 1)
print(work.result())
work.stop()
"""
    assert printed(script, tmp_path) == "None\n"
