"""Jobs that a copy of this process does ahead of it.

Python runs one thread at a time: a second core takes a second process. A copy has what the jobs
need in its memory, so that they may begin at once, and only what comes of them is sent.
"""

from __future__ import annotations

import gc
import mmap
import os
import pickle
import signal
import struct
import sys
import threading
import warnings
from collections import deque
from collections.abc import Callable, Hashable, Iterator, Mapping
from contextlib import contextmanager, suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Final, Generic, NoReturn, TypeVar

from vividc.errors import TimeLimit
from vividc.host import time_limit

_Job = TypeVar("_Job")
_Done = TypeVar("_Done")

_OPEN, _OURS, _THEIRS = range(3)
"""Who does a job: nobody yet, this process, the copy. Two who take one at the same time do it
twice."""

_MOST_JOBS: Final = 1 << 12
_RESULT: Final = struct.Struct("=qqq")
"""Of a job: its number, where its result lies, how long that is; 0: it failed."""
_POLL_S: Final = 0.05
_LOST_S: Final = 60.0
"""A job takes seconds: a copy that does not answer for so long never will."""

_WRITES_ONLY: Final = "rich."
"""Threads of this package write to a terminal, as a copy does not."""


class Ahead(Generic[_Job, _Done]):
    """Does jobs in a copy of this process, which is made for the first of them.

    Whoever comes to a job first does it, so that it may be done by both or by neither: `do` must
    depend on nothing but the job and what does not change, and leave nothing behind but its result,
    which is pickled.
    """

    def __init__(self, do: Callable[[_Job], _Done]) -> None:
        self._do = do
        self._numbers: dict[Hashable, int] = {}
        self._open: deque[tuple[int, _Job]] = deque()
        self._done: dict[int, tuple[_Done] | None] = {}
        self._copy: _Copy | None = None
        self._is_able = may_be_copied()

    def begin(self, jobs: Mapping[Hashable, _Job], *, perhaps: bool = False) -> None:
        """Have these done, by name, in their order, those that are not known yet; `perhaps`: when
        the copy has nothing else to do.
        """
        new = {name: job for name, job in jobs.items() if name not in self._numbers}
        if not new or not self._is_able or len(self._numbers) + len(new) > _MOST_JOBS:
            return
        if self._copy is None:
            try:
                self._copy = _Copy(self._do)
            except OSError:  # there may be no more processes or files
                self._is_able = False
                return
        numbers = range(len(self._numbers), len(self._numbers) + len(new))
        self._numbers.update(zip(new, numbers, strict=True))
        sent = list(zip(numbers, new.values(), strict=True))
        self._open += [] if perhaps else sent
        try:
            self._copy.pipe.send((perhaps, sent))
        except OSError:
            self.stop()

    def result(self, name: Hashable) -> tuple[_Done] | None:
        """What has come of a job, alone in a tuple, when it is done; None: the caller has to do it.

        Raises
        ------
        TimeLimit
            Time was up before the copy was done.
        """
        number, copy = self._numbers.get(name), self._copy
        if number is None or copy is None:
            return None
        while number not in self._done:
            if copy.marks[number] == _OPEN:
                copy.marks[number] = _OURS
            if copy.marks[number] == _OURS:
                return None
            if not self._has_heard(copy, 0.0) and not self._does_another(copy):
                self._waits(copy)
            if self._copy is None:
                return None
        return self._done[number]

    def _has_heard(self, copy: _Copy, seconds: float) -> bool:
        """Whether a result came within so many seconds, or the copy's end."""
        try:
            if not copy.pipe.poll(seconds):
                return False
            number, place, length = _RESULT.unpack(copy.pipe.recv_bytes())
            data = os.pread(copy.results, length, place)
            self._done[number] = (pickle.loads(data),) if length else None
        except (OSError, EOFError):
            self.stop()
        return True

    def _does_another(self, copy: _Copy) -> bool:
        """Does the next job that nobody does, if there is one, meanwhile."""
        while self._open:
            number, job = self._open.popleft()
            if copy.marks[number] == _OPEN:
                copy.marks[number] = _OURS
                try:
                    self._done[number] = (self._do(job),)
                except TimeLimit:
                    raise
                except Exception:
                    continue
                return True
        return False

    def _waits(self, copy: _Copy) -> None:
        """Waits for a result while there is time, and as long as the copy is not lost."""
        waited = 0.0
        while not self._has_heard(copy, _POLL_S):
            time_limit.step("jobs were done side by side")
            waited += _POLL_S
            if waited > _LOST_S:
                self.stop()
                return

    def stop(self) -> None:
        """End the copy; all other jobs are the caller's."""
        self._is_able = False
        if self._copy is not None:
            self._copy.stop()
            self._copy = None


@contextmanager
def ahead(do: Callable[[_Job], _Done]) -> Iterator[Ahead[_Job, _Done]]:
    """Yield a copy that ends with what is done inside."""
    made = Ahead(do)
    try:
        yield made
    finally:
        made.stop()


class _Copy:
    """The process, a pipe to it, what it shares: who does which job, and a file of results."""

    def __init__(self, do: Callable[[_Job], _Done]) -> None:
        self.marks = mmap.mmap(-1, _MOST_JOBS)
        self.results = os.memfd_create("vividc-results")
        self.pipe, theirs = Pipe()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # no thread holds what it needs
            try:
                self._process = os.fork()
            except OSError:
                theirs.close()
                self._close()
                raise
        if not self._process:
            self._serve(theirs, do)
        theirs.close()

    def _serve(self, pipe: Connection, do: Callable[[_Job], _Done]) -> NoReturn:
        """Do what is asked for until the other process or its end of the pipe is gone."""
        try:
            signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that waits
            signal.signal(signal.SIGTERM, signal.SIG_DFL)
            gc.freeze()  # what was there before stays shared
            self.pipe.close()
            self._work(pipe, do)
        except (OSError, EOFError):
            pass
        finally:
            os._exit(0)

    def _work(self, pipe: Connection, do: Callable[[_Job], _Done]) -> NoReturn:
        surely: deque[tuple[int, _Job]] = deque()
        perhaps: deque[tuple[int, _Job]] = deque()
        end = 0
        while True:
            while pipe.poll() or not (surely or perhaps):
                is_perhaps, jobs = pipe.recv()
                (perhaps if is_perhaps else surely).extend(jobs)
            number, job = (surely or perhaps).popleft()
            if self.marks[number] == _OPEN:
                self.marks[number] = _THEIRS
                done = _pickled(do, job)
                os.pwrite(self.results, done, end)
                pipe.send_bytes(_RESULT.pack(number, end, len(done)))
                end += len(done)

    def stop(self) -> None:
        """Kill the process."""
        with suppress(OSError):
            os.kill(self._process, signal.SIGKILL)
        with suppress(OSError):
            os.waitpid(self._process, 0)
        self._close()

    def _close(self) -> None:
        self.pipe.close()
        self.marks.close()
        os.close(self.results)


def _pickled(do: Callable[[_Job], _Done], job: _Job) -> bytes:
    """What comes of a job; nothing if it fails, as it will where that is of interest."""
    try:
        return pickle.dumps(do(job), pickle.HIGHEST_PROTOCOL)
    except Exception:
        return b""


def may_be_copied() -> bool:
    """Whether there is a core for a copy, and no thread that may hold what the copy needs."""
    if sys.platform != "linux" or len(os.sched_getaffinity(0)) == 1:
        return False
    here = threading.current_thread()
    others = [one for one in threading.enumerate() if one is not here]
    return all(type(one).__module__.startswith(_WRITES_ONLY) for one in others)
