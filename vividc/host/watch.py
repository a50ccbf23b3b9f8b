"""Passes as lists of functions, an observer of what each one leaves, whom to tell, how often
garbage is looked for meanwhile, and interrupts that a callback would swallow.

Nobody looks unless asked (`vividc compile --print-after`): what is only tried, such as the
estimates behind a choice, is `aside`.
"""

from __future__ import annotations

import _thread
import gc
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from typing import Final, TypeVar

from vividc.errors import VividcWarning

_IR = TypeVar("_IR")


@dataclass(slots=True)
class Watch:
    """`look` is called with a pass's name and what it left; `seconds` adds up by name."""

    look: Callable[[str, object], None]
    seconds: dict[str, float] = field(default_factory=dict)

    def add(self, name: str, began: float) -> None:
        """Count the seconds since `began`, of the performance counter."""
        self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - began


_current: ContextVar[Watch | None] = ContextVar("watch", default=None)


@contextmanager
def watching(watch: Watch | None) -> Iterator[None]:
    """What passes inside is looked at by `watch`; None: by nobody."""
    token = _current.set(watch)
    try:
        yield
    finally:
        _current.reset(token)


_told: ContextVar[Callable[..., None] | None] = ContextVar("told", default=None)


@contextmanager
def told(tell: Callable[..., None]) -> Iterator[None]:
    """Long work inside tells `tell` how far it is, where it was given nobody else to tell."""
    token = _told.set(tell)
    try:
        yield
    finally:
        _told.reset(token)


def to_tell(progress: Callable[..., None] | None) -> Callable[..., None] | None:
    """Whom to tell how far the work is: who was given, or who is `told` what is done here."""
    return progress if progress is not None else _told.get()


def aside() -> AbstractContextManager[None]:
    """What passes inside is only tried: nobody looks."""
    return watching(None)


def untold(lower: Callable[[], _IR]) -> _IR:
    """What a kernel is lowered to once more: nobody looks, and its warnings were given before."""
    with warnings.catch_warnings(), aside():
        warnings.simplefilter("ignore", VividcWarning)
        return lower()


def is_watched() -> bool:
    """Whether someone looks."""
    return _current.get() is not None


def name_of(one: Callable[[_IR], _IR]) -> str:
    """A pass's name on the command line: the function's, with hyphens."""
    return getattr(one, "__name__", type(one).__name__).replace("_", "-")


def watched(name: str, make: Callable[[], _IR]) -> _IR:
    """What `make` makes, after it was looked at."""
    watch = _current.get()
    if watch is None:
        return make()
    began = time.perf_counter()
    made = make()
    watch.add(name, began)
    watch.look(name, made)
    return made


def timed(name: str, make: Callable[[], _IR]) -> _IR:
    """What `make` makes, of which only the seconds are of interest: what it tries is aside."""
    watch = _current.get()
    began = time.perf_counter()
    with aside():
        made = make()
    if watch is not None:
        watch.add(name, began)
    return made


def run_passes(passes: Iterable[Callable[[_IR], _IR]], given: _IR) -> _IR:
    """`given` after all passes, one after the other."""
    for one in passes:
        given = _after(one, given)
    return given


def _after(one: Callable[[_IR], _IR], given: _IR) -> _IR:
    return watched(name_of(one), lambda: one(given))


_SELDOM: Final = (50_000, 20, 20)
"""What a compiler makes stays until it is done, and Python's 700 objects are a millisecond of it:
each eighth second of a matrix product went into looks that found nothing."""
_lock = threading.Lock()
_inside = 0
_before = gc.get_threshold()


@contextmanager
def seldom() -> Iterator[None]:
    """Inside, garbage is looked for each 50,000 objects at most; after the last of several threads
    or calls, as before.
    """
    global _inside, _before  # noqa: PLW0603 - Python has one setting a process
    with _lock:
        if not _inside:
            _before = gc.get_threshold()
            if _before[0]:  # else nobody looks at all
                gc.set_threshold(*map(max, _before, _SELDOM))
        _inside += 1
    try:
        yield
    finally:
        with _lock:
            _inside -= 1
            if not _inside:
                gc.set_threshold(*_before)


_AGAIN_S: Final = 0.05


@dataclass(slots=True)
class _Heard:
    """`swallowed`: interrupts that a callback did; `due`: one of them has still to come again."""

    swallowed: list[BaseException] = field(default_factory=list)
    due: bool = False


_heard: _Heard | None = None


@contextmanager
def heard() -> Iterator[list[BaseException]]:
    """Inside, an interrupt that comes while a callback runs comes again, until it is raised where
    it ends the work, at the end of what is inside at the latest. Yields those that were swallowed.

    Python only reports an exception in a callback of the garbage collector (hypothesis has one), of
    a weak reference or of a C library. That is no rare moment: an interrupt during a collection is
    raised in what is called at its end.
    """
    global _heard
    if _heard is not None or threading.current_thread() is not threading.main_thread():
        yield [] if _heard is None else _heard.swallowed  # only the main thread is interrupted
        return
    here, before = _Heard(), sys.unraisablehook

    def hook(unraisable: sys.UnraisableHookArgs) -> None:
        if isinstance(unraisable.exc_value, KeyboardInterrupt):
            here.swallowed.append(unraisable.exc_value)
            here.due = True
            _thread.start_new_thread(_interrupt_again, (here,))  # takes no lock: it may be held
        else:
            before(unraisable)

    sys.unraisablehook, _heard = hook, here
    try:
        yield here.swallowed
        if here.due:
            raise KeyboardInterrupt
    finally:
        sys.unraisablehook, _heard = before, None


def _interrupt_again(here: _Heard) -> None:
    """Interrupt the main thread when the callback has ended, if that is not too late."""
    time.sleep(_AGAIN_S)
    if _heard is here:
        here.due = False
        _thread.interrupt_main()
