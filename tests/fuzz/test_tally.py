"""A search counts what it ran, and goes on where it stopped."""

from __future__ import annotations

from pathlib import Path

from tests.fuzz.features import features
from tests.fuzz.tally import Tally


def tally() -> Tally:
    found = Tally(seconds=2.0)
    found.add(7, "agrees", "", "blocks", {"tuple"})
    found.add(8, "refused", "no such", "", {"tuple", "sort"})
    found.add(9, "differs", "interpreter", "", {"tuple"})
    found.add(10, "agrees", "", "", {"tuple"})
    return found


def test_a_search_goes_on_with_its_counts(tmp_path: Path) -> None:
    file = tmp_path / "state.json"
    tally().keep_in(file)
    again = Tally.kept_in(file)
    assert again == tally()
    assert (again.next_seed, again.programs, again.finds, again.since) == (11, 4, [9], 1)
    assert Tally.kept_in(tmp_path / "none.json") == Tally()


def test_a_feature_counts_where_the_program_agrees() -> None:
    text = tally().summary()
    assert "4 programs, 1 finds (seeds [9]), the last 1 without one" in text
    assert "features of those that agree: tuple: 2" in text
    assert "sort" not in text


def test_features_are_read_from_the_program() -> None:
    source = """# constant array, F order
def other():
    return (1, 2)[0]

def program(a, b, k):
    a, b = b, a
    for i in range(3):
        x1 = a[k:].copy()
        x1 **= 2
        a[::-1] += np.array((k, i))[0]
        while i:
            return (a, b)[0].size
    return a[:1].sum()
"""
    assert features(source) == {
        "constant array, F order",
        "swapped arrays",
        "array made in a loop",
        "slice with bounds of runtime values",
        "slice that goes backwards",
        "operator in place",
        "operator in place, slice",
        "operator in place, power",
        "np.array of values",
        "return from nested loops",
        "tuple of arrays",
        "broadcasting of one element of an axis",
        "method of a slice",
    }
