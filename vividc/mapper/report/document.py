"""A map result as JSON and back, with all that its certificate needs.

Nodes are named by id and edges by index. The document also holds the graph (`vividc.dfg.to_json`)
and the fabric's YAML, so that it can be checked by itself (`read_result`, `vividc verify`).
"""

from __future__ import annotations

import contextlib
import platform
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from typing import Any, Final, TypeVar, cast, get_args

from vividc.arch import Fabric, load_text
from vividc.dfg import DFG, check
from vividc.dfg import from_json as dfg_from_json
from vividc.dfg import to_json as dfg_to_json
from vividc.errors import VividcError, demand_type, quoted
from vividc.mapper.mapping import (
    Bound,
    Mapping,
    Objective,
    Place,
    Refutation,
    Status,
    Step,
    Subject,
)
from vividc.mapper.problem import ConstantKey
from vividc.mapper.result import MapResult

SCHEMA: Final = "vividc.mapping/2"
_FILE: Final = "mapping file: "
T = TypeVar("T")


def mapping_to_json(result: MapResult, dfg: DFG, fabric: Fabric) -> dict[str, Any]:
    """A JSON-ready object that `mapping_from_json` reads back."""
    demand_type(result, MapResult, "the result", "give what map_dfg gave")
    _demand_subject(dfg, fabric)
    subject = result.subject or Subject(dfg, fabric)
    return {
        "schema": SCHEMA,
        "dfg": dfg.name,
        "fabric": fabric.name,
        "mapper": result.mapper,
        "status": result.status,
        "ii": result.ii,
        "lower_bound": result.lower_bound,
        "wall_s": result.wall_s,
        "bounds": [_bound_object(bound, dfg) for bound in result.bounds],
        "refuted": [{"ii": item.ii, "by": item.by} for item in result.refuted],
        "stats": dict(result.stats),
        "constrained": result.constrained,
        "hurried": result.hurried,
        "objective": None if result.objective is None else asdict(result.objective),
        "allowed": [
            {"node": node, "pes": sorted(pes)} for node, pes in sorted(subject.allowed.items())
        ],
        "resident": [
            {"pe": pe, "entries": [{kind: word} for kind, word in sorted(held, key=repr)]}
            for pe, held in sorted(subject.resident.items())
        ],
        "mapping": None if result.mapping is None else _mapping_object(result.mapping, dfg),
        "versions": _versions(),
        "graph": dfg_to_json(dfg),
        "fabric_yaml": fabric.source,
    }


def mapping_from_json(data: object, dfg: DFG, fabric: Fabric) -> MapResult:
    """The result that `mapping_to_json` wrote. The mapping is read, not verified: call `verify`
    before using it.

    Raises
    ------
    VividcError
        Not such an object, of another version, or made for another DFG or fabric.
    """
    _demand_subject(dfg, fabric)
    top = _object(data, "mapping file")
    if top.get("schema") != SCHEMA:
        raise _fault("schema", f"expected {SCHEMA!r}, found {quoted(top.get('schema'))}")
    for key, name in (("dfg", dfg.name), ("fabric", fabric.name)):
        if top.get(key) != name:
            raise _fault(key, f"made for {quoted(top.get(key))}, not for {quoted(name)}")
    status = _get(top, "status", str)
    if status not in get_args(Status):
        raise _fault("status", f"{quoted(status)} is none of {', '.join(get_args(Status))}")
    body = top.get("mapping")
    subject = Subject(dfg, fabric, _allowed(top, dfg, fabric), _resident(top, fabric))
    return MapResult(
        status=cast(Status, status),
        ii=None if top.get("ii") is None else _get(top, "ii", int),
        lower_bound=_get(top, "lower_bound", int),
        bounds=tuple(_each(top, "bounds", _bound)),
        mapping=None if body is None else _mapping(_object(body, "mapping"), subject),
        mapper=_get(top, "mapper", str),
        wall_s=_number(top, "wall_s"),
        refuted=tuple(_each(top, "refuted", _refutation)),
        stats=_stats(top),
        subject=subject,
        constrained="constrained" in top and _flag(top, "constrained"),
        hurried="hurried" in top and _flag(top, "hurried"),
        objective=_objective(top),
    )


def _demand_subject(dfg: object, fabric: object) -> None:
    demand_type(dfg, DFG, "the graph", "give a DFG, as dfg.load returns it")
    demand_type(fabric, Fabric, "the fabric", "give a Fabric, as arch.load returns it")


