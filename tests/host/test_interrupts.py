"""An interrupt that comes while a callback runs ends the work all the same."""

from __future__ import annotations

import gc
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from vividc.host.watch import heard


@contextmanager
def swallowed(times: int) -> Iterator[None]:
    """So many collections are interrupted in a callback, as hypothesis has one."""
    left = times

    def callback(phase: str, _info: dict[str, int]) -> None:
        nonlocal left
        if phase == "stop" and left:
            left -= 1
            signal.raise_signal(signal.SIGINT)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job has none
    gc.callbacks.append(callback)
    try:
        yield
    finally:
        gc.callbacks.remove(callback)
        signal.signal(signal.SIGINT, before)


def collect_and_wait() -> None:
    """A collection is interrupted, and later something else would be."""
    gc.collect()
    for _ in range(100):
        time.sleep(0.05)


def test_it_comes_again_after_the_callback() -> None:
    with swallowed(1), pytest.raises(KeyboardInterrupt), heard():
        collect_and_wait()


def test_it_comes_again_as_often_as_it_is_swallowed() -> None:
    with swallowed(2), heard() as seen:
        with pytest.raises(KeyboardInterrupt):
            collect_and_wait()
        assert len(seen) == 1
        with pytest.raises(KeyboardInterrupt):
            collect_and_wait()
        assert len(seen) == 2


def test_it_comes_at_the_end_of_the_work_at_the_latest() -> None:
    with swallowed(1), pytest.raises(KeyboardInterrupt), heard():
        gc.collect()


def test_none_comes_where_none_was_swallowed() -> None:
    with swallowed(0), heard() as seen:
        gc.collect()
    assert not seen


def test_inside_another_the_outer_one_knows_it() -> None:
    with swallowed(1), heard() as outer:
        with pytest.raises(KeyboardInterrupt), heard():
            collect_and_wait()
        assert len(outer) == 1


def test_other_faults_of_callbacks_are_reported_as_before() -> None:
    with pytest.MonkeyPatch.context() as patch:
        told: list[object] = []
        patch.setattr("sys.unraisablehook", told.append)

        def callback(*_info: dict[str, int]) -> None:
            raise ValueError

        gc.callbacks.append(callback)
        try:
            with heard() as seen:
                gc.collect()
        finally:
            gc.callbacks.remove(callback)
    assert told
    assert not seen


def test_other_threads_leave_the_hook_alone() -> None:
    seen: list[list[BaseException]] = []

    def work() -> None:
        with heard() as mine:
            seen.append(mine)

    with heard() as ours:
        other = threading.Thread(target=work)
        other.start()
        other.join()
        assert seen == [ours]
