"""Random launch graphs of few bytes: those in which a pair of steps races are refused, and the
others leave in DRAM what their steps leave one after the other, and move as many bytes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from itertools import combinations
from typing import Any

import numpy as np
import pytest

from tests.launch.kernels import double, program
from vividc.errors import ArgumentError
from vividc.launch import At, Job, Listed

PAD = 192
"""Bytes of each scratchpad that steps use."""
TILES = 2

Use = tuple[object, frozenset[int], bool]
"""A memory, its bytes, and whether they are written."""


class Refused(Exception):
    """A step that the machine cannot carry out."""


class Part:
    """A view of one of the arrays, and of its bytes those that it has."""

    def __init__(self, name: str, index: Any, array: np.ndarray) -> None:
        self.name, self.index, self.view = name, index, array[index]
        numbers = np.arange(array.nbytes).reshape(*array.shape, array.itemsize)
        self.bytes = frozenset(numbers[index].ravel().tolist())

    def of(self, arrays: dict[str, Any]) -> np.ndarray:
        """The same view of other arrays."""
        view: np.ndarray = arrays[self.name][self.index]
        return view


class Place:
    """Where so many bytes lie in a scratchpad, and all between the first and the last of them."""

    def __init__(self, address: int, pitch: int, size: int) -> None:
        self.address, self.pitch = address, pitch
        self.bytes = address + np.arange(size) // 4 * pitch + np.arange(size) % 4
        last = int(self.bytes[-1]) + 1 if size else address
        self.span = frozenset(range(address, last))


class RandomJob:
    """A job, and beside it, step by step, what each uses and does, on copies of the arrays."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng, self.job = rng, Job("vivid")
        self.share = rng.choice([0.8, 1.0, 1.0])
        self.arrays: dict[str, Any] = {
            "table": rng.integers(0, 4, (12, 4), dtype=np.int32),
            "words": rng.integers(0, 6, (9, 6), dtype=np.int32),
            "rows": rng.integers(0, rng.choice([9, 13]), 10, dtype=np.int32),
            "bytes": rng.integers(0, 9, 80, dtype=np.uint8),
            "flags": rng.random(40) < 0.5,
            "first": rng.integers(0, 7, PAD // 4, dtype=np.int32),
        }
        self.copies = {name: array.copy() for name, array in self.arrays.items()}
        self.pads = np.zeros((TILES, PAD), np.uint8)
        self.uses: list[list[Use]] = []
        self.waits: list[set[int]] = []
        self.acts: list[Callable[[], None]] = []
        self.moved: Counter[str] = Counter(dram_wanted=0, scratchpad_in=0, scratchpad_out=0)
        self.counts: list[int] = []
        self.scattered: list[int] = []
        self.chosen: dict[int, frozenset[int]] = {}
        self.last_run: dict[int, int] = {}
        for tile in range(TILES):
            self.job.configure(tile, program(double))
            self.note(tile, [], set(), lambda: None)
        kinds = [
            self.move_in_some,
            self.move_out,
            self.move_out,
            self.by_list,
            self.by_list,
            self.run,
        ]
        self.fill()
        for _ in range(int(rng.integers(2, 14))):
            rng.choice(kinds)()

    def note(self, number: int, uses: list[Use], after: set[int], act: Callable[[], None]) -> None:
        assert number == len(self.uses) == len(self.waits)
        self.uses.append(uses)
        self.waits.append(after)
        self.acts.append(act)

    def after(self) -> list[int]:
        """Mostly the step before."""
        count = len(self.uses)
        chosen = {count - 1} if self.rng.random() < self.share else set()
        return sorted(chosen | {int(n) for n in self.rng.integers(0, count, self.rng.integers(2))})

    def part(self) -> Part:
        """Of an array."""
        rng = self.rng
        name = str(rng.choice(list(self.arrays)))
        first, length, step = (int(rng.integers(*ends)) for ends in ((6,), (1, 8), (1, 3)))
        index: Any = slice(first, first + length * step, step)
        if self.arrays[name].ndim == 2 and rng.random() < 0.5:
            index = index, slice(int(rng.integers(0, 2)), int(rng.integers(2, 5)))
        return Part(name, index, self.arrays[name])

    def place(self, part: Part) -> Place:
        """In a scratchpad."""
        size, pitch = part.view.nbytes, 4
        if part.view.itemsize == 4 and 3 * size <= PAD and self.rng.random() < 0.3:
            pitch = int(self.rng.choice([8, 12]))
        address = int(self.rng.integers(0, PAD - size * pitch // 4 + 1))
        if pitch > 4 or self.rng.random() < 0.7:
            address = address // 4 * 4
        return Place(address, pitch, size)

    def fill(self) -> None:
        """Both scratchpads, with small numbers."""
        part = Part("first", slice(None), self.arrays["first"])
        self.move_in(part, Place(0, 4, PAD), [0, 1])

    def move_in_some(self) -> None:
        part = self.part()
        self.move_in(part, self.place(part), [[0], [1], [0, 1]][int(self.rng.integers(3))])

    def move_in(self, part: Part, place: Place, tiles: list[int]) -> None:
        after = self.after()
        number = self.job.move_in(tiles, part.view, place.address, after=after, pitch=place.pitch)

        def act() -> None:
            raw = np.ascontiguousarray(part.of(self.copies)).view(np.uint8).ravel()
            for tile in tiles:
                self.pads[tile][place.bytes] = raw
            self.moved.update(dram_wanted=raw.size, scratchpad_in=len(tiles) * raw.size)

        uses: list[Use] = [(tile, place.span, True) for tile in tiles]
        self.note(number, [(part.name, part.bytes, False), *uses], set(after), act)

    def move_out(self) -> None:
        part, tile, after = self.part(), int(self.rng.integers(TILES)), self.after()
        place = self.place(part)
        count_at = 4 * int(self.rng.integers(PAD // 4)) if self.rng.random() < 0.6 else None
        number = self.job.move_out(
            *(tile, place.address, part.view),
            after=after,
            pitch=place.pitch,
            count_at=count_at,
        )

        def act() -> None:
            own = part.of(self.copies)
            if count_at is not None:
                count = self.word(tile, count_at)
                if count > len(own):
                    raise Refused
                self.counts.append(count)
                own = own[:count]
                self.moved["scratchpad_out"] += 4
            raw = self.pads[tile][place.bytes[: own.nbytes]]
            if own.dtype == np.bool_:
                raw = (raw != 0).view(np.uint8)
            own[...] = raw.view(own.dtype).reshape(own.shape)
            self.moved.update(dram_wanted=raw.size, scratchpad_out=raw.size)

        uses: list[Use] = [(part.name, part.bytes, True), (tile, place.span, False)]
        if count_at is not None:
            uses.append((tile, frozenset(range(count_at, count_at + 4)), False))
        self.note(number, uses, set(after), act)

    def by_list(self) -> None:
        """A gather or scatter, by a list in DRAM or anywhere in a scratchpad."""
        rng, after, number = self.rng, self.after(), len(self.uses)
        scatters, tile = bool(rng.random() < 0.6), int(rng.integers(TILES))
        name = str(rng.choice(["table", "table", "table", *self.arrays]))
        table = Part(name, slice(int(rng.choice([0, 0, 1])), None), self.arrays[name])
        row, most = table.view[:1].nbytes, int(rng.integers(0, 5))
        address = int(rng.integers(PAD - row * most + 1))
        listed: Part | Listed = Listed(4 * int(rng.integers(PAD // 4 - 5)), most)
        indices: Any = listed
        said: Use = (tile, frozenset(range(listed.address, listed.address + 4 + 4 * most)), False)
        if rng.random() < 0.6:
            first = int(rng.integers(7))
            listed = Part("rows", slice(first, first + most), self.arrays["rows"])
            indices, said = listed.view, (listed.name, listed.bytes, False)
            starts = [min(table.bytes) + row * n for n in indices.tolist()]
            chosen = {byte for start in starts for byte in range(start, start + row)}
            self.chosen[number] = table.bytes & chosen
        if scatters:
            added = self.job.scatter(tile, address, table.view, indices, after=after)
        else:
            added = self.job.gather(tile, table.view, indices, address, after=after)

        def act() -> None:
            rows, own = self.rows(tile, listed), table.of(self.copies)
            if any(not 0 <= n < len(own) for n in rows):
                raise Refused
            put = self.pads[tile][address : address + row * len(rows)].reshape(len(rows), row)
            for n, raw in zip(rows, put, strict=True):
                if scatters:
                    bits = (raw != 0).view(np.uint8) if own.dtype == np.bool_ else raw
                    own[n : n + 1] = bits.view(own.dtype).reshape(1, *own.shape[1:])
                else:
                    raw[:] = own[n : n + 1].view(np.uint8).ravel()
            way = "scratchpad_out" if scatters else "scratchpad_in"
            self.moved.update({"dram_wanted": put.size, way: put.size})
            self.scattered += [len(rows)] * scatters

        span = frozenset(range(address, address + row * most))
        uses: list[Use] = [(name, table.bytes, scatters), (tile, span, not scatters), said]
        self.note(added, uses, set(after), act)

    def rows(self, tile: int, listed: Part | Listed) -> list[int]:
        """What a list says, and that it was read."""
        if isinstance(listed, Part):
            numbers: list[int] = listed.of(self.copies).tolist()
            self.moved["dram_wanted"] += 4 * len(numbers)
            return numbers
        count = min(self.word(tile, listed.address), listed.most)
        self.moved["scratchpad_out"] += 4 * (1 + count)
        return [self.word(tile, listed.address + 4 + 4 * n) for n in range(count)]

    def run(self) -> None:
        tile, words, after = (
            int(self.rng.integers(TILES)),
            int(self.rng.integers(1, 9)),
            self.after(),
        )
        at = 4 * int(self.rng.integers(PAD // 4 - words))
        number = self.job.run(tile, program(double), x=At(at, (words,)), n=words, after=after)

        def act() -> None:
            self.pads[tile][at : at + 4 * words].view(np.uint32)[:] *= 2

        waits = {*after, tile, *([self.last_run[tile]] if tile in self.last_run else [])}
        self.last_run[tile] = number
        self.note(number, [(tile, frozenset(range(at, at + 4 * words)), True)], waits, act)

    def word(self, tile: int, at: int) -> int:
        return int(self.pads[tile][at : at + 4].view(np.uint32)[0])

    def races(self) -> bool:
        """Whether two steps use the same bytes, one of them writing, without an order."""
        uses = [list(some) for some in self.uses]
        written = {place for some in uses for place, _, writes in some if writes}
        for number, chosen in self.chosen.items() if "rows" not in written else ():
            name, _, writes = uses[number][0]
            uses[number][0] = (name, chosen, writes)
        before: list[set[int]] = []
        for direct in self.waits:
            before.append(direct.union(*(before[n] for n in direct)))
        return any(
            early not in before[late]
            for early, late in combinations(range(len(uses)), 2)
            for place, some, writes in uses[early]
            for other, others, also in uses[late]
            if place == other and (writes or also) and some & others
        )


def outcome(rng: np.random.Generator) -> tuple[str, RandomJob]:
    """How a job ended."""
    one = RandomJob(rng)
    untouched = {name: array.copy() for name, array in one.arrays.items()}
    if one.races():
        with pytest.raises(ArgumentError, match="their order is not given"):
            one.job.simulate()
        return "race", one
    try:
        for act in one.acts:
            act()
    except Refused:
        with pytest.raises(ArgumentError, match=r"is told to move|is told row"):
            one.job.simulate()
        for name, array in one.arrays.items():
            np.testing.assert_array_equal(array, untouched[name])
        return "refused", one
    moved = one.job.simulate().stats["bytes"]
    assert {name: moved[name] for name in one.moved} == one.moved
    for name, array in one.arrays.items():
        np.testing.assert_array_equal(array, one.copies[name])
    return "done", one


def test_jobs_do_what_their_steps_do_one_after_the_other() -> None:
    rng = np.random.default_rng(12)
    ends, counts, scattered = Counter[str](), Counter[int](), Counter[int]()
    for _ in range(120):
        end, one = outcome(rng)
        ends[end] += 1
        if end == "done":
            counts.update(one.counts)
            scattered.update(one.scattered)
    assert min(ends["race"], ends["refused"], ends["done"]) > 10, ends
    assert sum(counts[count] for count in counts if count) > 10, counts
    assert sum(scattered[rows] for rows in scattered if rows) > 10, scattered


@pytest.mark.slow
def test_many_jobs_do_what_their_steps_do_one_after_the_other() -> None:
    rng = np.random.default_rng(13)
    for _ in range(3000):
        outcome(rng)
