"""Random launch graphs: the check of order refuses those in which a pair of steps races, and no
others.
"""

from __future__ import annotations

from itertools import combinations, pairwise

import numpy as np
import pytest

from vividc.launch.flat import flat
from vividc.launch.hazards.races import first_race

Use = tuple[int, int, int, int, bool]


def races(uses: list[Use], waits: list[tuple[int, ...]]) -> set[tuple[int, int, int]]:
    """Every pair of steps that races, and where, from the definition."""
    before: list[set[int]] = []
    for direct in waits:
        before.append(set(direct).union(*(before[n] for n in direct)))
    found = set()
    for (place, start, end, step, writes), other in combinations(uses, 2):
        early, late = sorted((step, other[3]))
        shares = place == other[0] and max(start, other[1]) < min(end, other[2])
        if shares and (writes or other[4]) and early != late and early not in before[late]:
            found.add((early, late, place))
    return found


def random_graph(rng: np.random.Generator) -> tuple[list[Use], list[tuple[int, ...]]]:
    """Some of them without a race; in many a step waits for the one before."""
    steps = int(rng.integers(1, 200))
    share = rng.choice([0.9, 0.99, 1.0])
    waits: list[tuple[int, ...]] = [()]
    for one, _ in pairwise(range(steps)):
        chosen = {one} if rng.random() < share else set()
        chosen |= {int(n) for n in rng.integers(0, one + 1, int(rng.integers(0, 3)))}
        waits.append(tuple(sorted(chosen)))
    uses = []
    for step in range(steps):
        for _ in range(int(rng.integers(0, 4))):
            start = int(rng.integers(0, 4000))
            end = start + int(rng.integers(1, 60))
            uses.append((int(rng.integers(-2, 4)), start, end, step, bool(rng.random() < 0.5)))
    return uses, waits


def test_races_are_found_where_the_definition_says() -> None:
    rng = np.random.default_rng(5)
    outcomes = []
    for _ in range(150):
        uses, waits = random_graph(rng)
        race = first_race(np.array(uses, dtype=np.int64).reshape(-1, 5), *flat(waits))
        wrong = races(uses, waits)
        assert race in wrong if wrong else race is None
        outcomes.append(bool(wrong))
    assert 20 < sum(outcomes) < 130


@pytest.mark.parametrize("missing", [None, 0, 200, 499])
def test_a_write_waits_for_each_of_many_reads(missing: int | None) -> None:
    """More steps that wait for none than there are chains at first, and other bytes beside."""
    reads = [(0, 0, 8, step, False) for step in range(500)]
    waits: list[tuple[int, ...]] = [()] * 500
    waits += [tuple(step for step in range(500) if step != missing), (500,)]
    uses = [*reads, (0, 4, 16, 500, True), (0, 8, 12, 501, True)]
    race = first_race(np.array(uses, dtype=np.int64), *flat(waits))
    assert race == (None if missing is None else (missing, 500, 0))


def test_many_steps_that_follow_each_other_take_little_memory() -> None:
    """A bit for each pair of them would be 1.25 GB."""
    count = 100_000
    uses = np.array([(0, 0, 64 + step % 7, step, step % 3 == 0) for step in range(count)], np.int64)
    begin = np.concatenate(([0], np.arange(count)))
    assert first_race(uses, begin, np.arange(count - 1)) is None
    cut = np.arange(count - 1)
    cut[70_000] = 69_000  # waits for an earlier step
    assert first_race(uses, begin, cut) is not None
