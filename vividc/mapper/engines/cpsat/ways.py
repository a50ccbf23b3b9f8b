"""Shared by the constraint families: where a word can be read or sent on, sums of literals."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Iterable, Iterator, Mapping
from typing import TypeVar

from ortools.sat.python.cp_model import CpModel, IntVar, LinearExpr

from vividc.mapper.engines.cpsat.problem import Prepared
from vividc.mapper.engines.cpsat.variables import Variables

Key = TypeVar("Key", bound=Hashable)


def supply(problem: Prepared, v: Variables, word: int, pe: int, time: int) -> list[IntVar]:
    """Literals that let the crossbar of PE `pe` send the word so that it is readable at `time`."""
    before = problem.wrap(time - 1)
    keys = ((word, link.id, before) for link in problem.fabric.links_to[pe])
    sources = [v.link[key] for key in keys if key in v.link]
    if (word, pe, before) in v.read:
        sources.append(v.read[word, pe, before])
    sources += _outputs(problem, v, word, pe, before)
    return [*sources, *results(problem, v, word, pe, time)]


def results(problem: Prepared, v: Variables, word: int, pe: int, time: int) -> list[IntVar]:
    """Literals that make the word the result of the FU of `pe` in the cycle before `time`: of its
    own operation, or of a move.
    """
    issued = (word, pe, problem.wrap(time - problem.latency[word]))
    literals = [v.start[issued]] if issued in v.start else []
    moved = (word, pe, problem.wrap(time - 1))
    return [*literals, v.move[moved]] if moved in v.move else literals


def readable(problem: Prepared, v: Variables, word: int, pe: int, time: int) -> list[IntVar]:
    """Literals that let an operation on PE `pe` read the word at `time`."""
    keys = ((word, link.id, time) for link in problem.fabric.links_to[pe])
    ways = [v.link[key] for key in keys if key in v.link]
    if (word, pe, time) in v.read:
        ways.append(v.read[word, pe, time])
    if problem.fabric.routing.open_outputs:
        return [*ways, *_outputs(problem, v, word, pe, time)]
    issued = (word, pe, problem.wrap(time - problem.latency[word]))
    return [*ways, v.start[issued]] if issued in v.start else ways


def _outputs(problem: Prepared, v: Variables, word: int, pe: int, time: int) -> Iterator[IntVar]:
    for seen in problem.fabric.outputs_seen_by[pe]:
        if (word, seen, time) in v.output:
            yield v.output[word, seen, time]


def grouped(pairs: Iterable[tuple[Key, IntVar]]) -> dict[Key, list[IntVar]]:
    """Literals by key, in order."""
    groups: dict[Key, list[IntVar]] = defaultdict(list)
    for key, literal in pairs:
        groups[key].append(literal)
    return groups


def at_most(model: CpModel, groups: Mapping[Key, list[IntVar]], capacity: int) -> None:
    """The sum of each group is at most `capacity`."""
    for literals in groups.values():
        if len(literals) <= capacity:
            continue
        if capacity == 1:
            model.add_at_most_one(literals)
        else:
            model.add(LinearExpr.sum(literals) <= capacity)
