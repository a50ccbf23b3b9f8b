"""What machine code counts of accesses that meet in banks is what Python counts."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from vividc.mapper.resources.arrays import Ints
from vividc.mapper.resources.waits import (
    CROWDED,
    TURNS,
    spread_slots,
    waits_by_start,
    waits_of,
    waits_of_slot,
)

BANKS, DRAWS = 4, 24


@pytest.mark.parametrize("accesses", [2, 7, 30])
def test_a_tile_waits_for_the_fullest_bank_of_each_slot(accesses: int) -> None:
    rng = np.random.default_rng(accesses)
    places = rng.integers(0, 3 * BANKS + 1, (accesses, DRAWS))
    for draw, waits in enumerate(waits_of(places, 3 * BANKS, BANKS).tolist()):
        there = Counter(places[:, draw].tolist())
        fullest = [max(there[BANKS * slot + bank] for bank in range(BANKS)) for slot in range(3)]
        assert waits == sum(max(most - 1, 0) for most in fullest)


@pytest.mark.parametrize("accesses", [2, 7, 30])
def test_accesses_of_a_slot_move_with_where_arrays_start(accesses: int) -> None:
    rng = np.random.default_rng(accesses)
    places = rng.integers(-1, BANKS, (accesses, DRAWS))
    moved, own = rng.integers(0, BANKS, accesses), rng.integers(0, 2, accesses)
    by_start = waits_by_start(places, moved, own, BANKS).tolist()
    for start in range(BANKS):
        total = 0
        for drawn in places.T.tolist():
            banks = zip(drawn, moved, own, strict=True)
            there = Counter((b + m + start * o) % BANKS for b, m, o in banks if b >= 0)
            total += max(there.values(), default=1) - 1
        assert waits_of_slot(places, moved + start * own, BANKS) == by_start[start] == total


@pytest.mark.parametrize(("accesses", "choices", "ii"), [(2, 1, 1), (9, 3, 4), (20, 8, 6)])
def test_each_access_goes_where_it_meets_fewest(accesses: int, choices: int, ii: int) -> None:
    rng = np.random.default_rng(accesses)
    banks, room = rng.integers(0, BANKS + 1, (accesses, DRAWS)), 1 + -(-accesses // ii)
    found = spread_slots(banks, BANKS, choices, ii, room)
    for choice, drawn in enumerate(np.split(banks, choices, axis=1)):
        assert found[:, choice].tolist() == _one_after_the_other(drawn, ii, room)


def _one_after_the_other(drawn: Ints, ii: int, room: int) -> list[int]:
    """With numpy: drawn banks are by access."""
    number = len(drawn)
    same = (drawn[:, None] == drawn[None]) & (drawn != BANKS)
    often, costs, slots = same.mean(axis=2) + CROWDED, np.zeros((ii, number)), [-1] * number
    for turn in range(TURNS):
        for one in range(number):
            if turn:
                costs[slots[one]] -= often[one]
            slots[one] = -1
            filled = np.array([slots.count(slot) >= room for slot in range(ii)])
            slots[one] = int((costs[:, one] + filled * number).argmin())
            costs[slots[one]] += often[one]
    return slots
