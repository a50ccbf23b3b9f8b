"""Shares the batches of a frame among this process and helpers, each with its own device.

What the simulator does between two runs of machine code is Python, one thread at a time: a second
core takes a second process. Helpers are started by command line, so that a script that renders
needs no `if __name__ == "__main__"`.
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
from typing import Final

from vividc.render.array.device.frame import Ledger
from vividc.render.array.march.depths import Blocks
from vividc.render.array.options import ArrayOptions
from vividc.render.arrays import Float32Array
from vividc.render.camera import Camera
from vividc.render.scenes import Scene

_LIFELINE: Final = "vividc.host.lifeline"
HELPER: Final = "vividc.render.array.march.helper"
_BATCHES_EACH: Final = 2
"""Least batches of a process: a helper takes some seconds to load its programs."""
_MOST: Final = 4
"""Processes: each has the scene and its programs in memory."""
_POLL_S: Final = 0.05

Batch = tuple[Float32Array, Ledger]
"""Pixels of blocks [n, 64, 4], and what they cost."""


@dataclass(frozen=True, slots=True, eq=False)
class Work:
    """What a helper needs to know about a frame."""

    scene: Scene
    camera: Camera
    options: ArrayOptions


@dataclass(eq=False)
class _Board:
    """The batches that nobody has taken yet, and the results of the others."""

    batches: Sequence[Blocks]
    open: deque[int]
    done: dict[int, Batch] = field(default_factory=dict)

    def take(self) -> int | None:
        """Return the number of an open batch, if there is one."""
        try:
            return self.open.popleft()
        except IndexError:
            return None


class _Helper:
    """A process, and the thread that gives it batches until none is left or it fails."""

    def __init__(self, work: Work, board: _Board) -> None:
        self._work, self._board = work, board
        self._pipe, theirs = Pipe()
        watched, self._lifeline = os.pipe()
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", _LIFELINE, str(watched), HELPER, str(theirs.fileno())],
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
            self._pipe.send(self._work)
            self._pipe.recv()  # it is ready
            while (taken := self._board.take()) is not None:
                self._pipe.send(self._board.batches[taken])
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


def processes_for(batches: int) -> int:
    """Return how many processes a frame of so many batches is worth."""
    if os.name != "posix":
        return 1
    return max(1, min(os.cpu_count() or 1, _MOST, batches // _BATCHES_EACH))


def share_out(
    work: Work | None,
    batches: Sequence[Blocks],
    render: Callable[[Blocks], Batch],
    progress: Callable[[int], None],
) -> list[Batch]:
    """Render all batches; the results do not depend on who rendered which.

    Parameters
    ----------
    work
        For helpers; None: none are wanted.
    batches
        Blocks of pixels.
    render
        Renders a batch in this process. It has the first one, so that kernels are compiled and kept
        before helpers want them; and those with which a helper failed.
    progress
        Called with the number of batches that are done.
    """
    board = _Board(batches, deque(range(len(batches))))
    first = board.take()
    if first is not None:
        board.done[first] = render(batches[first])
    with _helpers(work, board):
        while len(board.done) < len(batches):
            progress(len(board.done))
            number = board.take()
            if number is None:
                time.sleep(_POLL_S)
            else:
                board.done[number] = render(batches[number])
    progress(len(batches))
    return [board.done[number] for number in range(len(batches))]


@contextmanager
def _helpers(work: Work | None, board: _Board) -> Iterator[None]:
    """Have helpers take batches from the board."""
    helpers: list[_Helper] = []
    try:
        if work is not None:
            for _ in range(processes_for(len(board.batches)) - 1):
                helpers.append(_Helper(work, board))
        yield
    finally:
        for helper in helpers:
            helper.stop()
