"""Documents of results, damaged at random: what the checker accepts is true, or named as trusted.

Truth comes from elsewhere: the least II from the proofs of the documents that were damaged, the
legality of mappings from a replay, the value of objectives from the mapper that minimises them.
"""

from __future__ import annotations

import copy
import json
import random
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Final

import pytest
from graphs import accumulator
from replay import Broken, replay

from vividc import arch
from vividc.arch import Fabric
from vividc.dfg import DFG
from vividc.dfg.forms.json_form import from_json
from vividc.errors import VividcError
from vividc.mapper import (
    Finding,
    MapProblem,
    MapResult,
    ModelHandle,
    Refutation,
    Subject,
    check_certificate,
    map_dfg,
    mapping_from_json,
)
from vividc.mapper.engines.cpsat.minima import measure

_MUTATIONS: Final = 500
_OF_THE_PROBLEM: Final = 20
NAMES: Final = (
    *("optimal", "feasible", "timeout", "asked", "nowhere"),
    *("given", "hops", "moves", "added"),
)
_PROBLEM: Final = ("graph", "fabric_yaml")
Path = tuple[str | int, ...]


@dataclass(frozen=True)
class Case:
    """A result and what is true of its problem; `least_ii` None: no II works."""

    result: MapResult
    dfg: DFG
    fabric: Fabric
    least_ii: int | None


def ring(length: int) -> DFG:
    nodes = [{"id": number, "op": "add"} for number in range(length)]
    around = [{"src": n, "dst": (n + 1) % length, "operand": 0} for n in range(length)]
    around[-1]["distance"] = 1
    return from_json({"name": "ring", "nodes": nodes, "edges": around})


def cool(handle: ModelHandle) -> None:
    for node in (0, 1):
        handle.model.add(handle.on_pe(node, 0) == 1)
    handle.minimize(handle.hops())


@cache
def cases() -> dict[str, Case]:
    mesh, open_edge = arch.load("mesh-2x2"), arch.load("openedge-3x3")
    three = map_dfg(ring(3), mesh, workers=1)
    timeout = replace(
        three,
        status="timeout",
        ii=None,
        mapping=None,
        lower_bound=2,
        bounds=(),
        refuted=(Refutation(1, "the joint model"),),
    )
    given: Any = {"allowed": {n: frozenset({n % 2}) for n in range(3)}, "workers": 1}
    given["resident"] = {3: frozenset({("const", 4), ("live_in", "%b")})}
    results = {
        "optimal": (three, 3),
        "feasible": (map_dfg(ring(3), mesh, ii=5, workers=1), 3),
        "timeout": (timeout, 3),
        "asked": (map_dfg(ring(3), mesh, ii=2), 3),
        "nowhere": (map_dfg(ring(3), mesh, allowed={0: frozenset()}), None),
        "given": (map_dfg(ring(3), mesh, **given), 3),
        "hops": (map_dfg(accumulator(), mesh, workers=1, objective="hops"), 1),
        "moves": (map_dfg(ring(4), open_edge, workers=1, objective="registers"), 4),
        "added": (map_dfg(ring(3), mesh, workers=1, extend=cool), 3),
    }
    found = {}
    for name, (result, least) in results.items():
        assert result.subject is not None
        assert result.ii is None or result.ii >= (least or 0)
        assert result.status not in ("optimal", "infeasible") or result.lower_bound == (
            least or 513
        )
        found[name] = Case(result, result.subject.dfg, result.subject.fabric, least)
    return found


def leaves(value: object, path: Path = ()) -> Iterator[Path]:
    """Places of all that can be damaged: scalars, entries, and whole objects and lists."""
    if path:
        yield path
    items: Any = ()
    if isinstance(value, dict):
        items = value.items()
    elif isinstance(value, list):
        items = enumerate(value)
    for key, inner in items:
        yield from leaves(inner, (*path, key))


def damaged(document: Any, path: Path, draw: random.Random) -> Any:
    changed = copy.deepcopy(document)
    holder = changed
    for key in path[:-1]:
        holder = holder[key]
    key, old = path[-1], holder[path[-1]]
    choice = draw.randrange(8)
    if choice == 0:
        del holder[key]
    elif choice == 1 and isinstance(holder, list):
        holder.insert(draw.randrange(len(holder) + 1), copy.deepcopy(old))
    elif choice == 2 and isinstance(holder, list):
        draw.shuffle(holder)
    else:
        holder[key] = other_value(old, document, draw)
    return changed


def other_value(old: object, document: Any, draw: random.Random) -> object:
    if isinstance(old, bool):
        return not old
    if isinstance(old, int) and draw.random() < 0.8:
        return draw.choice((old - 1, old + 1, old + draw.randrange(-4, 5), 0, -1, 1, 513, 10**12))
    if isinstance(old, list) and draw.random() < 0.5:
        return old[:-1] if draw.random() < 0.5 else [*old, draw.randrange(4)]
    names = ("optimal", "feasible", "infeasible", "timeout", "reg", "link", "out", "hops", "length")
    bounds = ("RecMII", "ResMII", "stages", "banks", "register pressure", "placement", "island")
    if isinstance(old, str) and draw.random() < 0.8:
        return draw.choice((*names, *bounds, "registers", "added objective", "x"))
    path = draw.choice(list(leaves(document)))
    for key in path:
        document = document[key]
    return draw.choice((copy.deepcopy(document), None, 0, "", [], {}, True, 1.5))


