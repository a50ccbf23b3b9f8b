"""A cache of what is derived from programs, since deriving it takes longer than a run."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from threading import Lock
from typing import Generic, TypeVar

from vividc.program import Program

Made = TypeVar("Made")


class Kept(Generic[Made]):
    """Values by program and key, the ones used last. Programs are told apart by identity, which
    needs no hash of their words; they are frozen, and held as long as their values are.

    Parameters
    ----------
    most
        Values that are kept.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._values: OrderedDict[tuple[int, Hashable], tuple[Program, Made]] = OrderedDict()
        self._lock = Lock()

    def get(self, program: Program, key: Hashable, make: Callable[[], Made]) -> Made:
        """Return the value of `program` and `key`; `make` makes it if it is not there."""
        where = (id(program), key)
        with self._lock:
            if where in self._values:
                self._values.move_to_end(where)
                return self._values[where][1]
        made = make()
        with self._lock:
            self._values[where] = (program, made)
            while len(self._values) > self._most:
                self._values.popitem(last=False)
        return made
