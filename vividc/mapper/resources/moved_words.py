"""Allocation of a register file whose words may change registers while they wait.

Circular arcs may need more registers than the fullest slot has words (`registers`). Cut at one
slot they are intervals, and those need no more: only words across that slot may come round to
another register than they set out from, and a word that is moved on the way, through a read and a
write port that are free, comes round to its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from vividc.mapper.resources.registers import Lifetime


def allocate_with_moves(
    lifetimes: Sequence[Lifetime], ii: int, registers: int, spare: Sequence[int]
) -> tuple[tuple[Lifetime, ...], tuple[int, ...]] | None:
    """Lifetimes, some cut in two or more, and the register of each; None: none was found, which
    proves nothing. None of them lasts longer than II cycles.

    Parameters
    ----------
    spare
        By slot, how many words have ports to be moved. A word whose next part begins in cycle c is
        read and written in c - 1.
    """
    best: list[_Part] | None = None
    for begin in range(ii):
        parts = _Sweep(lifetimes, ii, registers, spare, begin).parts()
        if parts is not None and (best is None or len(parts) < len(best)):
            best = parts
    if best is None:
        return None
    return tuple(part.lifetime for part in best), tuple(part.register for part in best)


@dataclass(frozen=True, slots=True)
class _Part:
    lifetime: Lifetime
    register: int


class _Sweep:
    """Once around the circle from the slot `begin`, which is cycle 0 here; cycle II is there again.

    `home`: the register that a word across the slot has there; `at`: that of each word now, which
    it has had since the cycle `since`; `holder`: the word in each register, or None; `tails`: when
    a word across the slot leaves its home; `until`: when a register's word across the slot begins.
    """

    def __init__(
        self,
        lifetimes: Sequence[Lifetime],
        ii: int,
        registers: int,
        spare: Sequence[int],
        begin: int,
    ) -> None:
        self.lifetimes, self.ii, self.begin = lifetimes, ii, begin
        self.spare = [spare[(begin + cycle) % ii] for cycle in range(ii)]
        self.first = [(lifetime.first - begin) % ii for lifetime in lifetimes]
        self.end = [
            first + lifetime.last - lifetime.first + 1
            for first, lifetime in zip(self.first, lifetimes, strict=True)
        ]
        self.holder: list[int | None] = [None] * registers
        across = [word for word, end in enumerate(self.end) if end > ii]
        self.fits = len(across) <= registers
        self.home = dict(zip(across, range(registers), strict=False))
        self.until = [ii] * registers
        for word, register in self.home.items():
            self.until[register] = self.first[word]
        self.at: dict[int, int] = {}
        self.since: dict[int, int] = {}
        self.done: list[_Part] = []
        self.tails = {word: self.end[word] - ii for word in self.home}

    def parts(self) -> list[_Part] | None:
        """The parts of all words and their registers; None: a word does not come home."""
        if not self.fits:
            return None
        for word, register in self.home.items():
            self.holder[register] = word
        for cycle in range(self.ii):
            self._leave(cycle)
            self._move_home(cycle)
            if not all(self._enter(word, cycle) for word in self._beginning(cycle)):
                return None
        self._leave(self.ii)
        self._move_home(self.ii)
        if any(self.at[word] != register for word, register in self.home.items()):
            return None
        return [*self.done, *(self._part(word, self.end[word]) for word in self.home)]

    def _leave(self, cycle: int) -> None:
        """What was last readable in the cycle before leaves its register."""
        for register, word in enumerate(self.holder):
            if word is None:
                continue
            if word not in self.at:
                if self.tails[word] <= cycle:
                    self.holder[register] = None
            elif self.end[word] <= cycle:
                self.done.append(self._part(word, self.end[word]))
                self.holder[register] = None

    def _part(self, word: int, end: int) -> _Part:
        whole = self.lifetimes[word]
        shift = whole.first - self.first[word]
        lifetime = replace(whole, first=self.since[word] + shift, last=end - 1 + shift)
        return _Part(lifetime, self.at[word])

    def _beginning(self, cycle: int) -> Iterator[int]:
        """Words that begin in a cycle, those with a home first, then the longest."""
        words = [word for word, first in enumerate(self.first) if first == cycle]
        return iter(sorted(words, key=lambda word: (word not in self.home, -self.end[word])))

    def _enter(self, word: int, cycle: int) -> bool:
        """Put a word into its home, or into a register that is free for it the longest or, of
        those that are free for long enough, the least long.
        """
        free = [register for register, holder in enumerate(self.holder) if holder is None]
        if not free:
            return False
        home, end = self.home.get(word), min(self.end[word], self.ii)
        if home in free:
            register = home
        else:
            long_enough = [one for one in free if self.until[one] >= end]
            if long_enough:
                register = min(long_enough, key=lambda one: self.until[one])
            else:
                register = max(free, key=lambda one: self.until[one])
        self.holder[register], self.at[word], self.since[word] = word, register, cycle
        return True

    def _move_home(self, cycle: int) -> None:
        """Move words to their homes, those that are in the way to theirs at the same time, as far
        as ports are free.
        """
        if cycle == 0:
            return
        for word in self.home:
            chain = self._chain(word, cycle) if self._is_away(word, cycle) else []
            if not chain or len(chain) > self.spare[cycle - 1]:
                continue
            self.spare[cycle - 1] -= len(chain)
            for one in chain:
                self.done.append(self._part(one, cycle))
                self.holder[self.at[one]] = None
            for one in chain:
                home = self.home[one]
                self.holder[home], self.at[one], self.since[one] = one, home, cycle

    def _chain(self, word: int, cycle: int) -> list[int]:
        """The word and those that must leave its home, theirs, and so on; none if one cannot."""
        chain = [word]
        while (other := self.holder[self.home[chain[-1]]]) not in (None, word):
            assert other is not None
            if not self._is_away(other, cycle):
                return []
            chain.append(other)
        return chain

    def _is_away(self, word: int, cycle: int) -> bool:
        """Whether a word that can be read in the cycle before is in another register than home."""
        if word not in self.home or word not in self.at:
            return False
        return self.at[word] != self.home[word] and self.since[word] < cycle
