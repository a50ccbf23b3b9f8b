"""What machine code counts of accesses that meet in banks is what Python counts."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from vividc.mapper.resources.arrays import Ints
from vividc.mapper.resources.waits import CROWDED, TURNS, spread_slots, waits_of

BANKS, DRAWS = 4, 24


@pytest.mark.parametrize("accesses", [2, 7, 30])
def test_a_tile_waits_for_the_fullest_bank_of_each_slot(accesses: int) -> None:
    rng = np.random.default_rng(accesses)
    places = rng.integers(0, 3 * BANKS + 1, (accesses, DRAWS))
    for draw, waits in enumerate(waits_of(places, 3 * BANKS, BANKS).tolist()):
        there = Counter(places[:, draw].tolist())
        fullest = [max(there[BANKS * slot + bank] for bank in range(BANKS)) for slot in range(3)]
        assert waits == sum(max(most - 1, 0) for most in fullest)


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
