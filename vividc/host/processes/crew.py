"""Items of work shared among this process and helpers, each a process of its own.

Python runs one thread at a time: a second core takes a second process. Helpers are started by
command line, so that a script needs no `if __name__ == "__main__"`. A helper's module is run with
the file descriptor of a pipe, over which comes a greeting, which it answers when it is ready, and
then items; it answers each with what comes of it, or with None where it fails.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from multiprocessing import Pipe
from multiprocessing.reduction import ForkingPickler
from typing import Final, Generic, TypeVar

_Item = TypeVar("_Item")
_Done = TypeVar("_Done")

_LIFELINE: Final = "vividc.host.processes.lifeline"
_POLL_S: Final = 0.05
MOST: Final = 4
"""Processes that share work: each has its programs in memory."""


@dataclass(frozen=True, slots=True)
class Helpers:
    """How many there are to be, the module that they run, and what they are greeted with."""

    count: int
    module: str
    greeting: object


NOBODY: Final = Helpers(0, "", None)


@dataclass(eq=False)
class _Board(Generic[_Item, _Done]):
    """The items that nobody has taken yet, and the results of the others."""

    items: Sequence[_Item]
    open: deque[int]
    done: dict[int, _Done] = field(default_factory=dict)

    def take(self) -> int | None:
        """Return the number of an open item, if there is one."""
        try:
            return self.open.popleft()
        except IndexError:
            return None


class _Helper(Generic[_Item, _Done]):
    """A process, and the thread that gives it items until none is left or it fails."""

    def __init__(self, how: Helpers, board: _Board[_Item, _Done]) -> None:
        self._greeting, self._board = ForkingPickler.dumps(how.greeting), board
        self._pipe, theirs = Pipe()
        watched, self._lifeline = os.pipe()
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", _LIFELINE, str(watched), how.module, str(theirs.fileno())],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
            pass_fds=[watched, theirs.fileno()],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # Ctrl-C is for the process that waits for it
        )
        theirs.close()
        os.close(watched)
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def _serve(self) -> None:
        taken = None
        try:
            self._pipe.send_bytes(self._greeting)
            self._pipe.recv()  # it is ready
            while (taken := self._board.take()) is not None:
                self._pipe.send(self._board.items[taken])
                result = self._pipe.recv()
                if result is None:
                    break
                self._board.done[taken] = result
        except (OSError, EOFError):  # it died, or was stopped
            pass
        if taken is not None and taken not in self._board.done:
            self._board.open.append(taken)

    def stop(self) -> None:
        """Kill the process."""
        self._process.kill()
        self._process.wait()
        os.close(self._lifeline)
        self._thread.join()
        self._pipe.close()


def processes_for(items: int, each: int = 1) -> int:
    """Return how many processes so many items are worth, if one takes at least `each`."""
    if os.name != "posix":
        return 1
    return max(1, min(os.cpu_count() or 1, MOST, items // each))


def share_out(
    items: Sequence[_Item],
    do: Callable[[_Item], _Done],
    helpers: Helpers = NOBODY,
    *,
    alone: int = 0,
    progress: Callable[[int], None] | None = None,
) -> list[_Done]:
    """Do all items, the first first; the results may not depend on who did which.

    Parameters
    ----------
    do
        Does an item in this process, which has those with which a helper failed, too.
    alone
        How many of the first items this process does before helpers start.
    progress
        Called with the number of items that are done.
    """
    tell = progress or (lambda _: None)
    board: _Board[_Item, _Done] = _Board(items, deque(range(len(items))))
    for _ in range(min(alone, len(items))):
        _do_one(board, do)
    with _helping(helpers, board):
        while len(board.done) < len(items):
            tell(len(board.done))
            if not _do_one(board, do):
                time.sleep(_POLL_S)
    tell(len(items))
    return [board.done[number] for number in range(len(items))]


def _do_one(board: _Board[_Item, _Done], do: Callable[[_Item], _Done]) -> bool:
    """Do an open item, if there is one."""
    number = board.take()
    if number is not None:
        board.done[number] = do(board.items[number])
    return number is not None


@contextmanager
def _helping(how: Helpers, board: _Board[_Item, _Done]) -> Iterator[None]:
    """Have helpers take items from the board."""
    helpers: list[_Helper[_Item, _Done]] = []
    try:
        for _ in range(how.count):
            helpers.append(_Helper(how, board))
        yield
    finally:
        for helper in helpers:
            helper.stop()
