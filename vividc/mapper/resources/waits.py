"""Machine code that counts where accesses meet, in many draws of what is not known of them."""

from __future__ import annotations

from typing import Final

import numpy as np

from vividc.host.machine_code import Compiler
from vividc.mapper.resources.arrays import Floats3, Ints, Ints2

_compiled: Final = Compiler()

TURNS: Final = 2
"""Times that each access is given the slot where it meets fewest others."""

CROWDED: Final = 1e-3
"""What an access that is in a slot already counts there, as a meeting: slots are filled evenly."""


def waits_of(places: Ints2, buckets: int, banks: int) -> Ints:
    """Cycles that a tile stands still in each draw, as accesses (by row) lie in these buckets,
    `banks` a slot; what lies behind them is idle.
    """
    waits = np.zeros(places.shape[1], dtype=np.int64)
    _count_waits(np.ascontiguousarray(places), banks, np.zeros(buckets, dtype=np.int64), waits)
    return waits


@_compiled
def _count_waits(places: Ints2, banks: int, counts: Ints, waits: Ints) -> None:
    for draw in range(len(waits)):
        for bucket in range(len(counts)):
            counts[bucket] = 0
        for access in range(places.shape[0]):
            if places[access, draw] < len(counts):
                counts[places[access, draw]] += 1
        for slot in range(len(counts) // banks):
            most = 1
            for bank in range(banks):
                most = max(most, counts[slot * banks + bank])
            waits[draw] += most - 1


def waits_of_slot(places: Ints2, moved: Ints, banks: int) -> int:
    """Cycles that a tile stands still in all draws, as accesses (by row) of one slot lie in these
    banks, each `moved` by so many; those in bank -1 are idle.
    """
    total = np.zeros(1, dtype=np.int64)
    _count_in_slot(np.ascontiguousarray(places), moved, np.zeros(banks, dtype=np.int64), total)
    return int(total[0])


@_compiled
def _count_in_slot(places: Ints2, moved: Ints, counts: Ints, total: Ints) -> None:
    for draw in range(places.shape[1]):
        for bank in range(len(counts)):
            counts[bank] = 0
        most = 1
        for access in range(places.shape[0]):
            if places[access, draw] >= 0:
                bank = (places[access, draw] + moved[access]) % len(counts)
                counts[bank] += 1
                most = max(most, counts[bank])
        total[0] += most - 1


def waits_by_start(places: Ints2, moved: Ints, own: Ints, banks: int) -> Ints:
    """The same as all accesses of one array, of which `own` is 1, others' 0, lie so many banks
    further, for each number of banks.
    """
    totals = np.zeros(banks, dtype=np.int64)
    counts = np.zeros((2, banks), dtype=np.int64)
    _count_by_start(np.ascontiguousarray(places), moved, own, counts, totals)
    return totals


@_compiled
def _count_by_start(places: Ints2, moved: Ints, own: Ints, counts: Ints2, totals: Ints) -> None:
    """`counts`: room for accesses of others, and for own ones, by bank."""
    banks = len(totals)
    for draw in range(places.shape[1]):
        for bank in range(banks):
            counts[0, bank] = 0
            counts[1, bank] = 0
        for access in range(places.shape[0]):
            if places[access, draw] >= 0:
                counts[own[access], (places[access, draw] + moved[access]) % banks] += 1
        for start in range(banks):
            most = 1
            for bank in range(banks):
                most = max(most, counts[0, bank] + counts[1, (bank + banks - start) % banks])
            totals[start] += most - 1


def spread_slots(places: Ints2, banks: int, choices: int, ii: int, room: int) -> Ints2:
    """The slot of each access (by row) for each choice, one after the other, as mappers place them:
    each where it meets fewest others.

    Parameters
    ----------
    places
        The bank of each access in each draw, as many for each choice; `banks`: it is idle.
    room
        Accesses that a slot has room for.
    """
    number = len(places)
    often, costs = np.zeros((choices, number, number)), np.zeros((choices, ii, number))
    slots = np.full((number, choices), -1, dtype=np.int64)
    chain = np.full(banks + number, -1, dtype=np.int64)
    _count_meetings(np.ascontiguousarray(places), banks, chain, often)
    filled = np.zeros((choices, ii), dtype=np.int64)
    _place(often, costs, filled, room, slots)
    return slots


@_compiled
def _count_meetings(places: Ints2, banks: int, chain: Ints, often: Floats3) -> None:
    """How often each access meets each other one in each choice, and itself, and that it is there.

    `chain`: of each bank its last access, then of each access the one before it in its bank.
    """
    draws = places.shape[1] // often.shape[0]
    for draw in range(places.shape[1]):
        choice = draw // draws
        for bank in range(banks):
            chain[bank] = -1
        for one in range(places.shape[0]):
            bank = places[one, draw]
            if bank == banks:
                continue
            other = chain[bank]
            chain[banks + one], chain[bank] = other, one
            often[choice, one, one] += 1
            while other >= 0:
                often[choice, one, other] += 1
                often[choice, other, one] += 1
                other = chain[banks + other]
    for choice in range(often.shape[0]):
        for one in range(often.shape[1]):
            for other in range(often.shape[2]):
                often[choice, one, other] = often[choice, one, other] / draws + CROWDED


@_compiled
def _place(often: Floats3, costs: Floats3, filled: Ints2, room: int, slots: Ints2) -> None:
    choices, number = often.shape[0], often.shape[1]
    for choice in range(choices):
        for turn in range(TURNS):
            for one in range(number):
                slot = slots[one, choice]
                if turn > 0:
                    for other in range(number):
                        costs[choice, slot, other] -= often[choice, one, other]
                    filled[choice, slot] -= 1
                best, least = 0, 0.0
                for at in range(costs.shape[1]):
                    cost = costs[choice, at, one] + float((filled[choice, at] >= room) * number)
                    if at == 0 or cost < least:
                        best, least = at, cost
                slots[one, choice] = best
                for other in range(number):
                    costs[choice, best, other] += often[choice, one, other]
                filled[choice, best] += 1
