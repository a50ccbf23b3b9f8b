"""Register allocation against enumeration."""

from __future__ import annotations

import random
from itertools import combinations, product

import pytest

from vividc.mapper.resources.registers import Stay, allocate, conflict


def _slots(stay: Stay, ii: int) -> set[int]:
    return {time % ii for time in range(stay.first, stay.last + 1)}


def _legal(stays: list[Stay], chosen: tuple[int, ...], ii: int) -> bool:
    pairs = combinations(zip(stays, chosen, strict=True), 2)
    return all(a[1] != b[1] or not _slots(a[0], ii) & _slots(b[0], ii) for a, b in pairs)


def _random_stays(seed: int) -> tuple[list[Stay], int]:
    draw = random.Random(seed)
    ii = draw.randint(2, 6)
    begins = [draw.randint(0, 2 * ii) for _ in range(draw.randint(1, 6))]
    return [Stay(n, b, b + draw.randint(0, ii - 1)) for n, b in enumerate(begins)], ii


@pytest.mark.parametrize("seed", range(200))
def test_allocation_is_found_whenever_one_exists(seed: int) -> None:
    stays, ii = _random_stays(seed)
    for registers in (1, 2, 3):
        choices = product(range(registers), repeat=len(stays))
        exists = any(_legal(stays, choice, ii) for choice in choices)
        chosen = allocate(stays, ii, registers)
        assert (chosen is not None) == exists
        if chosen is not None:
            assert max(chosen) < registers
            assert _legal(stays, chosen, ii)


def test_arcs_may_need_more_registers_than_the_fullest_slot_has_words() -> None:
    stays = [Stay(0, 0, 1), Stay(1, 1, 2), Stay(2, 2, 3)]
    assert allocate(stays, 3, 2) is None
    assert conflict(stays, 3, 2) == tuple(stays)


def test_a_conflict_leaves_out_stays_that_do_not_matter() -> None:
    stays = [Stay(9, 0, 0), Stay(0, 3, 4), Stay(1, 4, 5), Stay(2, 4, 4)]
    assert conflict(stays, 6, 1) == (Stay(1, 4, 5), Stay(2, 4, 4))


def test_a_stay_longer_than_the_ii_is_refused() -> None:
    with pytest.raises(ValueError, match="longer than II"):
        allocate([Stay(0, 1, 8)], 4, 2)
