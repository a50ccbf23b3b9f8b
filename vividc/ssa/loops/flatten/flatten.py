"""Flattening of loop nests: an outer loop and its only inner loop become one loop.

The back edge of the inner loop goes to the header of the outer one, which remembers whether it is
to go on with the inner loop or with the next outer iteration. What leads from the outer header to
the inner loop is run again in every iteration: it computes the same words again, since it depends
on the outer loop's phis, on what is fixed, and on loads that no store of the nest can change.
Stores there, and loads that a store might change, run in the first iteration only. Exact for every
nest: imperfect, triangular, with data-dependent bounds, no iterations, and exits from anywhere.

Literature: loop coalescing (Polychronopoulos 1987) for nests of counted loops, loop flattening
(von Hanxleden and Kennedy 1992) for any.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import takewhile

import networkx as nx

from vividc.errors import InternalError
from vividc.machine.opcodes import Opcode, Type
from vividc.ssa.analysis.distinct import mark_distinct
from vividc.ssa.edit import (
    block_of,
    fresh_name,
    incoming,
    next_id,
    redirect_edge,
    rename_incoming,
    with_blocks,
)
from vividc.ssa.flow import Loop, block_graph, dominators, find_loops, preheader_of
from vividc.ssa.ir import Block, Branch, Const, Function, Instr, Phi, Ref, Undefined, Value
from vividc.ssa.loops.flatten.indices import fold_indices, unfold_bases
from vividc.ssa.loops.flatten.rectangle import count_flattened, rectangle
from vividc.ssa.loops.flatten.rotate import can_rotate, rotate
from vividc.ssa.rewrite.normalize import canonical_loops
from vividc.ssa.rewrite.number_values import number_values
from vividc.ssa.rewrite.repair import repair
from vividc.ssa.rewrite.tidy import tidy


@dataclass(frozen=True, slots=True)
class Nest:
    """An outer loop and the only loop in it, which has none in it."""

    outer: Loop
    inner: Loop


def nest_at(function: Function, header: str) -> Nest | None:
    """The nest whose outer loop has this header, if it can be flattened; else None.

    Refused: no loop or several in the outer one, or one that is never left but by leaving the outer
    one too; loops that are `sequential`; an outer loop that never comes back.
    """
    loops = find_loops(function)
    outer = next((loop for loop in loops if loop.header == header), None)
    if outer is None or len(outer.latches) != 1:
        return None
    inside = [loop for loop in loops if loop is not outer and loop.header in outer.blocks]
    if len(inside) != 1 or len(inside[0].latches) != 1:
        return None
    inner = inside[0]
    if {outer.header, inner.header} & function.sequential or inner.header == outer.header:
        return None
    comes_back = any(target in outer.blocks for _, target in inner.exits)
    return Nest(outer, inner) if comes_back else None


def flatten(function: Function, header: str) -> Function | None:
    """The same function with the nest at `header` as one loop; None if there is no such nest.

    Apply it again for deeper nests, inside out.

    Parameters
    ----------
    header
        Header block of the outer loop. The new loop has the same header.
    """
    function = number_values(canonical_loops(function))
    nest = nest_at(function, header)
    unfolded = None if nest is None else unfold_bases(function, nest.outer)
    if nest is None or unfolded is None:
        return None
    function = _marked(unfolded, nest)
    function, counted = rectangle(function, nest.outer, nest.inner)
    function = rotate(function, nest.inner, nest.outer)
    nest = nest_at(function, header)
    assert nest is not None
    function = _with_back_block(function, nest.inner)
    nest = nest_at(function, header)
    assert nest is not None
    function, stays = _merge(function, nest)
    if counted is not None:
        function = count_flattened(function, nest.outer, nest.inner, counted)
    function = _guard(function, nest, stays)
    loop = next(loop for loop in find_loops(function) if loop.header == header)
    return tidy(fold_indices(number_values(function), loop))


def flattened_iterations(function: Function, header: str, trips: Mapping[str, float]) -> float:
    """Iterations of what `flatten` makes of the nest at `header`, per run of the nest.

    A rotated inner loop runs the code around it in its own iterations; else that takes one more.

    Parameters
    ----------
    trips
        Iterations of the outer loop per run, and of the inner one per outer iteration, by header.

    Raises
    ------
    InternalError
        If there is no nest to flatten.
    """
    function = canonical_loops(function)
    nest = nest_at(function, header)
    if nest is None:
        raise InternalError(f"there is no nest at {header}")
    inner = trips[nest.inner.header]
    own = max(inner, 1.0) if can_rotate(function, nest.inner) else inner + 1.0
    return trips[nest.outer.header] * own


def _marked(function: Function, nest: Nest) -> Function:
    stored = _stored(function, nest)
    replayed = set(_on_the_way(function, nest))

    def runs_once(name: str, instr: Instr) -> bool:
        return name not in replayed or _runs_once(instr, stored)

    return mark_distinct(function, nest.outer, nest.inner, runs_once)


def _stored(function: Function, nest: Nest) -> set[str]:
    """Arrays that the nest stores to."""
    return {
        instr.array
        for block in function.blocks
        if block.name in nest.outer.blocks
        for instr in block.instrs
        if instr.op is Opcode.STORE
    }


def _with_back_block(function: Function, inner: Loop) -> Function:
    """`function` with an empty block on the back edge of the inner loop."""
    name = fresh_name(function, f"{inner.header}.back")
    through = Block(name, (), (), Branch(inner.header))
    return redirect_edge(function, inner.latches[0], inner.header, through)


def _merge(function: Function, nest: Nest) -> tuple[Function, Ref]:
    """Leads the inner back edge to the outer header; the predicate says whether it was taken."""
    outer = block_of(function, nest.outer.header)
    inner = block_of(function, nest.inner.header)
    back = block_of(function, nest.inner.latches[0])
    before, enters = preheader_of(function, nest.outer), preheader_of(function, nest.inner)
    (latch,) = nest.outer.latches
    goes_on = _goes_on(function, nest)
    ends = ((latch, goes_on or Const(0)), (back.name, goes_on or Const(1)))
    stays = Phi(next_id(function), Type.PRED, ((before, Const(0)), *ends))
    kept = tuple(
        replace(phi, incoming=(*phi.incoming, (back.name, Ref(phi.id)))) for phi in outer.phis
    )
    carried, chosen = [], []
    for number, phi in enumerate(inner.phis):
        ahead = (back.name, incoming(phi, back.name))
        ident = stays.id + 1 + number
        undefined = ((before, Undefined()), (latch, Undefined()))
        carried.append(Phi(ident, phi.type, (*undefined, ahead), phi.loc))
        operands = (Ref(stays.id), Ref(ident), incoming(phi, enters))
        chosen.append(Instr(phi.id, Opcode.SELECT, phi.type, operands, loc=phi.loc))
    outer = replace(outer, phis=(*kept, stays, *carried))
    inner = replace(inner, phis=(), instrs=(*chosen, *inner.instrs))
    back = replace(back, branch=Branch(outer.name, loc=back.branch.loc))
    return with_blocks(function, (outer, inner, back)), Ref(stays.id)


def _goes_on(function: Function, nest: Nest) -> Value | None:
    """The condition on which every iteration of the outer loop branches to the inner back edge, if
    there is one.
    """
    (latch,) = nest.outer.latches
    (back,) = nest.inner.latches
    graph = block_graph(function)
    (test,) = graph.predecessors(back)
    branch = block_of(function, test).branch
    dominating = dominators(function)
    always = test in dominating[latch]
    return branch.cond if always and branch.target == back else None


def _guard(function: Function, nest: Nest, stays: Ref) -> Function:
    """Lets what may not be run again on the way to the inner loop run in first iterations only."""
    stored = _stored(function, nest)
    before = preheader_of(function, nest.outer)
    for name in _on_the_way(function, nest):
        rest = name
        while True:
            block = block_of(function, rest)
            starts = [n for n, i in enumerate(block.instrs) if _runs_once(i, stored)]
            if not starts:
                break
            once = _run_of(block.instrs[starts[0] :], stored)
            function, rest = _split(function, block, starts[0], once, stays)
            function = _carry(function, once, before)
    return function


def _run_of(instrs: tuple[Instr, ...], stored: set[str]) -> tuple[Instr, ...]:
    return tuple(takewhile(lambda instr: _runs_once(instr, stored), instrs))


def _on_the_way(function: Function, nest: Nest) -> tuple[str, ...]:
    """Blocks of the outer loop from which the inner one can be reached, in block order."""
    graph: nx.DiGraph[str] = nx.DiGraph()
    graph.add_node(nest.inner.header)
    for block in function.blocks:
        if block.name in nest.outer.blocks:
            targets = (t for t in block.branch.successors if t in nest.outer.blocks)
            graph.add_edges_from((block.name, t) for t in targets if t != nest.outer.header)
    before = nx.ancestors(graph, nest.inner.header)
    return tuple(block.name for block in function.blocks if block.name in before)


def _runs_once(instr: Instr, stored: set[str]) -> bool:
    return instr.op is Opcode.STORE or (instr.op is Opcode.LOAD and instr.array in stored)


def _split(
    function: Function, block: Block, start: int, guarded: tuple[Instr, ...], stays: Ref
) -> tuple[Function, str]:
    """Puts the instructions `guarded`, from `start` on, in a block of their own, which is skipped
    where `stays` is 1; returns the name of the block after it.
    """
    once = fresh_name(function, f"{block.name}.once")
    rest = fresh_name(function, f"{block.name}.rest")
    loc = block.branch.loc
    first = replace(block, instrs=block.instrs[:start], branch=Branch(rest, stays, once, loc=loc))
    middle = Block(once, (), guarded, Branch(rest, loc=loc))
    last = Block(rest, (), block.instrs[start + len(guarded) :], block.branch)
    changed = {first.name: first}
    for name in dict.fromkeys(block.branch.successors):
        target = changed.get(name) or block_of(function, name)
        phis = tuple(rename_incoming(phi, block.name, rest) for phi in target.phis)
        changed[name] = replace(target, phis=phis)
    return with_blocks(function, (*changed.values(), middle, last)), rest


def _carry(function: Function, once: tuple[Instr, ...], before: str) -> Function:
    """Keeps the words of loads that run once for the iterations that do not run them."""
    home = {i.id: block.name for block in function.blocks for i in block.instrs}
    for instr in once:
        if instr.op is Opcode.LOAD:
            definitions: dict[str, Value] = {home[instr.id]: Ref(instr.id)}
            definitions[before] = Undefined()
            function = repair(function, instr.id, instr.type, definitions)
    return function
