"""Dominators and natural loops of a kernel's control-flow graph."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import networkx as nx

from vividc.host import time_limit
from vividc.host.once import once_each
from vividc.ssa.ir import Function


@dataclass(frozen=True)
class Loop:
    """A natural loop: the blocks that reach a back edge to `header` without leaving through it.

    `exits` are its edges (exiting block, target outside), in block order.
    """

    header: str
    blocks: frozenset[str]
    latches: tuple[str, ...]
    exits: tuple[tuple[str, str], ...]


_MOST_PATHS: Final = 8
"""Control flows that are kept: of the last functions that were looked at."""


@dataclass(frozen=True, eq=False)
class _Paths:
    """The control flow of functions, which most passes leave as it is: names of blocks, each with
    those behind it. What follows from it is found out once for all these functions.
    """

    successors: Mapping[str, tuple[str, ...]]

    @property
    def entry(self) -> str:
        """The block that a function begins with."""
        return next(iter(self.successors))


@once_each
def _paths(function: Function) -> _Paths:
    time_limit.step("control flow was analysed")
    return _with_successors(tuple((b.name, b.branch.successors) for b in function.blocks))


@lru_cache(_MOST_PATHS)
def _with_successors(successors: tuple[tuple[str, tuple[str, ...]], ...]) -> _Paths:
    return _Paths(dict(successors))


def block_graph(function: Function) -> nx.DiGraph[str]:
    """Control flow between the blocks that can be reached from the entry."""
    return _block_graph(_paths(function))


@once_each
def _block_graph(paths: _Paths) -> nx.DiGraph[str]:
    graph: nx.DiGraph[str] = nx.DiGraph()
    graph.add_node(paths.entry)
    after = paths.successors
    graph.add_edges_from((name, target) for name in _met(paths) for target in after[name])
    return nx.freeze(graph)


def _met(paths: _Paths) -> Iterator[str]:
    """The blocks that can be reached, the newest that was met first."""
    after, work = paths.successors, [paths.entry]
    met = set(work)
    while work:
        name = work.pop()
        yield name
        for target in after[name]:
            if target not in met:
                met.add(target)
                work.append(target)


@once_each
def _reverse_postorder(paths: _Paths) -> tuple[str, ...]:
    """The blocks that can be reached, each before those behind it but along back edges."""
    after, entry = paths.successors, paths.entry
    met, order = {entry}, []
    work = [(entry, iter(after[entry]))]
    while work:
        name, targets = work[-1]
        target = next((one for one in targets if one not in met), None)
        if target is None:
            order.append(name)
            work.pop()
        else:
            met.add(target)
            work.append((target, iter(after[target])))
    return tuple(reversed(order))


def predecessors(function: Function) -> Mapping[str, tuple[str, ...]]:
    """The blocks that may come before each block, in block order, unreachable ones among them."""
    return _predecessors(_paths(function))


@once_each
def _predecessors(paths: _Paths) -> Mapping[str, tuple[str, ...]]:
    sources_of: dict[str, list[str]] = {name: [] for name in paths.successors}
    for name, targets in paths.successors.items():
        for target in dict.fromkeys(targets):
            sources_of[target].append(name)
    return {name: tuple(sources) for name, sources in sources_of.items()}


def immediate_dominators(function: Function) -> Mapping[str, str]:
    """Of each block that can be reached the nearest other one that dominates it; the entry's is
    itself (Cooper, Harvey and Kennedy 2001).
    """
    return _immediate_dominators(_paths(function))


@once_each
def _immediate_dominators(paths: _Paths) -> Mapping[str, str]:
    order, before = _reverse_postorder(paths), _predecessors(paths)
    place = {name: number for number, name in enumerate(order)}
    sources = [[place[s] for s in before[name] if s in place] for name in order]
    nearest = [0, *[-1] * (len(order) - 1)]
    changes = True
    while changes:
        changes = False
        for number in range(1, len(order)):
            found = -1
            for source in sources[number]:
                if nearest[source] >= 0:
                    found = source if found < 0 else _common(nearest, source, found)
            if nearest[number] != found:
                nearest[number], changes = found, True
    return {name: order[above] for name, above in zip(order, nearest, strict=True)}


def _common(nearest: Sequence[int], one: int, other: int) -> int:
    """The nearest block above both, by their places in reverse postorder."""
    while one != other:
        if one > other:
            one = nearest[one]
        else:
            other = nearest[other]
    return one


def dominators(function: Function) -> Mapping[str, frozenset[str]]:
    """The blocks that dominate each block that can be reached, itself included."""
    return _dominators(_paths(function))


@once_each
def _dominators(paths: _Paths) -> Mapping[str, frozenset[str]]:
    result: dict[str, frozenset[str]] = {}
    for name, above in _immediate_dominators(paths).items():
        result[name] = result.get(above, frozenset()) | {name}
    return result


@once_each
def _spans(paths: _Paths) -> Mapping[str, tuple[int, int]]:
    """Of each block that can be reached its place in a walk along the tree of dominators, and the
    first place behind all that it dominates: sets of these take a function of 800 blocks longer.
    """
    above = _immediate_dominators(paths)
    below = dict.fromkeys(above, 1)
    for name in reversed(tuple(above)):
        if name != paths.entry:
            below[above[name]] += below[name]
    spans = {paths.entry: (0, len(above))}
    free = {paths.entry: 1}
    for name, nearest in above.items():
        if name != paths.entry:
            first = free[nearest]
            spans[name] = first, first + below[name]
            free[name], free[nearest] = first + 1, first + below[name]
    return spans


def find_loops(function: Function) -> tuple[Loop, ...]:
    """All natural loops, innermost first (fewest blocks), then in block order."""
    return _loops(_paths(function))


@once_each
def _loops(paths: _Paths) -> tuple[Loop, ...]:
    spans = _spans(paths)
    latches: dict[str, dict[str, None]] = {}
    for name, targets in paths.successors.items():
        for target in targets if name in spans else ():
            if spans[target][0] <= spans[name][0] < spans[target][1]:
                latches.setdefault(target, {})[name] = None
    order = {name: index for index, name in enumerate(paths.successors)}
    loops = [_loop(paths, order, header, tuple(ends)) for header, ends in latches.items()]
    return tuple(sorted(loops, key=lambda loop: (len(loop.blocks), order[loop.header])))


@once_each
def pipelined_loops(function: Function) -> tuple[Loop, ...]:
    """The loops to modulo-schedule: those that contain no other, have an exit, and are not
    `sequential`.
    """
    every = find_loops(function)
    headers = frozenset(loop.header for loop in every)
    return tuple(
        loop
        for loop in every
        if loop.exits and loop.header not in function.sequential and len(headers & loop.blocks) == 1
    )


@once_each
def blocks_of_pipelined_loops(function: Function) -> frozenset[str]:
    """Names of the blocks of loops to modulo-schedule."""
    return frozenset(name for loop in pipelined_loops(function) for name in loop.blocks)


def _loop(paths: _Paths, order: Mapping[str, int], header: str, latches: tuple[str, ...]) -> Loop:
    """`order`: the place of each block."""
    sources, after = _predecessors(paths), paths.successors
    reached = _spans(paths)
    body = {header}
    work = [latch for latch in latches if latch != header]
    while work:
        name = work.pop()
        if name not in body and name in reached:
            body.add(name)
            work.extend(sources[name])
    exits = tuple(
        (name, target)
        for name in sorted(body, key=order.__getitem__)
        for target in dict.fromkeys(after[name])
        if target not in body
    )
    return Loop(header, frozenset(body), latches, exits)


def preheader_of(function: Function, loop: Loop) -> str:
    """The block that enters the loop."""
    return next(
        block.name
        for block in function.blocks
        if loop.header in block.branch.successors and block.name not in loop.blocks
    )


@dataclass(frozen=True)
class Flow:
    """A tree of dominators, the blocks in reverse postorder, and the blocks of the natural loop of
    each header, in that order of the headers.
    """

    entry: str
    order: tuple[str, ...]
    successors: Mapping[str, tuple[str, ...]]
    predecessors: Mapping[str, tuple[str, ...]]
    idom: Mapping[str, str]
    loops: Mapping[str, frozenset[str]]

    def dominates(self, a: str, b: str) -> bool:
        """Whether every path from the entry to `b` passes `a` (a block dominates itself)."""
        while b not in (a, self.entry):
            b = self.idom[b]
        return a == b

    def dominators(self, name: str) -> Iterator[str]:
        """`name`, its immediate dominator, and so on up to the entry."""
        yield name
        while name != self.entry:
            name = self.idom[name]
            yield name


@once_each
def flow_of(function: Function) -> Flow:
    """Dominators and loops of a function without unreachable blocks."""
    paths = _paths(function)
    order = _reverse_postorder(paths)
    bodies = {loop.header: loop.blocks for loop in _loops(paths)}
    loops = {name: bodies[name] for name in order if name in bodies}
    idom = _immediate_dominators(paths)
    return Flow(paths.entry, order, paths.successors, _predecessors(paths), idom, loops)
