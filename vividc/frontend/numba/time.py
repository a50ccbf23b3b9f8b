"""The time limit of a kernel that numba types: it is asked before each of numba's passes, and at
each operation in the two long ones.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import event
from numba.core.typing import Context

from vividc.errors import TimeLimit
from vividc.host import time_limit


class _OutOfTime(BaseException):
    """Passes through numba, which catches any Exception, rewords it and tries something else."""

    def __init__(self, error: TimeLimit) -> None:
        self.error = error


def ask() -> None:
    """`time_limit.step`, within `in_time`."""
    try:
        time_limit.step("numba typed it")
    except TimeLimit as error:
        raise _OutOfTime(error) from None


class TimedTyping(Context):  # type: ignore[misc]
    """Numba's typing, which asks at each operation."""

    def resolve_function_type(self, func: Any, args: Any, kws: Any) -> Any:
        """As numba's."""
        ask()
        return super().resolve_function_type(func, args, kws)


class _Watch(event.Listener):  # type: ignore[misc]
    """Asks for the time before each of numba's passes."""

    def on_start(self, event: object) -> None:
        ask()

    def on_end(self, event: object) -> None:
        """Nothing is to be done."""


@contextmanager
def in_time() -> Iterator[None]:
    """Numba's passes are made within the time limit.

    Raises
    ------
    TimeLimit
        Time is up before a pass.
    """
    try:
        with event.install_listener("numba:run_pass", _Watch()):
            yield
    except _OutOfTime as end:
        raise end.error from None
