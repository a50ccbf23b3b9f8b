"""Random nests in other orders mean the same, and the search notices what does not."""

from __future__ import annotations

import numpy as np
import pytest

from tests.fuzz.trees import Search
from tests.ssa.compiled import Outside, compiled
from tests.ssa.polyhedral.wide_nests import MOST, WIDTH, random_wide_nest
from vividc.errors import SSAError
from vividc.machine.words import WORD_MASK
from vividc.ssa.interpret import interpret
from vividc.ssa.ir import Function
from vividc.ssa.polyhedral.relations import Relations


def test_random_nests_in_other_orders() -> None:
    search = Search(sizes=6)
    for seed in range(6):
        search.run(seed)
    assert not search.finds
    assert search.counts["trees"] > 15


@pytest.mark.parametrize(
    "seed",
    [
        pytest.param(562, id="guards follow the loops that move"),
        pytest.param(20039, id="a loop without statements has no rows"),
        pytest.param(20058, id="a loop without statements is not skewed"),
    ],
)
def test_what_was_found(seed: int) -> None:
    search = Search(sizes=3, in_place=False)
    search.run(seed)
    assert not search.finds
    assert search.counts["trees"] > 1


@pytest.mark.slow
@pytest.mark.parametrize("hundred", range(10))
def test_more_random_nests_in_other_orders(hundred: int) -> None:
    search = Search()
    for seed in range(100 * hundred, 100 * hundred + 100):
        search.run(seed)
    assert not search.finds


def test_an_order_that_breaks_dependences_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Relations, "respects", lambda relations, schedule, rows: True)
    search = Search(sizes=6)
    seeds = iter(range(12))
    while not search.finds:
        search.run(next(seeds))


@pytest.mark.parametrize("seed", range(12))
def test_nests_as_python_do_what_is_interpreted(seed: int) -> None:
    function = random_wide_nest(seed)
    ended = [_both(function, n, m, seed) for n in (0, 3, MOST) for m in (0, 4)]
    assert any(ended) or not all(block.instrs for block in function.blocks)


def _both(function: Function, n: int, m: int, seed: int) -> bool:
    numbers = np.random.default_rng(seed)
    a, b = (numbers.integers(-50, 50, size, np.int32) for size in (WIDTH * WIDTH, (WIDTH, WIDTH)))
    f = numbers.random(WIDTH * WIDTH, np.float32)
    t = numbers.integers(-50, 50, WIDTH, np.int32)
    words = {"a": a, "b": b.reshape(-1), "f": f, "t": t}
    arrays = {name: array.view(np.uint32).tolist() for name, array in words.items()}
    inputs = {f"&{name}": 0 for name in arrays}
    inputs |= {
        "n": n & WORD_MASK,
        "g.shape0": m,
        "b.pitch1": WIDTH,
        "b.shape1": WIDTH,
        "t.shape0": WIDTH,
    }
    try:
        interpret(function, a, b, f, t, np.zeros(m, np.int32), n)
    except SSAError:
        with pytest.raises(Outside):
            compiled(function)(arrays, inputs, 10**6)
        return False
    assert compiled(function)(arrays, inputs, 10**6)
    for name, array in words.items():
        assert array.view(np.uint32).tolist() == arrays[name]
    return True
