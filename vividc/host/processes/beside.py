"""Work that a copy of this process does while it goes on: one piece, that is begun at once."""

from __future__ import annotations

import gc
import os
import pickle
import signal
import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from typing import Final, Generic, NoReturn, TypeVar

from vividc.host import time_limit
from vividc.host.processes.ahead import may_be_copied

_Done = TypeVar("_Done")

_NICE: Final = 5
"""The copy gives way to what this process and others do: a third of their time, where cores are
short."""
_POLL_S: Final = 0.01
_LOST_S: Final = 60.0
"""A copy that is not done so long after it was asked for never will be."""


class Beside(Generic[_Done]):
    """What comes of `do`, done by a copy of this process as it is now: it must depend on nothing
    that changes outside, and leave nothing behind but its result, which is pickled.
    """

    def __init__(self, do: Callable[[], _Done]) -> None:
        self._process = 0
        if not may_be_copied():
            return
        try:
            self._file = os.memfd_create("vividc-beside")
        except OSError:  # there may be no more files
            return
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # no thread holds what it needs
            try:
                self._process = os.fork()
            except OSError:  # nor processes
                os.close(self._file)
                return
            if not self._process:
                self._serve(do)

    def _serve(self, do: Callable[[], _Done]) -> NoReturn:
        try:
            signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that waits
            signal.signal(signal.SIGTERM, signal.SIG_DFL)
            gc.freeze()  # what was there before stays shared
            os.nice(_NICE)
            with open(self._file, "wb", closefd=False) as file:
                file.write(pickle.dumps(do(), pickle.HIGHEST_PROTOCOL))
            os._exit(0)
        finally:
            os._exit(1)

    def result(self) -> tuple[_Done] | None:
        """What has come of it, alone in a tuple; None: the caller has to do it.

        Raises
        ------
        TimeLimit
            Time was up before the copy was done.
        """
        if not self._process:
            return None
        until = time.monotonic() + _LOST_S
        ended, status = os.waitpid(self._process, os.WNOHANG)
        while not ended and time.monotonic() < until:
            time_limit.step("work was done side by side")
            time.sleep(_POLL_S)
            ended, status = os.waitpid(self._process, os.WNOHANG)
        if not ended:
            return None
        self._process = 0
        with open(self._file, "rb") as file:
            file.seek(0)
            return (pickle.load(file),) if status == 0 else None

    def stop(self) -> None:
        """End the copy."""
        if self._process:
            with suppress(OSError):
                os.kill(self._process, signal.SIGKILL)
            with suppress(OSError):
                os.waitpid(self._process, 0)
            os.close(self._file)
            self._process = 0