def is_accepted(findings: tuple[Finding, ...]) -> bool:
    return all(finding.verdict != "wrong" for finding in findings)


def untrue(case: Case, read: MapResult, findings: tuple[Finding, ...]) -> Iterator[str]:
    """What a result that was accepted says falsely without a word that it is taken on trust."""
    trusted = "\n".join(finding.what for finding in findings if finding.verdict == "trusted")
    least = case.fabric.controller.contexts + 1 if case.least_ii is None else case.least_ii
    yield from (f"bound {bound}" for bound in read.bounds if bound.ii > least)
    for item in read.refuted:
        possible = least <= item.ii <= case.fabric.controller.contexts
        if possible and f"II {item.ii} refuted by" not in trusted:
            yield f"II {item.ii} is refuted"
    if read.lower_bound > least and f"the II is at least {read.lower_bound}" not in trusted:
        yield f"lower bound {read.lower_bound}"
    yield from untrue_status(read, least, trusted)
    yield from untrue_mapping(case, read, trusted)
    if read.constrained and "constraints were added" not in trusted:
        yield "constraints out of nothing"


def untrue_status(read: MapResult, least: int, trusted: str) -> Iterator[str]:
    if read.status == "optimal" and (read.ii != least or read.ii != read.lower_bound):
        yield f"optimal at {read.ii}"
    if read.status == "feasible" and (read.ii is None or read.ii <= read.lower_bound):
        yield f"feasible at {read.ii} with a lower bound of {read.lower_bound}"
    if (read.mapping is None) != (read.status in ("infeasible", "timeout")):
        yield f"{read.status} beside {read.mapping}"
    alone = all(f"II {item.ii} refuted" in trusted or item.ii < least for item in read.refuted)
    if read.status == "infeasible" and read.lower_bound < least and not (read.refuted and alone):
        yield "infeasible"


def untrue_mapping(case: Case, read: MapResult, trusted: str) -> Iterator[str]:
    if read.mapping is None:
        return
    if read.ii != read.mapping.ii:
        yield f"II {read.ii}"
    try:
        replay(case.dfg, case.fabric, read.mapping, 8)
    except Broken as broken:
        yield str(broken)
        return
    found = read.objective
    if found is None or (
        found.name.startswith("added") and f"{found.name}: {found.value}" in trusted
    ):
        return
    task = MapProblem(case.dfg, case.fabric)
    if found.value not in (None, measure(task, read.mapping, found.name)):
        yield f"objective {found}"
    if found.bound is not None and f"{found.last_issue} has less than {found.bound}" not in trusted:
        yield f"bound of {found}"
    if found.before is not None and f"first mapping found had {found.before}" not in trusted:
        yield f"first of {found}"


@pytest.mark.parametrize("name", NAMES)
def test_what_is_accepted_is_true_or_trusted(name: str) -> None:
    case, draw = cases()[name], random.Random(name)
    document = json.loads(json.dumps(case.result.to_json()))
    assert is_accepted(check_certificate(case.result, Subject(case.dfg, case.fabric, *given(case))))
    accepted = 0
    for _ in range(_MUTATIONS):
        changed, paths = document, []
        for _ in range(draw.choice((1, 1, 2, 3))):
            places = [path for path in leaves(changed) if path[0] not in _PROBLEM]
            paths.append(draw.choice(places))
            changed = damaged(changed, paths[-1], draw)
        read = read_or_refused(changed, case)
        if read is None:
            continue
        assert read.subject is not None
        findings = check_certificate(read, read.subject)
        if is_accepted(findings) and read.subject == case.result.subject:
            accepted += 1
            assert list(untrue(case, read, findings)) == [], (paths, changed)
    assert accepted > 0


def read_or_refused(document: Any, case: Case) -> MapResult | None:
    """What is refused is so by one message with place and way out."""
    refused: VividcError | None = None
    try:
        return mapping_from_json(document, case.dfg, case.fabric)
    except VividcError as error:
        refused = error
    assert str(refused.loc).startswith("mapping file: ")
    assert refused.hint == "write the mapping anew with `vividc map`"
    return None


def given(case: Case) -> tuple[Any, Any]:
    assert case.result.subject is not None
    return case.result.subject.allowed, case.result.subject.resident


def test_another_problem_is_another_statement() -> None:
    """A file is about the graph in it: what is accepted is true of that one."""
    for name in ("optimal", "feasible", "hops"):
        case, draw = cases()[name], random.Random(name)
        document = json.loads(json.dumps(case.result.to_json()))
        places = [path for path in leaves(document) if path[0] == "graph"]
        for _ in range(_OF_THE_PROBLEM):
            changed = damaged(document, draw.choice(places), draw)
            try:
                read = MapResult.from_json(changed)
            except VividcError:
                continue
            assert read.subject is not None
            if is_accepted(check_certificate(read, read.subject)) and read.mapping is not None:
                replay(read.subject.dfg, read.subject.fabric, read.mapping, 8)
                assert all(bound.ii <= read.mapping.ii for bound in read.bounds)
