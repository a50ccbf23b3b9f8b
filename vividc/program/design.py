"""Graph and mapping of a region as text in a program, so that they can be looked at again."""

from __future__ import annotations

import json
from functools import lru_cache
from typing import Any, Final

from vividc.arch import load_text
from vividc.arch.fabric import Fabric
from vividc.dfg import DFG, check, from_json, to_json
from vividc.errors import BundleError, VividcError
from vividc.mapper.check.verify import violations
from vividc.mapper.report.document import mapping_from_json, mapping_to_json
from vividc.mapper.result import MapResult

_LEFT_OUT: Final = ("graph", "fabric_yaml", "versions", "stats")
"""Of a mapping's document: what stands elsewhere in a program, or is measured."""
_KEPT: Final = 64


def design_text(graph: DFG, result: MapResult | None, fabric: Fabric) -> str:
    """Return what `read_graph` and `read_result` read: the same for equal regions."""
    found = None
    if result is not None:
        found = mapping_to_json(result, graph, fabric)
        found = {key: value for key, value in found.items() if key not in _LEFT_OUT}
        found |= {"wall_s": 0.0, "stats": {}}
    text = {"graph": to_json(graph), "result": found}
    return json.dumps(text, separators=(",", ":"), sort_keys=True)


@lru_cache(_KEPT)
def read_graph(text: str) -> DFG:
    """Return a region's graph.

    Raises
    ------
    BundleError
        It is none.
    """
    try:
        graph = from_json(_object(text).get("graph"), file="the region's graph")
        problems = check(graph)
    except (VividcError, ValueError, TypeError, RecursionError) as error:
        raise BundleError(f"the graph of a region cannot be read: {error}") from error
    if problems:
        raise BundleError(f"the graph of a region is none: {problems[0]}")
    return graph


@lru_cache(_KEPT)
def read_result(text: str, fabric_yaml: str, *, straight: bool) -> MapResult | None:
    """Return what the mapper found for a region; None: there was nothing to place.

    Raises
    ------
    BundleError
        It is no such document, or its mapping is not legal on this fabric.
    """
    try:
        found = _object(text).get("result")
        if found is None:
            return None
        graph, fabric = read_graph(text), load_text(fabric_yaml, "its fabric")
        result = mapping_from_json(found, graph, fabric)
        if result.mapping is not None:
            for fault in violations(graph, fabric, result.mapping, straight=straight):
                raise BundleError(f"the mapping of a region is not legal: {fault.message}")
        return result
    except BundleError:
        raise
    except (VividcError, ValueError, TypeError, RecursionError) as error:
        raise BundleError(f"the mapping of a region cannot be read: {error}") from error


def _object(text: str) -> dict[str, Any]:
    found = json.loads(text)
    if not isinstance(found, dict):
        raise BundleError("a region's design is no JSON object")
    return found