def read_result(data: object, file: str = "mapping file") -> MapResult:
    """The result in a document, with the graph and the fabric that stand in it as its `subject`.

    Raises
    ------
    VividcError
        As `mapping_from_json`; or graph or fabric are missing or malformed.
    """
    top = _object(data, "mapping file")
    if top.get("schema") != SCHEMA:
        raise _fault("schema", f"expected {SCHEMA!r}, found {quoted(top.get('schema'))}")
    dfg = dfg_from_json(_object(top.get("graph"), "graph"), file=f"{file}: graph")
    problems = check(dfg)
    if problems:
        raise _fault("graph", "; ".join(problems[:3]))
    source = _get(top, "fabric_yaml", str)
    if not source:
        raise _fault("fabric_yaml", "empty: the fabric was not made from YAML")
    fabric = load_text(source, f"{file}: fabric_yaml")
    return mapping_from_json(data, dfg, fabric)


def _objective(top: dict[str, Any]) -> Objective | None:
    if top.get("objective") is None:
        return None
    item = _object(top["objective"], "objective")
    value, before, bound = (
        None if item.get(key) is None else _get(item, key, int)
        for key in ("value", "before", "bound")
    )
    last_issue = _get(item, "last_issue", int)
    return Objective(_get(item, "name", str), value, before, bound, last_issue)


def _versions() -> dict[str, str]:
    """Versions of what decides which mapping is found: another version may find another mapping."""
    versions = {"python": platform.python_version()}
    for package in ("vividc", "ortools", "numpy"):
        with contextlib.suppress(PackageNotFoundError):  # run from a checkout
            versions[package] = version(package)
    return versions


def _bound_object(bound: Bound, dfg: DFG) -> dict[str, Any]:
    entry: dict[str, Any] = {"name": bound.name, "ii": bound.ii, "reason": bound.reason}
    entry["nodes"] = list(bound.nodes)
    entry["source"] = [str(node.loc) for n in bound.nodes if (node := dfg.by_id[n]).loc is not None]
    if bound.edges:
        entry["edges"] = list(bound.edges)
        entry["distance"] = bound.distance
    return entry


def _mapping_object(mapping: Mapping, dfg: DFG) -> dict[str, Any]:
    return {
        "ii": mapping.ii,
        "places": [
            {"node": node, "pe": place.pe, "time": place.time}
            for node, place in sorted(mapping.places.items())
        ],
        "routes": [
            {
                "edge": index,
                "src": dfg.edges[index].src,
                "dst": dfg.edges[index].dst,
                "steps": [
                    {"kind": s.kind, "pe": s.pe, "index": s.index, "time": s.time} for s in steps
                ],
            }
            for index, steps in sorted(mapping.routes.items())
        ],
    }


def _mapping(body: dict[str, Any], subject: Subject) -> Mapping:
    dfg = subject.dfg
    places = _by_key(body, "places", "node", _place)
    known = {node.id for node in dfg.placed}
    if places.keys() != known:
        odd = sorted(places.keys() ^ known)[0]
        raise _fault("places", f"node {odd} is in only one of the mapping and the DFG")
    routes = _by_key(body, "routes", "edge", lambda item: _route(item, dfg))
    ii = _get(body, "ii", int)
    if ii < 1:
        raise _fault("ii", f"{ii} is not 1 or more")
    return Mapping(ii, places, routes, subject)


def _place(item: dict[str, Any]) -> tuple[int, Place]:
    return _get(item, "node", int), Place(_get(item, "pe", int), _get(item, "time", int))


def _route(item: dict[str, Any], dfg: DFG) -> tuple[int, tuple[Step, ...]]:
    index = _get(item, "edge", int)
    if not 0 <= index < len(dfg.edges):
        raise _fault("edge", f"the DFG has no edge {index}")
    edge = dfg.edges[index]
    if (_get(item, "src", int), _get(item, "dst", int)) != (edge.src, edge.dst):
        raise _fault("edge", f"edge {index} of the DFG has other ends")
    return index, tuple(_each(item, "steps", _step))


def _step(item: dict[str, Any]) -> Step:
    kind = _get(item, "kind", str)
    pe, index, time = (_get(item, key, int) for key in ("pe", "index", "time"))
    if kind == "link":
        return Step("link", pe, index, time)
    if kind == "reg":
        return Step("reg", pe, index, time)
    if kind == "out":
        return Step("out", pe, index, time)
    raise _fault("kind", f"{kind!r} is none of 'link', 'reg' and 'out'")


