"""Register allocation against enumeration."""

from __future__ import annotations

import random
from itertools import combinations, product

import pytest

from vividc.mapper.resources.registers import Lifetime, allocate, conflict


def _slots(lifetime: Lifetime, ii: int) -> set[int]:
    return {time % ii for time in range(lifetime.first, lifetime.last + 1)}


def _legal(lifetimes: list[Lifetime], chosen: tuple[int, ...], ii: int) -> bool:
    pairs = combinations(zip(lifetimes, chosen, strict=True), 2)
    return all(a[1] != b[1] or not _slots(a[0], ii) & _slots(b[0], ii) for a, b in pairs)


def _random_lifetimes(seed: int) -> tuple[list[Lifetime], int]:
    draw = random.Random(seed)
    ii = draw.randint(2, 6)
    begins = [draw.randint(0, 2 * ii) for _ in range(draw.randint(1, 6))]
    return [Lifetime(n, b, b + draw.randint(0, ii - 1)) for n, b in enumerate(begins)], ii


@pytest.mark.parametrize("seed", range(200))
def test_allocation_is_found_whenever_one_exists(seed: int) -> None:
    lifetimes, ii = _random_lifetimes(seed)
    for registers in (1, 2, 3):
        choices = product(range(registers), repeat=len(lifetimes))
        exists = any(_legal(lifetimes, choice, ii) for choice in choices)
        chosen = allocate(lifetimes, ii, registers)
        assert (chosen is not None) == exists
        if chosen is not None:
            assert max(chosen) < registers
            assert _legal(lifetimes, chosen, ii)


def test_arcs_may_need_more_registers_than_the_fullest_slot_has_words() -> None:
    lifetimes = [Lifetime(0, 0, 1), Lifetime(1, 1, 2), Lifetime(2, 2, 3)]
    assert allocate(lifetimes, 3, 2) is None
    assert conflict(lifetimes, 3, 2) == tuple(lifetimes)


def test_a_conflict_leaves_out_stays_that_do_not_matter() -> None:
    lifetimes = [Lifetime(9, 0, 0), Lifetime(0, 3, 4), Lifetime(1, 4, 5), Lifetime(2, 4, 4)]
    assert conflict(lifetimes, 6, 1) == (Lifetime(1, 4, 5), Lifetime(2, 4, 4))


def test_a_stay_longer_than_the_ii_is_refused() -> None:
    with pytest.raises(ValueError, match="longer than II"):
        allocate([Lifetime(0, 1, 8)], 4, 2)
