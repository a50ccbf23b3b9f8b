"""How long a tile stands still as accesses of one cycle meet in a bank: what is expected.

Where accesses lie is known as far as their addresses are (`Node.address`), relative to each other
by the words that they have in common. A word of which nothing is known is drawn many times, the
same ones in every run.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property, lru_cache
from random import Random
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vividc.arch.fabric import Scratchpad
from vividc.dfg.ir import CHANGES, DFG, FROM_END, Node
from vividc.machine.words import WORD_BYTES
from vividc.mapper.resources.arms import Arm, arms_of
from vividc.mapper.resources.waits import spread_slots, waits_by_start, waits_of, waits_of_slot
from vividc.ssa.analysis.polynomial import ITERATION
from vividc.ssa.ir import Input, is_dimension, is_pitch, pitch_of

_DRAWN: Final = 512
"""Times that each unknown word is drawn: a mean of 1 stall an iteration is within 0.05."""

_CHOICES: Final = 8
"""So many ways are drawn to map what is not mapped yet, and to place its arrays: the best counts,
as a compiler chooses.
"""

_ROOM: Final = 1
"""Slots have room for so many accesses more than if all had equally many: mappers have other things
to think of, too.
"""

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

_PRODUCTS: Final = 2048
"""Products of words, of so many the draws are kept: 8 MiB."""

_Draws = NDArray[np.int64]
_NEVER: Final = np.zeros(_DRAWN, np.bool_)
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


class _Group(NamedTuple):
    """Some accesses, by id, and the words in their addresses."""

    accesses: tuple[int, ...]
    words: tuple[str, ...]


_Slots = dict[int, _Group]


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
    _groups: dict[object, _Group] = field(init=False, compare=False, default_factory=dict)
    _by_slot: dict[_Group, _Slots] = field(init=False, compare=False, default_factory=dict)
    _by_start: dict[object, NDArray[np.float64]] = field(
        init=False, compare=False, default_factory=dict
    )

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
        group = self._among(None if among is None else frozenset(among))
        key = group.accesses, tuple(map(known.get, group.words))
        if key not in self._stalls:
            self._stalls[key] = self._stalls_of(group, known)
        return self._stalls[key]

    @cached_property
    def _words(self) -> dict[int, tuple[str, ...]]:
        """The words in the address of each access, by id."""
        return {
            n.id: tuple(word for words, _ in n.address or () for word in words)
            for n in self.accesses
        }

    @cached_property
    def _nodes(self) -> dict[int, Node]:
        return {node.id: node for node in self.accesses}

    def _among(self, arrays: frozenset[str] | None) -> _Group:
        if arrays not in self._groups:
            every = self.accesses
            accesses = [node for node in every if arrays is None or node.name in arrays]
            self._groups[arrays] = self._group(accesses)
        return self._groups[arrays]

    def _group(self, accesses: Iterable[Node]) -> _Group:
        ids = tuple(node.id for node in accesses)
        return _Group(ids, tuple(dict.fromkeys(word for one in ids for word in self._words[one])))

    def _stalls_of(self, group: _Group, known: Words) -> float:
        if len(group.accesses) < 2:  # noqa: PLR2004 - it takes two to meet
            return 0.0
        if self.times is not None:
            return self._stalls_of_slots(group, self.times, known)
        accesses = [self._nodes[one] for one in group.accesses]
        if self.spread:
            places = self._spread_places(accesses, known)
        else:
            places = np.stack([self._places(node, known) for node in accesses])
        waits = waits_of(places, self.ii * self.banks, self.banks)
        return float(waits.reshape(_CHOICES, -1).mean(axis=1).min())

    def _spread_places(self, accesses: Sequence[Node], known: Words) -> _Draws:
        """Slots and banks of accesses in drawn stages, each of which starts where it meets fewest
        others.
        """
        banks = np.stack([self._spread_bank(node, known) for node in accesses])
        room = _ROOM + -(-len(banks) // self.ii)
        chosen = spread_slots(banks, self.banks, _CHOICES, self.ii, room)
        slots = np.repeat(chosen, _DRAWN // _CHOICES, axis=1)
        return np.where(banks == self.banks, self.ii * self.banks, slots * self.banks + banks)

    def _spread_bank(self, node: Node, known: Words) -> _Draws:
        """What is idle lies in a bank of its own."""
        key = ("spread", node.id, tuple(map(known.get, self._words[node.id])))
        if key not in self._known:
            bank = _bank(node, _chosen(f"stage {node.id}", _STAGES), self.banks, known)
            self._known[key] = self._or_idle(node, bank, self.banks)
        return self._known[key]

    def stalls_by_start(
        self, array: str, known: Words = NOTHING, among: Collection[str] | None = None
    ) -> list[float]:
        """As `stalls` of what is mapped, for each bank that an array may start in."""
        assert self.times is not None
        group = self._among(None if among is None else frozenset(among))
        totals = np.zeros(self.banks)
        for slot, here in self._slots_of(group, self.times).items():
            totals += self._slot_by_start(slot, here, array, known)
        return totals.tolist()

    def _stalls_of_slots(self, group: _Group, times: Mapping[int, int], known: Words) -> float:
        """Accesses of different slots do not meet: each slot counts by itself, and anew only where
        another word is known of its addresses.
        """
        slots = self._slots_of(group, times)
        return sum((self._slot(slot, here, known) for slot, here in slots.items()), 0.0)

    def _slots_of(self, group: _Group, times: Mapping[int, int]) -> _Slots:
        """Accesses by slot, of slots with two at least."""
        if group not in self._by_slot:
            slots: dict[int, list[Node]] = {}
            for one in group.accesses:
                slots.setdefault(times[one] % self.ii, []).append(self._nodes[one])
            self._by_slot[group] = {
                slot: self._group(nodes) for slot, nodes in slots.items() if len(nodes) > 1
            }
        return self._by_slot[group]

    def _slot(self, slot: int, here: _Group, known: Words) -> float:
        key = slot, here.accesses, tuple(map(known.get, here.words))
        if key not in self._stalls:
            self._stalls[key] = waits_of_slot(*self._banks_of(here, known), self.banks) / _DRAWN
        return self._stalls[key]

    def _slot_by_start(
        self, slot: int, here: _Group, array: str, known: Words
    ) -> NDArray[np.float64] | float:
        """Of a slot for each bank that an array may start in; one number if it does not matter."""
        word = f"&{array}"
        if word not in here.words:
            return self._slot(slot, here, known)
        key = slot, here.accesses, word, tuple(known.get(one) for one in here.words if one != word)
        if key not in self._by_start:
            depends = [word in self._words[one] for one in here.accesses]
            moves = [_start_of(self._nodes[one]) == word for one in here.accesses]
            if depends == moves:
                banks, moved = self._banks_of(here, {**known, word: 0})
                waits = waits_by_start(banks, moved, np.array(moves, np.int64), self.banks)
                self._by_start[key] = waits / _DRAWN
            else:
                starts = ({**known, word: WORD_BYTES * bank} for bank in range(self.banks))
                self._by_start[key] = np.array([self._slot(slot, here, one) for one in starts])
        return self._by_start[key]

    def _banks_of(self, here: _Group, known: Words) -> tuple[_Draws, NDArray[np.int64]]:
        """The banks of accesses of what is mapped, by row; -1: it is not made; and by how many each
        is moved, as its array starts in another bank than the first.
        """
        nodes = [self._nodes[one] for one in here.accesses]
        moved = [known.get(_start_of(node), 0) // WORD_BYTES for node in nodes]
        banks = np.stack([self._bank_from_start(node, known) for node in nodes])
        return banks, np.array(moved, np.int64)

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
                bank = _bank(node, stage, self.banks, known)
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
            bank = _bank(node, 0, self.banks, known)
            banks[number] = np.where(self._idle(node), -1 - number, bank)  # none of the others'
        often = np.zeros((len(banks), len(banks)))
        for number, bank in enumerate(banks):
            often[number] = (banks == bank).mean(axis=1)
        np.fill_diagonal(often, 0.0)
        return often

    def touches(self, array: str) -> bool:
        """Whether one of the accesses is to an array."""
        return array in self._arrays

    def arrays(self, among: Collection[str] | None = None) -> frozenset[str]:
        """The arrays that are accessed, of all or of these."""
        return self._arrays if among is None else self._arrays.intersection(among)

    @cached_property
    def _arrays(self) -> frozenset[str]:
        return frozenset(node.name for node in self.accesses)

    def _places(self, node: Node, known: Words) -> _Draws:
        """Slot and bank of an access that starts at any time, as one number."""
        key = node.id, tuple(map(known.get, self._words[node.id]))
        if key not in self._known:
            slot, drawn = (_chosen(f"{n} {node.id}", n) for n in (self.ii, _STAGES))
            place = slot * self.banks + _bank(node, drawn, self.banks, known)
            self._known[key] = self._or_idle(node, place, self.ii * self.banks)
        return self._known[key]

    def _or_idle(self, node: Node, places: _Draws, beside: int) -> _Draws:
        """The places of an access, one beside all of them where it is not made."""
        return np.where(self._idle(node), beside, places) if node.id in self.arms else places

    def _bank_from_start(self, node: Node, known: Words) -> _Draws:
        """The bank of an access of what is mapped if its array starts in the first one, -1 where it
        is not made: where the array starts is added last, as layouts that are compared often differ
        in nothing else.
        """
        start = _start_of(node)
        words = {**known, start: 0} if start in known else known
        key = node.id, tuple(map(words.get, self._words[node.id]))
        if key not in self._known:
            assert self.times is not None
            bank = _bank(node, self.times[node.id] // self.ii, self.banks, words)
            self._known[key] = self._or_idle(node, bank, -1)
        return self._known[key]

    def _idle(self, node: Node) -> NDArray[np.bool_]:
        """In which draws an access is not made."""
        if node.id not in self.arms:
            return _NEVER
        idle = _drawn("predicate", _IDLE) == 0
        for arm in self.arms[node.id]:
            idle = idle | (_drawn(f"arms of {arm.choice}", arm.count) != arm.number)
        return np.asarray(idle)


def words_of(banks: Mapping[str, int], pitches: Mapping[str, int]) -> dict[str, int]:
    """What is known of addresses, if arrays start in these banks and rows lie so far apart."""
    starts = {f"&{name}": WORD_BYTES * bank for name, bank in banks.items()}
    return starts | {pitch_of(name, 1).key: pitch for name, pitch in pitches.items()}


def _start_of(node: Node) -> str:
    """The word for where an access's array starts, if its address moves with that; else none."""
    start = f"&{node.name}"
    own = [factor for words, factor in node.address or () if start in words]
    return start if own == [1] and ((start,), 1) in (node.address or ()) else ""


