"""Arguments of other kinds: the same values as Python's numbers, in read-only, unaligned or shared
memory, which change nothing; and those that no launch may take without a word.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass
from random import Random

import numpy as np

from tests.fuzz.arguments import Difference, compare
from vividc.errors import ArgumentError

Args = list[object]
Launch = Callable[[Args], object]
"""Runs a program and gives its value; arrays are updated in place."""


class _Subclass(np.ndarray):
    """An array of the user's own class."""


@dataclass(frozen=True, slots=True)
class Kinds:
    """A program's arguments in other clothes.

    Attributes
    ----------
    launch, reference
        Runs the program; computes what it must leave.
    stored
        Positions of the arrays that it writes.
    """

    launch: Launch
    reference: Launch
    stored: frozenset[int]

    def check(self, args: Args, random: Random) -> tuple[str, ...]:
        """Demand the reference's results of some kinds, and a refusal of others; their names."""
        accepted = random.sample(ACCEPTED, 3)
        for what, dress in accepted:
            self._same(what, dress(deepcopy(args), self.stored, random), args)
        refused = random.sample(REFUSED, 2)
        for what, undress in refused:
            self._refuses(what, undress, deepcopy(args))
        shared = share(deepcopy(args), self.stored)
        if shared is not None:
            self._same("arrays that overlap", shared, shared)
        self._refuses_overlap(deepcopy(args))
        names = [what for what, _ in accepted] + [what for what, _ in refused]
        names += ["overlapping arrays that are read"] if shared is not None else []
        return tuple(f"arguments: {what}" for what in names)

    def _same(self, what: str, given: Args, args: Args) -> None:
        plain = [np.array(a) if isinstance(a, np.ndarray) else a for a in deepcopy(args)]
        value = self.reference(plain)
        found = self.launch(given)
        compare(f"arguments, {what}", [found, *given], [value, *plain])

    def _refuses(self, what: str, undress: Callable[[np.ndarray], object], args: Args) -> None:
        for number, value in enumerate(args):
            if isinstance(value, np.ndarray):
                odd = undress(value)
                if odd is None:
                    continue
                given = [*args[:number], odd, *args[number + 1 :]]
                try:
                    self.launch(given)
                except ArgumentError:
                    continue
                raise Difference(f"arguments, {what}: taken for value {number + 1}")

    def _refuses_overlap(self, args: Args) -> None:
        """A write to one array would not show in the other's copy."""
        for one, a in enumerate(args):
            for other, b in enumerate(args):
                if one == other or other not in self.stored or not _alike(a, b):
                    continue
                try:
                    self.launch([*args[:one], b, *args[one + 1 :]])
                except ArgumentError:
                    continue
                raise Difference(f"arguments: values {one + 1} and {other + 1} are one array")


def _alike(a: object, b: object) -> bool:
    if not isinstance(a, np.ndarray) or not isinstance(b, np.ndarray):
        return False
    return a.dtype == b.dtype and a.ndim == b.ndim and b.size > 0


def share(args: Args, stored: frozenset[int]) -> Args | None:
    """Two arrays that are only read and differ by an element of one buffer; None without such."""
    read = [
        number
        for number, value in enumerate(args)
        if isinstance(value, np.ndarray) and value.size and number not in stored
    ]
    for one in read:
        for other in read:
            a, b = args[one], args[other]
            assert isinstance(a, np.ndarray)
            assert isinstance(b, np.ndarray)
            if one < other and a.dtype == b.dtype:
                buffer = np.concatenate([a.reshape(-1), b.reshape(-1)])
                args[one] = buffer[: a.size].reshape(a.shape)
                start = min(1, buffer.size - b.size)
                args[other] = buffer[start : start + b.size].reshape(b.shape)
                return args
    return None


def _arrays(args: Args, dress: Callable[[np.ndarray], np.ndarray]) -> Args:
    return [dress(a) if isinstance(a, np.ndarray) else a for a in args]


def _python_numbers(args: Args, stored: frozenset[int], random: Random) -> Args:
    return [a.item() if isinstance(a, np.generic) else a for a in args]


def _wider_numbers(args: Args, stored: frozenset[int], random: Random) -> Args:
    wider = {"i": np.int64, "u": np.uint64, "f": np.float64, "c": np.complex128, "b": np.bool_}
    return [wider[a.dtype.kind](a) if isinstance(a, np.generic) else a for a in args]


def _read_only(args: Args, stored: frozenset[int], random: Random) -> Args:
    for number, value in enumerate(args):
        if isinstance(value, np.ndarray) and number not in stored:
            value.setflags(write=False)
    return args


def _of_subclass(args: Args, stored: frozenset[int], random: Random) -> Args:
    return _arrays(args, lambda a: a.view(_Subclass))


def _unaligned(args: Args, stored: frozenset[int], random: Random) -> Args:
    def moved(a: np.ndarray) -> np.ndarray:
        raw = np.empty(a.nbytes + 1, np.uint8)[1:]
        raw[:] = a.reshape(-1).view(np.uint8)
        return raw.view(a.dtype).reshape(a.shape)

    return _arrays(args, moved)


def _part_of_larger(args: Args, stored: frozenset[int], random: Random) -> Args:
    def cut(a: np.ndarray) -> np.ndarray:
        larger = np.zeros((a.shape[0] + 2, *a.shape[1:]), a.dtype)
        larger[1:-1] = a
        return larger[1:-1]

    return _arrays(args, cut)


Dress = Callable[[Args, frozenset[int], Random], Args]
ACCEPTED: tuple[tuple[str, Dress], ...] = (
    ("Python numbers", _python_numbers),
    ("wider numpy numbers", _wider_numbers),
    ("read-only arrays", _read_only),
    ("arrays of a subclass", _of_subclass),
    ("unaligned arrays", _unaligned),
    ("parts of larger arrays", _part_of_larger),
)


def _unless_contiguous(a: np.ndarray) -> np.ndarray | None:
    return None if a.flags.c_contiguous else a


def _other_order(a: np.ndarray) -> np.ndarray | None:
    return _unless_contiguous(np.asfortranarray(a))


def _backwards(a: np.ndarray) -> np.ndarray | None:
    return _unless_contiguous(a[::-1].copy()[::-1])


def _every_other(a: np.ndarray) -> np.ndarray | None:
    return _unless_contiguous(np.repeat(a, 2, axis=-1)[..., ::2])


def _other_bytes(a: np.ndarray) -> np.ndarray | None:
    return a.astype(a.dtype.newbyteorder()) if a.dtype.itemsize > 1 else None


def _other_type(a: np.ndarray) -> np.ndarray:
    return a.astype(np.complex128 if a.dtype.kind == "c" else np.float64)


def _more_axes(a: np.ndarray) -> np.ndarray:
    return a[None]


REFUSED: tuple[tuple[str, Callable[[np.ndarray], np.ndarray | None]], ...] = (
    ("Fortran order", _other_order),
    ("negative strides", _backwards),
    ("every other element", _every_other),
    ("bytes in the other order", _other_bytes),
    ("another type", _other_type),
    ("an axis more", _more_axes),
)
