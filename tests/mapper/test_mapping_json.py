"""The JSON of a result."""

from __future__ import annotations

import json
from typing import Any

import pytest
from fabrics import grid
from graphs import accumulator, chain

from vividc.errors import VividcError
from vividc.mapper import map_dfg, mapping_from_json, mapping_to_json

FABRIC = grid(2, 2)


def _written() -> dict[str, Any]:
    result = map_dfg(accumulator(), FABRIC, workers=1)
    data = json.loads(json.dumps(mapping_to_json(result, accumulator(), FABRIC)))
    assert isinstance(data, dict)
    return data


def test_a_result_survives_the_way_there_and_back() -> None:
    result = map_dfg(accumulator(), FABRIC, workers=1)
    text = json.dumps(mapping_to_json(result, accumulator(), FABRIC))
    assert mapping_from_json(json.loads(text), accumulator(), FABRIC) == result


def test_a_result_without_a_mapping_survives_too() -> None:
    result = map_dfg(chain(9), FABRIC, ii=1)
    assert mapping_from_json(mapping_to_json(result, chain(9), FABRIC), chain(9), FABRIC) == result


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("schema", "vividc.mapping/1", "expected"),
        ("dfg", "other", "made for 'other'"),
        ("fabric", "other", "made for 'other'"),
        ("status", "perfect", "none of"),
        ("lower_bound", "1", "not of type int"),
        ("bounds", {}, "not a list"),
        ("wall_s", None, "not a number"),
        ("mapping", [], "not a JSON object"),
    ],
)
def test_a_broken_file_says_which_key(key: str, value: object, message: str) -> None:
    with pytest.raises(VividcError, match=message):
        mapping_from_json(_written() | {key: value}, accumulator(), FABRIC)


def test_a_mapping_of_other_nodes_is_refused() -> None:
    data = _written()
    data["mapping"]["places"].pop()
    with pytest.raises(VividcError, match="only one of"):
        mapping_from_json(data, accumulator(), FABRIC)


def test_a_route_of_another_edge_is_refused() -> None:
    data = _written()
    data["mapping"]["routes"][0]["src"] = 99
    with pytest.raises(VividcError, match="other ends"):
        mapping_from_json(data, accumulator(), FABRIC)