def _bound(item: dict[str, Any]) -> Bound:
    distance = _get(item, "distance", int) if "distance" in item else 0
    return Bound(
        name=_get(item, "name", str),
        ii=_get(item, "ii", int),
        reason=_get(item, "reason", str),
        nodes=_integers(item, "nodes") if "nodes" in item else (),
        edges=_integers(item, "edges") if "edges" in item else (),
        distance=distance,
    )


def _allowed(top: dict[str, Any], dfg: DFG, fabric: Fabric) -> dict[int, frozenset[int]]:
    def read(item: dict[str, Any]) -> tuple[int, frozenset[int]]:
        node, pes = _get(item, "node", int), _integers(item, "pes")
        if node not in dfg.by_id:
            raise _fault("node", f"the graph has no node {node}")
        for pe in pes:
            _check_pe("pes", pe, fabric)
        return node, frozenset(pes)

    return _by_key(top, "allowed", "node", read) if "allowed" in top else {}


def _resident(top: dict[str, Any], fabric: Fabric) -> dict[int, frozenset[ConstantKey]]:
    def read(item: dict[str, Any]) -> tuple[int, frozenset[ConstantKey]]:
        pe = _get(item, "pe", int)
        _check_pe("pe", pe, fabric)
        return pe, frozenset(_each(item, "entries", _entry))

    return _by_key(top, "resident", "pe", read) if "resident" in top else {}


def _entry(item: dict[str, Any]) -> ConstantKey:
    if item.keys() == {"const"}:
        return "const", _get(item, "const", int)
    if item.keys() == {"live_in"}:
        return "live_in", _get(item, "live_in", str)
    raise _fault("entry", 'neither {"const": word} nor {"live_in": name}')


def _check_pe(place: str, pe: int, fabric: Fabric) -> None:
    if not 0 <= pe < len(fabric.pes):
        raise _fault(place, f"the fabric has no PE {pe}; PEs are 0 to {len(fabric.pes) - 1}")


def _refutation(item: dict[str, Any]) -> Refutation:
    ii = _get(item, "ii", int)
    if ii < 1:
        raise _fault("ii", f"{ii} is not 1 or more")
    return Refutation(ii, _get(item, "by", str))


def _stats(top: dict[str, Any]) -> dict[str, float]:
    stats = _object(top.get("stats", {}), "stats")
    return {key: _number(stats, key) for key in stats}


def _each(item: dict[str, Any], key: str, read: Callable[[dict[str, Any]], T]) -> Iterator[T]:
    """Each entry of a list, read by `read`; an error names the entry by its number."""
    entries = item.get(key)
    if not isinstance(entries, list):
        raise _fault(key, "missing, or not a list")
    for number, entry in enumerate(entries):
        where = f"{key}[{number}]"
        try:
            value = read(_object(entry, ""))
        except VividcError as error:
            inner = str(error.loc).removeprefix(_FILE)
            raise _fault(f"{where}.{inner}" if inner else where, error.reason) from error
        yield value


def _by_key(
    item: dict[str, Any], key: str, name: str, read: Callable[[dict[str, Any]], tuple[int, T]]
) -> dict[int, T]:
    """The entries of a list by their key, which must be unique."""
    by_key: dict[int, T] = {}
    for number, (about, value) in enumerate(_each(item, key, read)):
        if about in by_key:
            raise _fault(f"{key}[{number}].{name}", f"{name} {about} is there already")
        by_key[about] = value
    return by_key


def _integers(item: dict[str, Any], key: str) -> tuple[int, ...]:
    numbers = item.get(key)
    if not isinstance(numbers, list) or not all(type(number) is int for number in numbers):
        raise _fault(key, "not a list of integers")
    return tuple(numbers)


def _flag(item: dict[str, Any], key: str) -> bool:
    value = item.get(key)
    if not isinstance(value, bool):
        raise _fault(key, "neither true nor false")
    return value


def _number(item: dict[str, Any], key: str) -> float:
    value = item.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise _fault(key, "missing, or not a number")
    if not abs(value) <= sys.float_info.max:  # NaN, and integers that no float holds
        raise _fault(key, "not a finite number")
    return float(value)


def _get(item: dict[str, Any], key: str, kind: type[T]) -> T:
    value = item.get(key)
    if not isinstance(value, kind) or isinstance(value, bool):
        raise _fault(key, f"missing, or not of type {kind.__name__}")
    return value


def _object(data: object, name: str) -> dict[str, Any]:
    if not isinstance(data, dict):
        raise _fault(name, "not a JSON object")
    return data


def _fault(place: str, reason: str) -> VividcError:
    hint = "write the mapping anew with `vividc map`"
    return VividcError(reason, loc=f"{_FILE}{place}", hint=hint)
