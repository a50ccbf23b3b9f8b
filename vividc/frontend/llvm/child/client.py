"""The client: starts the server when it is first needed, and restarts it if it is lost."""

from __future__ import annotations

import atexit
import io
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Sequence
from pathlib import Path

import llvmlite

from vividc.errors import VividcError
from vividc.frontend.llvm.child.messages import Header, receive, send

_START = """
import sys, types
for name, place in (("vividc", sys.argv[1]), ("vividc.frontend", sys.argv[1] + "/frontend")):
    package = sys.modules[name] = types.ModuleType(name)
    package.__path__ = [place]
sys.path.append(sys.argv[2])
from vividc.frontend.llvm.child.server import serve
serve()
"""
"""The packages above the server's are not run: they import all of vividc."""
_HINT = "C kernels are read and run in processes of their own: allow three (ulimit -u)"
MEMORY_BYTES = 4 << 30
"""What a request may allocate."""


class Lost(Exception):
    """The process that did a request died of a signal: its name."""


class Late(Exception):
    """A request took more than its time."""


class _Server:
    def __init__(self) -> None:
        package, site = Path(__file__).parents[3], Path(llvmlite.__file__).parents[1]
        command = [sys.executable, "-I", "-c", _START, str(package), str(site)]
        self.owner = os.getpid()
        try:
            self.process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                bufsize=0,
            )
        except OSError as error:
            raise VividcError(
                f"a process that reads C cannot be started: {error.strerror}",
                hint=_HINT,
            ) from error

    def ask(self, header: Header, blobs: Sequence[bytes]) -> tuple[Header, bytes]:
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        send(self.process.stdin.write, header, blobs)
        ending, [answer] = receive(self.process.stdout.read)
        return ending, answer

    def stop(self) -> None:
        for stream in (self.process.stdin, self.process.stdout):
            if stream is not None:
                stream.close()
        if self.owner == os.getpid():
            self.process.kill()
            self.process.wait()


_locks = [threading.Lock()]
_running: list[_Server] = []


def ask(
    header: Header, blobs: Sequence[bytes] = (), *, limit_s: float, memory_bytes: int = MEMORY_BYTES
) -> tuple[Header, list[bytes]]:
    """Let the server do a request of `work`.

    Parameters
    ----------
    limit_s, memory_bytes
        What the request may take.

    Raises
    ------
    Late
        It took more than its time.
    Lost
        Its process died.
    VividcError
        No process can be started, or it was ended from outside.
    """
    header = {**header, "limit_s": limit_s, "memory_bytes": memory_bytes}
    with _locks[0]:
        ending, answer = _asked(header, blobs)
    if ending["late"]:
        raise Late
    try:
        return receive(io.BytesIO(answer).read)
    except EOFError as error:
        if ending["signal"]:
            raise Lost(signal.Signals(ending["signal"]).name) from error
        raise VividcError("the process that reads C ended without an answer", hint=_HINT) from error


def _asked(header: Header, blobs: Sequence[bytes]) -> tuple[Header, bytes]:
    if _running and (_running[0].owner != os.getpid() or _running[0].process.poll() is not None):
        _stop()
    if not _running:
        _running.append(_Server())
    try:
        return _running[0].ask(header, blobs)
    except (OSError, EOFError):
        _stop()
        return {"late": False, "signal": 0}, b""
    except BaseException:
        _stop()  # its answer is still to come, and is nobody's
        raise


def _forget() -> None:
    """In a fork: the lock may be held by a thread that is not here."""
    _locks[0] = threading.Lock()


os.register_at_fork(after_in_child=_forget)


@atexit.register
def _stop() -> None:
    while _running:
        _running.pop().stop()
