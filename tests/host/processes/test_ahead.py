"""A copy of the process does jobs ahead; whoever does them, the results are the same."""

from __future__ import annotations

import os
import sys
import time
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
from vividc.host.processes.ahead import ahead

def other(name):
    "Waits until the copy has done a job."
    while not os.path.exists(name):
        time.sleep(0.01)
"""


def printed(script: str, folder: Path) -> str:
    """What a script prints, which begins as all do."""
    return scripts.printed(BEGIN + script, folder)


def test_jobs_are_done_by_the_copy_and_by_the_process_itself(tmp_path: Path) -> None:
    script = """
here = os.getpid()
with ahead(lambda n: (n * n, os.getpid() != here)) as copy:
    copy.begin({n: n for n in range(40)})
    time.sleep(0.5)
    copy.begin({n: n for n in range(40, 44)})
    got = [copy.result(n) or ((n * n, False),) for n in range(44)]
print([one[0][0] for one in got] == [n * n for n in range(44)], got[0][0][1], copy.result(99))
"""
    assert printed(script, tmp_path) == "True True None\n"


def test_meanwhile_the_process_does_what_nobody_does_yet(tmp_path: Path) -> None:
    script = """
def do(name):
    if name == "first":
        open("begun", "w").close()
        other("second")
    else:
        open("second", "w").close()
    return name
with ahead(do) as copy:
    copy.begin({"first": "first"})
    other("begun")
    copy.begin({"second": "second"})
    print(copy.result("first"), copy.result("second"))
"""
    assert printed(script, tmp_path) == "('first',) ('second',)\n"


@pytest.mark.parametrize("end", ["os._exit(1)", "os.kill(os.getpid(), signal.SIGKILL)", "1 / 0"])
def test_what_the_copy_fails_at_is_left_to_the_process(tmp_path: Path, end: str) -> None:
    script = f"""
here = os.getpid()
def do(name):
    open("begun", "w").close()
    if os.getpid() != here:
        time.sleep(0.1)
        {end}
with ahead(do) as copy:
    copy.begin({{1: 1}})
    other("begun")
    print(copy.result(1))
"""
    assert printed(script, tmp_path) == "None\n"


def test_a_time_limit_ends_the_wait(tmp_path: Path) -> None:
    script = """
def do(name):
    open("begun", "w").close()
    time.sleep(50)
try:
    with time_limit.limited(0.2, "it was done"), ahead(do) as copy:
        copy.begin({1: 1})
        other("begun")
        copy.result(1)
except TimeLimit:
    print("in time")
"""
    assert printed(script, tmp_path) == "in time\n"


def test_a_copy_ends_with_the_process_that_made_it(tmp_path: Path) -> None:
    script = """
def do(name):
    with open("begun", "w") as file:
        file.write(str(os.getpid()))
with ahead(do) as copy:
    copy.begin({1: 1})
    while not (os.path.exists("begun") and (pid := open("begun").read())):
        time.sleep(0.01)
    print(pid, flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
"""
    pid = int(printed(script, tmp_path))
    for _ in range(500):
        if not is_running(pid):
            return
        time.sleep(0.01)
    pytest.fail("the copy still runs")


def is_running(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1]
        return state.split()[0] != "Z"
    except OSError:
        return False


def test_no_copy_is_made_of_a_process_with_threads_of_others(tmp_path: Path) -> None:
    script = """
end = threading.Event()
threading.Thread(target=end.wait).start()
with ahead(lambda n: n) as copy:
    copy.begin({1: 1})
    time.sleep(0.3)
    print(copy.result(1))
end.set()
"""
    assert printed(script, tmp_path) == "None\n"


def test_where_no_process_can_be_made_the_caller_does_all(tmp_path: Path) -> None:
    script = """
def refuse():
    raise BlockingIOError
os.fork = refuse
with ahead(lambda n: n) as copy:
    copy.begin({1: 1})
    print(copy.result(1))
"""
    assert printed(script, tmp_path) == "None\n"
