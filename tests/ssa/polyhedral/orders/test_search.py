"""Trees of loops and their factors."""

from __future__ import annotations

from vividc.ssa.polyhedral.orders.search import describe, with_factors, with_factors_of
from vividc.ssa.polyhedral.trees import Loop

ROWS = Loop({"S": "i"}, (Loop({"S": "j"}, ("S",)),))
COLUMNS = Loop({"S": "j"}, (Loop({"S": "i"}, ("S",)),))


def test_an_order_has_the_factors_of_another_one_by_names_and_by_places() -> None:
    given = with_factors(with_factors(ROWS, {(): 8}, masked=True), {(0,): 5})
    assert describe(given) == "i*8?[j*5[S]] of 1"
    alike = with_factors_of(COLUMNS, given)
    assert list(map(describe, alike)) == ["j*5[i*8?[S]] of 1", "j*8?[i*5[S]] of 1"]
    assert with_factors_of(ROWS, given) == [given]


def test_loops_that_another_order_does_not_have_keep_their_factors() -> None:
    given = with_factors(ROWS, {(0,): 4})
    fused = Loop({"S": "j", "T": "k"}, ("S", "T"))
    assert list(map(describe, with_factors_of(fused, given))) == ["j/k[S, T] of 2"]