def _bank(node: Node, stage: _Draws | int, banks: int, known: Words) -> _Draws:
    """The bank of an access while the newest iteration is `stage` ahead of its own: of what is
    mapped, a number; of what is not, drawn.
    """
    around = WORD_BYTES * banks
    if node.address is None:
        return _drawn(f"access {node.id}", banks)
    total = np.zeros(_DRAWN, np.int64)
    for words, factor in node.address:
        term = tuple((word, known.get(word)) for word in words)
        if isinstance(stage, int):
            moves = any(word == ITERATION.key or word.startswith(CHANGES) for word in words)
            total += _product_at(term, factor, stage if moves else 0, around)
        else:
            total += _product(term, factor, stage, around, is_mapped=False)
    return total % around // WORD_BYTES


_Term = tuple[tuple[str, int | None], ...]
"""Words of a product, and what is known of each."""


@lru_cache(maxsize=_PRODUCTS)
def _product_at(term: _Term, factor: int, stage: int, around: int) -> _Draws:
    """Of what is mapped: most accesses of a kernel have the same words."""
    return _product(term, factor, np.full(_DRAWN, stage), around, is_mapped=True)


def _product(term: _Term, factor: int, stage: _Draws, around: int, *, is_mapped: bool) -> _Draws:
    """A product of words, modulo what all banks hold."""
    product = np.full(_DRAWN, factor % around)
    for word, given in term:
        value: _Draws | int = _unknown(word, around) if given is None else given
        if word.startswith(CHANGES) and is_mapped:
            value = _unknown(f"{word} {stage[0]}", around)
        if word == ITERATION.key:
            value = value - stage
        elif word.startswith("&"):  # arrays start at whole words
            if given is None and not is_mapped:
                value = _chosen(word, around)
            value = value // WORD_BYTES * WORD_BYTES
        product = product * value % around
    return product


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
