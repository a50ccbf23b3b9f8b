"""How long a tile stands still as accesses of one cycle meet in a bank: what is expected.

Where accesses lie is known as far as their addresses are (`Node.address`), relative to each other
by the words that they have in common. A word of which nothing is known is drawn many times, the
same ones in every run.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from random import Random
from typing import Final

import numpy as np
from numpy.typing import NDArray

from vividc.arch.fabric import Scratchpad
from vividc.dfg.ir import CHANGES, DFG, FROM_END, Node
from vividc.machine.words import WORD_BYTES
from vividc.mapper.resources.arms import Arm, arms_of
from vividc.ssa.analysis.polynomial import ITERATION
from vividc.ssa.ir import Input, is_dimension, is_pitch, pitch_of

_DRAWN: Final = 512
"""Times that each unknown word is drawn: a mean of 1 stall an iteration is within 0.05."""

_CHOICES: Final = 8
"""So many ways are drawn to map what is not mapped yet, and to place its arrays: the best counts,
as a compiler chooses.
"""

_TURNS: Final = 2
"""Times that each access is given the slot where it meets fewest others."""

_ROOM: Final = 1
"""Slots have room for so many accesses more than if all had equally many: mappers have other things
to think of, too.
"""

_CROWDED: Final = 1e-3
"""What an access that is in a slot already counts there, as a meeting: slots are filled evenly."""

_ALIGNED: Final = 2
"""One of so many dimensions is a multiple of the banks: powers of two are common."""

_STAGES: Final = 8
"""Accesses of what is not mapped yet are up to so many iterations apart."""

_IDLE: Final = 4
"""One of so many times, all accesses that have a predicate are idle: groups at an edge of a tiled
loop, and arms of branches.
"""

_SURE: Final = 0.5
"""Accesses that meet as often are known to, unless one of them is idle."""

_GAIN: Final = 0.2
"""Share of the stalls that a start has to save to be taken instead of one before it."""

_NOISE: Final = 0.05
"""The same of a pitch."""

_BUSY: Final = 0.002
"""Share of all accesses that a region makes at least to count when the layout is improved."""

_FEW: Final = 0.01
"""Share of the cycles up to which stalls are no reason to look for another layout."""

_ROUNDS: Final = 3
"""Times that all pitches and starts are chosen anew."""

_Draws = NDArray[np.int64]
Words = Mapping[str, int]
"""Words of addresses by name, as far as they are known."""
NOTHING: Final[Words] = {}


@dataclass(frozen=True, eq=False)
class Meetings:
    """What accesses of a loop expect of each other.

    Attributes
    ----------
    accesses
        Their ids.
    stalls
        (accesses, accesses, 1 + 2 far): how often a pair that starts in one slot meets in a bank,
        from the first being `far` stages earlier to `far` stages later.
    """

    accesses: tuple[int, ...] = ()
    stalls: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 0, 1)))

    def weighted(self, weight: float) -> Meetings:
        """Return the same, each so many times as dear."""
        return Meetings(self.accesses, weight * self.stalls)


NO_MEETINGS: Final = Meetings()

Meets = Mapping[int, Mapping[int, float]]
"""How often accesses of one cycle of straight code meet in a bank, by the ids of both."""
NO_MEETS: Final[Meets] = {}


@dataclass(frozen=True)
class Traffic:
    """The accesses of a region.

    Attributes
    ----------
    arms
        Of each access that has a predicate, by id, as by `arms_of`.
    ii
        Cycles between iterations; of straight code, its length.
    times
        When each access starts, by id; None: any time.
    weight
        How often an iteration runs, compared with those of other regions.
    spread
        Whether accesses that start at any time do so where they meet fewest others, not as drawn.
    """

    accesses: tuple[Node, ...]
    arms: Mapping[int, tuple[Arm, ...]]
    banks: int
    ii: int
    times: Mapping[int, int] | None = None
    weight: float = 1.0
    spread: bool = False
    _known: dict[object, _Draws] = field(init=False, compare=False, default_factory=dict)
    _stalls: dict[object, float] = field(init=False, compare=False, default_factory=dict)

    @staticmethod
    def of(
        dfg: DFG,
        scratchpad: Scratchpad,
        ii: int,
        times: Mapping[int, int] | None = None,
        weight: float = 1.0,
    ) -> Traffic:
        """That of a graph."""
        accesses = tuple(node for node in dfg.nodes if node.is_memory)
        return Traffic(accesses, arms_of(dfg, accesses), scratchpad.banks, ii, times, weight)

    def stalls(self, known: Words = NOTHING, among: Collection[str] | None = None) -> float:
        """Cycles of an iteration in which the tile stands still, the mean of what is drawn; of the
        accesses to the arrays `among` only. Without times: the fewest of several choices.
        """
        names = tuple(name for name in self._words if among is None or name in among)
        key = names, tuple(known.get(word) for name in names for word in self._words[name])
        if key not in self._stalls:
            accesses = [node for node in self.accesses if node.name in names]
            self._stalls[key] = self._stalls_of(accesses, known)
        return self._stalls[key]

    @cached_property
    def _words(self) -> dict[str, tuple[str, ...]]:
        """The words in the addresses of the accesses to each array."""
        words: dict[str, dict[str, None]] = {node.name: {} for node in self.accesses}
        for node in self.accesses:
            words[node.name] |= dict.fromkeys(_words_in(node))
        return {name: tuple(found) for name, found in words.items()}

    def _stalls_of(self, accesses: Sequence[Node], known: Words) -> float:
        if len(accesses) < 2:  # noqa: PLR2004 - it takes two to meet
            return 0.0
        if self.times is not None:
            return self._stalls_of_slots(accesses, self.times, known)
        if self.spread:
            places = self._spread_places(accesses, known)
        else:
            places = np.stack([self._places(node, known) for node in accesses])
        waits = _waits(places, self.ii * self.banks, self.banks)
        return float(waits.reshape(_CHOICES, -1).mean(axis=1).min())

    def _spread_places(self, accesses: Sequence[Node], known: Words) -> _Draws:
        """Slots and banks of accesses in drawn stages, each of which starts where it meets fewest
        others.
        """
        banks = np.stack([self._spread_bank(node, known) for node in accesses])
        slots = np.repeat(self._spread_slots(banks), _DRAWN // _CHOICES, axis=1)
        return np.where(banks == self.banks, self.ii * self.banks, slots * self.banks + banks)

    def _spread_bank(self, node: Node, known: Words) -> _Draws:
        """What is idle lies in a bank of its own."""
        key = ("spread", node.id, tuple(map(known.get, _words_in(node))))
        if key not in self._known:
            self._known[key] = self._found_spread(node, known)
        return self._known[key]

    def _found_spread(self, node: Node, known: Words) -> _Draws:
        stage = _chosen(f"stage {node.id}", _STAGES)
        bank = _bank(node, stage, self.banks, known, is_mapped=False)
        return np.where(self._idle(node), self.banks, bank)

    def _spread_slots(self, banks: _Draws) -> _Draws:
        """The slot of each access (by row) for each choice, one after the other, as mappers place
        them.
        """
        number = len(banks)
        drawn = banks.reshape(number, _CHOICES, -1).swapaxes(0, 1)
        busy = drawn != self.banks
        meets = ((drawn == drawn[:, [one]]) & busy for one in range(number))
        often = np.stack([row.mean(axis=2) for row in meets], axis=1) + _CROWDED
        every, room = np.arange(_CHOICES), _ROOM + -(-number // self.ii)
        slots = np.full((number, _CHOICES), -1)
        costs = np.zeros((_CHOICES, self.ii, number))
        filled = np.zeros((_CHOICES, self.ii), np.int64)
        for turn in range(_TURNS):
            for one in range(number):
                if turn:
                    costs[every, slots[one]] -= often[:, one]
                    filled[every, slots[one]] -= 1
                cost = costs[:, :, one] + (filled >= room) * number
                slots[one] = chosen = cost.argmin(axis=1)
                costs[every, chosen] += often[:, one]
                filled[every, chosen] += 1
        return slots

    def _stalls_of_slots(
        self, accesses: Sequence[Node], times: Mapping[int, int], known: Words
    ) -> float:
        """Accesses of different slots do not meet: each slot counts by itself, and anew only where
        another word is known of its addresses.
        """
        slots: dict[int, list[Node]] = {}
        for node in accesses:
            slots.setdefault(times[node.id] % self.ii, []).append(node)
        total = 0.0
        for slot, nodes in slots.items():
            if len(nodes) < 2:  # noqa: PLR2004 - as above
                continue
            key = tuple((n.id, tuple(map(known.get, _words_in(n)))) for n in nodes)
            if key not in self._stalls:
                places = np.stack([self._places(node, known) for node in nodes])
                banks = np.minimum(places - slot * self.banks, self.banks)
                self._stalls[key] = float(_waits(banks, self.banks, self.banks).mean())
            total += self._stalls[key]
        return total

    def meetings(self, known: Words = NOTHING) -> Meetings:
        """Of each two accesses, whenever they start; those that wait for the rest of an iteration
        are up to as many stages apart as there are now, and one.
        """
        if self.times is None or not self.accesses:
            return NO_MEETINGS
        stages = 2 + max(self.times.values()) // self.ii
        banks = np.zeros((len(self.accesses), stages, _DRAWN), np.int64)
        for number, node in enumerate(self.accesses):
            idle = self._idle(node)
            for stage in range(stages):
                later = np.full(_DRAWN, stage)
                bank = _bank(node, later, self.banks, known, is_mapped=True)
                banks[number, stage] = np.where(idle, -1 - number, bank)  # none of the others'
        later = (banks[:, None, :, :] == banks[None, :, :1, :]).mean(axis=3)
        earlier = later.transpose(1, 0, 2)[:, :, :0:-1]
        return Meetings(
            tuple(node.id for node in self.accesses), np.concatenate([earlier, later], axis=2)
        )

    def meets(self, known: Words = NOTHING) -> Meets:
        """Of straight code, by the ids of accesses that meet others at all."""
        found: dict[int, Mapping[int, float]] = {}
        for node, row in zip(self.accesses, self._side_by_side(known), strict=True):
            others = {self.accesses[n].id: float(row[n]) for n in np.flatnonzero(row)}
            if others:
                found[node.id] = others
        return found

    def unsure(self, known: Words = NOTHING) -> float:
        """Cycles of a run of straight code in which accesses are expected to wait for each other,
        in any of its cycles, as nobody knows which of them meet: what does is scheduled apart.
        """
        often = self._side_by_side(known)
        return float(often[often < _SURE].sum()) / (2 * self.ii)

    def _side_by_side(self, known: Words) -> NDArray[np.float64]:
        """How often each two accesses of one cycle meet, outside of loops."""
        banks = np.zeros((len(self.accesses), _DRAWN), np.int64)
        for number, node in enumerate(self.accesses):
            bank = _bank(node, np.zeros(_DRAWN, np.int64), self.banks, known, is_mapped=True)
            banks[number] = np.where(self._idle(node), -1 - number, bank)  # none of the others'
        often = np.zeros((len(banks), len(banks)))
        for number, bank in enumerate(banks):
            often[number] = (banks == bank).mean(axis=1)
        np.fill_diagonal(often, 0.0)
        return often

    def touches(self, array: str) -> bool:
        """Whether one of the accesses is to an array."""
        return any(node.name == array for node in self.accesses)

    def _places(self, node: Node, known: Words) -> _Draws:
        """Slot and bank of an access, as one number."""
        words = _words_in(node)
        key = (node.id, tuple(known.get(word) for word in words))
        if key not in self._known:
            self._known[key] = self._found(node, known)
        return self._known[key]

    def _found(self, node: Node, known: Words) -> _Draws:
        if self.times is None:
            slot, stage = (_chosen(f"{n} {node.id}", n) for n in (self.ii, _STAGES))
        else:
            stage, fixed = (np.full(_DRAWN, n) for n in divmod(self.times[node.id], self.ii))
            slot = fixed
        bank = _bank(node, stage, self.banks, known, is_mapped=self.times is not None)
        return np.where(self._idle(node), self.ii * self.banks, slot * self.banks + bank)

    def _idle(self, node: Node) -> NDArray[np.bool_]:
        """In which draws an access is not made."""
        if node.id not in self.arms:
            return np.zeros(_DRAWN, np.bool_)
        idle = _drawn("predicate", _IDLE) == 0
        for arm in self.arms[node.id]:
            idle = idle | (_drawn(f"arms of {arm.choice}", arm.count) != arm.number)
        return np.asarray(idle)


def _waits(places: _Draws, buckets: int, banks: int) -> _Draws:
    """Cycles that a tile stands still in each draw, as accesses (by row) lie in these buckets,
    `banks` a slot; what lies behind them is idle.
    """
    apart = places + np.arange(_DRAWN) * (buckets + 1)
    counts = np.bincount(apart.ravel(), minlength=_DRAWN * (buckets + 1))
    counts = counts.reshape(_DRAWN, buckets + 1)[:, :-1].reshape(-1, banks)
    waits: _Draws = np.maximum(counts.max(axis=1) - 1, 0).reshape(_DRAWN, -1)
    return np.asarray(waits.sum(axis=1))


def best_pitches(traffic: Sequence[Traffic], matrices: Mapping[str, int]) -> dict[str, int]:
    """How far apart rows should lie, in elements modulo those that all banks hold, for few stalls:
    one matrix after the other, the others' as chosen, or any.

    `matrices`: how many elements of each are a word; rows are whole words apart.
    """
    banks = traffic[0].banks if traffic else 1
    known: dict[str, int] = {}
    for matrix, per_word in matrices.items():
        word = pitch_of(matrix, 1).key
        touched = [one for one in traffic if one.touches(matrix)]
        least = math.inf
        for pitch in (per_word * (n % banks) for n in range(1, banks + 1)):
            stalls = sum(one.weight * one.stalls({**known, word: pitch}) for one in touched)
            if stalls < (1.0 - _NOISE) * least:
                known[word], least = pitch, stalls
    return {matrix: known[pitch_of(matrix, 1).key] for matrix in matrices}


def best_starts(
    traffic: Sequence[Traffic], arrays: Sequence[str], pitches: Mapping[str, int] = NOTHING
) -> dict[str, int]:
    """The bank that each array should start in, for few stalls; `pitches` of matrices are known.

    One after the other, each where fewest are expected of the arrays so far; in equal cases, one
    bank behind the array before.
    """
    banks = traffic[0].banks if traffic else 1
    known = words_of({}, pitches)
    for number, array in enumerate(arrays):
        word, among = f"&{array}", arrays[: number + 1]
        touched = [one for one in traffic if one.touches(array)]
        least = math.inf
        for start in ((number + more) % banks for more in range(banks)):
            here = {**known, word: WORD_BYTES * start}
            stalls = sum(one.weight * one.stalls(here, among) for one in touched)
            if stalls < (1.0 - _GAIN) * least:
                known[word], least = WORD_BYTES * start, stalls
            if not touched:
                break
    return {array: known[f"&{array}"] // WORD_BYTES for array in arrays}


Layout = tuple[dict[str, int], dict[str, int]]
"""Pitches of matrices, in elements modulo those that all banks hold, and the banks in which arrays
start.
"""


def best_layout(
    traffic: Sequence[Traffic],
    matrices: Mapping[str, int],
    arrays: Sequence[str],
    tries: int = 1,
) -> Layout:
    """Pitches of the matrices as `best_pitches` and starts of the arrays as `best_starts`, each
    then chosen anew as all others are, with all accesses of all regions, until none is better.

    While that leaves stalls, the same begins so many times in all, from other ones that are drawn:
    of gemm 80 cycles are expected of the first and 24 of a later one.
    """
    pitches = best_pitches(traffic, matrices)
    best = _improved(traffic, matrices, (pitches, best_starts(traffic, arrays, pitches)))
    least, few = _stalls_with(traffic, best), _FEW * sum(one.weight * one.ii for one in traffic)
    banks = traffic[0].banks if traffic else 1
    for turn in range(1, tries):
        if least <= few:
            break
        draw = Random(turn)
        drawn = (
            {name: per_word * draw.randrange(banks) for name, per_word in matrices.items()},
            {name: draw.randrange(banks) for name in best[1]},
        )
        layout = _improved(traffic, matrices, drawn)
        stalls = _stalls_with(traffic, layout)
        if stalls < (1.0 - _NOISE) * least:
            best, least = layout, stalls
    return best


def _stalls_with(traffic: Sequence[Traffic], layout: Layout) -> float:
    pitches, starts = layout
    known = words_of(starts, pitches)
    return sum(one.weight * one.stalls(known) for one in traffic)


def _improved(traffic: Sequence[Traffic], matrices: Mapping[str, int], layout: Layout) -> Layout:
    pitches, starts = (dict(part) for part in layout)
    banks = traffic[0].banks if traffic else 1
    total = sum(one.weight * len(one.accesses) for one in traffic)
    busy = [one for one in traffic if one.weight * len(one.accesses) > _BUSY * total]
    for _ in range(_ROUNDS):
        before = dict(pitches), dict(starts)
        for name, chosen in [(name, group) for group in (pitches, starts) for name in group]:
            touched = [one for one in busy if one.touches(name)]
            kept, least = chosen[name], math.inf
            step = matrices[name] if chosen is pitches else 1
            for value in ((kept + step * n) % (step * banks) for n in range(banks)):
                chosen[name] = value
                known = words_of(starts, pitches)
                stalls = sum(one.weight * one.stalls(known) for one in touched)
                if stalls < (1.0 - _NOISE) * least:
                    kept, least = value, stalls
            chosen[name] = kept
        if (pitches, starts) == before:
            break
    return pitches, starts


def words_of(banks: Mapping[str, int], pitches: Mapping[str, int]) -> dict[str, int]:
    """What is known of addresses, if arrays start in these banks and rows lie so far apart."""
    starts = {f"&{name}": WORD_BYTES * bank for name, bank in banks.items()}
    return starts | {pitch_of(name, 1).key: pitch for name, pitch in pitches.items()}


def _words_in(node: Node) -> tuple[str, ...]:
    return tuple(word for words, _ in node.address or () for word in words)


def _bank(node: Node, stage: _Draws, banks: int, known: Words, *, is_mapped: bool) -> _Draws:
    """The bank of an access while the newest iteration is `stage` ahead of its own."""
    around = WORD_BYTES * banks
    if node.address is None:
        return _drawn(f"access {node.id}", banks)
    total = np.zeros(_DRAWN, np.int64)
    for words, factor in node.address:
        product = np.full(_DRAWN, factor % around)
        for word in words:
            value = known.get(word, _unknown(word, around))
            if word.startswith(CHANGES) and is_mapped:
                value = _unknown(f"{word} {stage[0]}", around)
            if word == ITERATION.key:
                value = value - stage
            elif word.startswith("&"):  # arrays start at whole words
                if not (word in known or is_mapped):
                    value = _chosen(word, around)
                value = value // WORD_BYTES * WORD_BYTES
            product = product * value % around
        total += product
    return total % around // WORD_BYTES


@cache
def _drawn(word: str, below: int, times: int = _DRAWN) -> _Draws:
    """What an unknown word is, each time."""
    return np.array(Random(word).choices(range(below), k=times), np.int64)


@cache
def _unknown(word: str, around: int) -> _Draws:
    """As drawn; every other dimension is a multiple of the banks, if rows are not spaced."""
    value = _drawn(word, 1 if word.startswith(FROM_END) else around)
    if is_pitch(Input(word)) or not is_dimension(Input(word)):
        return value
    return np.where(_drawn(f"{word} aligned", _ALIGNED) == 0, 0, value)


def _chosen(what: str, below: int) -> _Draws:
    """What a compiler is free to choose: the same in all draws of one choice."""
    return np.repeat(_drawn(what, below, _CHOICES), _DRAWN // _CHOICES)
