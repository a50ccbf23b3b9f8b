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


@pytest.mark.parametrize(("key", "name"), [("places", "node"), ("routes", "edge")])
def test_an_entry_that_is_there_twice_is_refused(key: str, name: str) -> None:
    """The last one won without a word."""
    data = _written()
    entries = data["mapping"][key]
    entries.append(dict(entries[0]))
    where = rf"mapping file: {key}\[{len(entries) - 1}\].{name}: {name} \d+ is there already"
    with pytest.raises(VividcError, match=where) as caught:
        mapping_from_json(data, accumulator(), FABRIC)
    assert caught.value.hint == "write the mapping anew with `vividc map`"


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("mapping", "places", 1, "pe"), "0", r"places\[1\].pe: missing, or not of type int"),
        (("mapping", "routes", 0, "steps"), [3], r"routes\[0\].steps\[0\]: not a JSON object"),
        (("bounds", 0, "edges"), "0", r"bounds\[0\].edges: not a list of integers"),
        (("bounds", 0, "nodes"), [True], r"bounds\[0\].nodes: not a list of integers"),
        (("refuted",), [{"ii": 0, "by": "me"}], r"refuted\[0\].ii: 0 is not 1 or more"),
        (("constrained",), "no", "constrained: neither true nor false"),
        (("wall_s",), float("nan"), "wall_s: not a finite number"),
        (("wall_s",), 10**400, "wall_s: not a finite number"),
    ],
)
def test_a_broken_entry_is_named(path: tuple[Any, ...], value: object, message: str) -> None:
    data: Any = _written()
    holder = data
    for key in path[:-1]:
        holder = holder[key]
    holder[path[-1]] = value
    with pytest.raises(VividcError, match=f"mapping file: {message}"):
        mapping_from_json(data, accumulator(), FABRIC)
