"""The script `vividc`, and how modules load: an interrupt meanwhile is one line and exit code 130.

Outside the package, so that nothing is loaded before it says so.
"""

import atexit
import gc
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

_INTERRUPTED = 130
_WRONG_INPUT = 2
_MOST = 300
_BYTE = 0xFF
_NUMBAS_SETTINGS = ".numba_config.yaml"

_SELDOM = (50_000, 20, 20)
"""Objects until Python looks for garbage, and looks until it looks farther: modules stay, and looks
at Python's 700 objects took a seventh of the CPU time until a kernel is typed.
"""


def _leave(_signal: int, _frame: FrameType | None) -> None:
    """End at once: an exception could be swallowed or dressed up by a module that is loading."""
    os.write(2, b"vividc: interrupted\n")
    os._exit(_INTERRUPTED)


@contextmanager
def loading() -> Iterator[None]:
    """Around imports of a command's modules: of the commands, not of what they run later."""
    before = signal.getsignal(signal.SIGINT)
    if before is signal.default_int_handler:  # else: ignored
        signal.signal(signal.SIGINT, _leave)
    try:
        yield
    except Exception as error:
        if not os.path.exists(_NUMBAS_SETTINGS):
            raise
        what = " ".join(f"{type(error).__name__}: {error}".split())[:_MOST]
        sys.stderr.write(f"vividc: {_NUMBAS_SETTINGS}: numba cannot read its settings: {what}\n")
        sys.stderr.write("hint: repair or remove the file; it is in the current folder\n")
        sys.exit(_WRONG_INPUT)
    finally:
        if signal.getsignal(signal.SIGINT) is _leave:
            signal.signal(signal.SIGINT, signal.default_int_handler)


def main() -> None:
    """Run the command line, and end the process with its exit code."""
    if gc.get_threshold()[0]:
        gc.set_threshold(*_SELDOM)
    with loading():
        from vividc.cli.main import main as command  # noqa: PLC0415 - under the handler
    try:
        command(prog_name="vividc")
    except SystemExit as end:
        _end_soon(end.code)
        raise


def _end_soon(code: object) -> None:
    """End the process as the interpreter does, but leave its memory to the system: to free what a
    compilation has made, object by object, takes a twelfth of its time. Not where somebody waits
    for more: other threads, or who looks on.
    """
    is_alone = threading.active_count() == 1
    is_watched = sys.flags.inspect or sys.getprofile() is not None or sys.gettrace() is not None
    if not isinstance(code, int | None) or not is_alone or is_watched:
        return
    atexit._run_exitfuncs()
    try:
        for stream in (sys.stdout, sys.stderr):
            if stream is not None:
                stream.flush()
    except (OSError, ValueError):  # the interpreter says so
        return
    os._exit((code or 0) & _BYTE)
