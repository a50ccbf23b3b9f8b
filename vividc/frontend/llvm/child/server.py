"""The server: reads requests from its standard input, and forks for each."""

from __future__ import annotations

import os
import resource
import select
import signal
import sys
import time

from vividc.frontend.llvm.child.messages import Header, reader, receive, send, writer
from vividc.frontend.llvm.child.work import WORK, prepare

_CHUNK = 1 << 20


def serve() -> None:
    """Answer requests until the client is gone.

    An answer's header says how the request ended: "signal" (0: in order), "late" (its time was up).
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the client's, which then leaves
    prepare()
    while True:
        try:
            header, blobs = receive(reader(0))
        except EOFError:
            return
        ending, answer = _apart(header, blobs)
        send(writer(1), ending, [answer])


def _apart(header: Header, blobs: list[bytes]) -> tuple[Header, bytes]:
    """Do a request in a process of its own: how that ended, and what it wrote."""
    source, sink = os.pipe()
    worker = os.fork()
    if not worker:
        os.close(source)
        _work(header, blobs, sink)
    os.close(sink)
    try:
        answer, late = _collected(source, time.monotonic() + header["limit_s"])
    except EOFError:
        os.kill(worker, signal.SIGKILL)
        sys.exit()
    finally:
        os.close(source)
    if late:
        os.kill(worker, signal.SIGKILL)
    _, status = os.waitpid(worker, 0)
    ended = os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0
    ended = signal.SIGXCPU if late else ended
    return {"signal": int(ended), "late": ended == signal.SIGXCPU}, answer


def _collected(source: int, deadline: float) -> tuple[bytes, bool]:
    """All that comes, and whether the time was up before its end.

    Raises
    ------
    EOFError
        The client is gone.
    """
    watched = select.poll()
    watched.register(source, select.POLLIN)
    watched.register(0, select.POLLIN)  # the client says nothing while it waits, but goes
    parts: list[bytes] = []
    while True:
        left = deadline - time.monotonic()
        events = dict(watched.poll(max(left, 0) * 1000))
        if 0 in events:
            raise EOFError
        if not events:
            return b"", True
        part = os.read(source, _CHUNK)
        if not part:
            return b"".join(parts), False
        parts.append(part)


def _work(header: Header, blobs: list[bytes], sink: int) -> None:
    """The worker: never returns."""
    try:
        nothing = os.open(os.devnull, os.O_RDWR)
        os.dup2(nothing, 0)
        os.dup2(nothing, 1)
        _limit(header)
        answer, results = WORK[header["do"]](header, blobs, sink)
        send(writer(sink), answer, results)
    except MemoryError:
        send(writer(sink), {"error": "it takes too much memory", "kind": "memory"}, [])
    finally:
        os._exit(0)


def _limit(header: Header) -> None:
    seconds = int(header["limit_s"]) + 1
    for kind, most in (
        (resource.RLIMIT_CPU, seconds),
        (resource.RLIMIT_DATA, header["memory_bytes"]),
        (resource.RLIMIT_FSIZE, 0),
        (resource.RLIMIT_CORE, 0),
    ):
        _, hard = resource.getrlimit(kind)
        allowed = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(kind, (allowed, allowed))
