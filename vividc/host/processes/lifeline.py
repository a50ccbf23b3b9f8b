"""Runs a module in a process that ends when the process that started it ends, however that happens.

`python -m vividc.host.processes.lifeline FD MODULE ARGS...`: FD is the reading end of a pipe of
which the other process holds the writing end, and never writes: its end, even by SIGKILL, closes
it.
"""

from __future__ import annotations

import os
import runpy
import sys
import threading


def watch(descriptor: int) -> None:
    """End this process as soon as the pipe's writing end is closed."""

    def wait() -> None:
        os.read(descriptor, 1)
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()


if __name__ == "__main__":
    watch(int(sys.argv[1]))
    del sys.argv[:2]
    runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
