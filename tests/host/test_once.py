"""Frozen objects that are made soon are what `dataclasses` makes."""

from __future__ import annotations

import pickle
from dataclasses import FrozenInstanceError, dataclass, field, replace

import pytest

from vividc.host.once import changed, made_soon


@made_soon
@dataclass(frozen=True, slots=True)
class Item:
    """One with a default, and a field that does not compare."""

    number: int
    name: str = "none"
    line: int | None = field(default=None, compare=False)


def test_fields_are_given_by_place_by_name_or_by_default() -> None:
    assert Item(1) == Item(number=1, name="none", line=7)
    assert (Item(1, "a", 2).name, Item(1, line=2).line) == ("a", 2)
    assert hash(Item(1)) == hash(Item(1, line=3))
    with pytest.raises(TypeError, match="number"):
        Item()  # type: ignore[call-arg]


def test_it_is_frozen_and_can_be_pickled() -> None:
    item = Item(1, "a")
    with pytest.raises(FrozenInstanceError):
        item.number = 2  # type: ignore[misc]
    assert pickle.loads(pickle.dumps(item)) == item


def test_a_changed_one_has_the_other_fields() -> None:
    item = Item(1, "a", 5)
    made = changed(item, name="b")
    assert made == replace(item, name="b")
    assert (made.line, item.name) == (5, "a")
    assert changed(item, line=None).line is None
