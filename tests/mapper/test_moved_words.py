"""Allocation of a register file whose words may be moved while they wait."""

from __future__ import annotations

import random
from collections import Counter
from itertools import combinations

import pytest

from vividc.mapper.resources.moved_words import allocate_with_moves
from vividc.mapper.resources.registers import Lifetime, allocate


def _slots(lifetime: Lifetime, ii: int) -> list[int]:
    return [time % ii for time in range(lifetime.first, lifetime.last + 1)]


def _fullest(lifetimes: list[Lifetime], ii: int) -> int:
    return max(Counter(slot for one in lifetimes for slot in _slots(one, ii)).values())


def _check(
    lifetimes: list[Lifetime],
    ii: int,
    registers: int,
    spare: list[int],
    found: tuple[tuple[Lifetime, ...], tuple[int, ...]],
) -> None:
    parts, chosen = found
    assert max(chosen) < registers
    for a, b in combinations(zip(parts, chosen, strict=True), 2):
        assert a[1] != b[1] or not set(_slots(a[0], ii)) & set(_slots(b[0], ii))
    moves = Counter()
    for whole in lifetimes:
        mine = sorted(part for part in parts if part.word == whole.word)
        cycles = [c for part in mine for c in range(part.first, part.last + 1)]
        assert cycles == list(range(whole.first, whole.last + 1))
        moves.update((part.first - 1) % ii for part in mine[1:])
    assert all(number <= spare[slot] for slot, number in moves.items())


def _random(seed: int) -> tuple[list[Lifetime], int]:
    draw = random.Random(seed)
    ii = draw.randint(1, 12)
    begins = [draw.randint(0, 2 * ii) for _ in range(draw.randint(1, 12))]
    return [Lifetime(n, b, b + draw.randint(0, ii - 1)) for n, b in enumerate(begins)], ii


def test_three_arcs_around_a_circle_fit_two_registers_when_one_word_is_moved() -> None:
    lifetimes = [Lifetime(0, 0, 1), Lifetime(1, 1, 2), Lifetime(2, 2, 3)]
    assert allocate(lifetimes, 3, 2) is None
    found = allocate_with_moves(lifetimes, 3, 2, [0, 0, 1])
    assert found is not None
    assert len(found[0]) == 4
    _check(lifetimes, 3, 2, [0, 0, 1], found)
    assert allocate_with_moves(lifetimes, 3, 2, [0, 0, 0]) is None


@pytest.mark.parametrize("seed", range(100))
def test_with_ports_in_every_cycle_words_fit_as_many_registers_as_are_alive_at_once(
    seed: int,
) -> None:
    lifetimes, ii = _random(seed)
    registers = _fullest(lifetimes, ii)
    found = allocate_with_moves(lifetimes, ii, registers, [registers] * ii)
    assert found is not None
    _check(lifetimes, ii, registers, [registers] * ii, found)
    assert allocate_with_moves(lifetimes, ii, registers - 1, [registers] * ii) is None


@pytest.mark.parametrize("seed", range(100))
def test_no_more_words_are_moved_than_have_ports(seed: int) -> None:
    lifetimes, ii = _random(1000 + seed)
    draw = random.Random(seed)
    spare = [draw.randint(0, 1) for _ in range(ii)]
    registers = _fullest(lifetimes, ii)
    found = allocate_with_moves(lifetimes, ii, registers, spare)
    if found is not None:
        _check(lifetimes, ii, registers, spare, found)
    assert allocate_with_moves(lifetimes, ii, registers - 1, spare) is None
