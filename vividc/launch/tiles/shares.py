"""How chunks share the iterations of loops beside the parallel one: each takes those that touch
what it touches, so that what fills an array of zeros fills the slice of each chunk.

Any way to share them is right as long as no chunk touches what another one writes, which is proved
of the chunks that come of it.
"""

from __future__ import annotations

from collections.abc import Mapping as ReadOnly
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

from vividc.machine.parallel import Access, Parallel
from vividc.sim.footprint.coverage import written_whole
from vividc.sim.footprint.footprint import (
    Interval,
    Touch,
    beside_words,
    bounds_beside,
    bytes_of,
    chunk_intervals,
    touched,
)

Touches = ReadOnly[str, Touch]
Words = dict[str, int]


@dataclass(frozen=True, slots=True)
class Part:
    """Iterations `first` to before `last` of the parallel loop: number `place` of `count` parts."""

    first: int
    last: int
    place: int
    count: int


@dataclass(frozen=True)
class Sharing:
    """The loops beside a parallel one on a launch with these words, and arrays of `sizes` bytes."""

    parallel: Parallel
    inputs: ReadOnly[str, int]
    sizes: ReadOnly[str, int]
    _bounds: list[Interval] = field(init=False)
    _parts: dict[tuple[int, str, int], Interval | None] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_bounds", bounds_beside(self.parallel, self.inputs))

    def words(self, parts: Sequence[Part], *, whole: bool) -> list[Words]:
        """The launch words of each part for all loops beside.

        Parameters
        ----------
        whole
            The parts are all there are, and take all iterations; else each takes only what touches
            what it touches.
        """
        words: list[Words] = [{} for _ in parts]
        touches = [self._touches(part, None, {}) for part in parts]
        for number in self._order():
            ends = self._ends(number, parts, touches, whole)
            for place, (part, end) in enumerate(zip(parts, ends, strict=True)):
                own = beside_words(number, *end)
                if whole and self._is_overwritten(number, part, own, touches[place]):
                    own = beside_words(number, end[0], end[0])
                words[place] |= own
                touches[place] = _joined(touches[place], self._touches(part, number, own))
        return words

    def _order(self) -> list[int]:
        """The loops, those first of which an iteration touches most, such as a row."""

        def size(number: int) -> int:
            names = {one.array for one in self._of(number)}
            parts = (self._part(number, name, self._bounds[number][0]) for name in names)
            return max((part[1] - part[0] for part in parts if part is not None), default=0)

        return sorted(range(len(self.parallel.beside)), key=lambda number: -size(number))

    def _touches(self, part: Part, beside: int | None, words: Words) -> Touches:
        """What a part touches in the parallel loop and elsewhere, or in a loop beside it."""
        chosen = replace(self.parallel, accesses=self._of(beside))
        inputs = {**self.inputs, **words}
        return touched(chosen, inputs, self.sizes, part.first, part.last)

    def _of(self, beside: int | None) -> tuple[Access, ...]:
        return tuple(one for one in self.parallel.accesses if one.beside == beside)

    def _ends(
        self, number: int, parts: Sequence[Part], touches: Sequence[Touches], whole: bool
    ) -> list[Interval]:
        """First iteration and end of each part's share of a loop."""
        array = self._anchor(number, touches)
        first, last = self._bounds[number]
        if array is None:
            cuts = [first + (last - first) * n // parts[0].count for n in range(parts[0].count + 1)]
            return [(cuts[part.place], cuts[part.place + 1]) for part in parts]
        hulls = [(hull, n) for n, one in enumerate(touches) if (hull := one[array].hull)]
        ordered = sorted(hulls)
        row = _row(ordered, parts)
        bytes_ = [hull[0] for hull, _ in ordered]
        for place, ((before, _), (hull, _)) in enumerate(pairwise(ordered), 1):
            bytes_[place] = max(hull[0] // row * row, before[1])
        begins = [self._iteration_at(number, array, byte, 1) for byte in bytes_]
        if whole:
            begins[0] = first
            until = [*begins[1:], last]
        else:
            until = [self._iteration_at(number, array, hull[1], 0) for hull, _ in ordered]
        shares = [(first, first)] * len(parts)
        for (_, place), begin, end in zip(ordered, begins, until, strict=True):
            shares[place] = (begin, max(begin, end))
        return shares

    def _anchor(self, number: int, touches: Sequence[Touches]) -> str | None:
        """An array that the loop touches, rather one that it stores to, of which parts have slices
        of their own; None: there is none.
        """
        accesses = sorted(self._of(number), key=lambda one: not one.is_store)
        for name in dict.fromkeys(one.array for one in accesses):
            hulls = sorted(hull for one in touches if (hull := one[name].hull))
            apart = all(a[1] <= b[0] for a, b in pairwise(hulls))
            if hulls and apart:
                return name
        return None

    def _iteration_at(self, number: int, array: str, byte: int, end: int) -> int:
        """The first iteration that begins at a byte of the array or behind it, or if `end` that
        ends behind it: guessed from the first two, then found by bisection.
        """
        low, high = self._bounds[number]
        one, two = self._part(number, array, low), self._part(number, array, low + 1)
        step = 0 if one is None or two is None else two[0] - one[0]
        guess = low
        if one is not None and step > 0:
            guess += (byte - one[0]) // step if end else -(-(byte - one[0]) // step)
        while low < high:
            middle = guess if low < guess < high else (low + high) // 2
            part = self._part(number, array, middle)
            if part is not None and part[end] >= byte + end:
                high, guess = middle, middle - 1
            else:
                low, guess = middle + 1, middle + 1
        return low

    def _part(self, number: int, array: str, iteration: int) -> Interval | None:
        """The bytes of an array that an iteration may touch."""
        key = (number, array, iteration)
        if key not in self._parts:
            words = {**self.inputs, **beside_words(number, iteration, iteration + 1)}
            known = chunk_intervals(self.parallel, words, 0, 1)
            parts = [
                bytes_of(one, known[one.term], self.sizes[array])
                for one in self._of(number)
                if one.array == array
            ]
            found = [part for part in parts if part is not None]
            whole = (min(a for a, _ in found), max(b for _, b in found)) if found else None
            self._parts[key] = whole
        return self._parts[key]

    def _is_overwritten(self, number: int, part: Part, words: Words, others: Touches) -> bool:
        """Whether all that a share of a loop before the parallel one stores is written again by the
        part, and read nowhere.
        """
        if not self.parallel.beside[number].is_before:
            return False
        alone = replace(self.parallel, accesses=self._of(None))
        again = written_whole(alone, {**self.inputs, **words}, part.first, part.last)
        stored = {name: t.stores for name, t in self._touches(part, number, words).items()}
        read = {one.array for one in self.parallel.accesses if not one.is_store}
        return all(
            stores is None
            or (name not in read and name in again and _is_inside(stores, again[name]))
            for name, stores in stored.items()
        )


def _row(ordered: Sequence[tuple[Interval, int]], parts: Sequence[Part]) -> int:
    """Bytes from what an iteration of the parallel loop touches to what the next one does; 1 if
    they are not the same everywhere. A loop over whole rows is cut where a row begins, though the
    parallel one may leave its first columns out.
    """
    steps = set[tuple[int, int]]()
    for (one, this), (other, next_) in pairwise(ordered):
        count = abs(parts[next_].first - parts[this].first)
        steps.add(divmod(other[0] - one[0], count) if count else (1, 0))
    [*rows] = {row for row, rest in steps if not rest}
    return max(rows[0], 1) if len(rows) == len(steps) == 1 else 1


def _is_inside(one: Interval, other: Interval) -> bool:
    return other[0] <= one[0] and one[1] <= other[1]


def _joined(one: Touches, other: Touches) -> dict[str, Touch]:
    """Both together, as far as where they lie goes."""
    return {
        name: Touch(_hull(one[name].loads, more.loads), _hull(one[name].stores, more.stores))
        for name, more in other.items()
    }


def _hull(one: Interval | None, other: Interval | None) -> Interval | None:
    return Touch(one, other).hull
