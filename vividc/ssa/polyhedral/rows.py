"""Temporaries of which the iterations of a group have a row each.

An array that each iteration of a loop writes before it reads it hands nothing to the next one; only
its elements are the same. Iterations that run together use rows of their own: as many arrays as a
group has iterations (Feautrier, "Array expansion", 1988), used again by the next group (Lefebvre
and Feautrier, "Automatic storage management for parallel programs", 1998). Groups end where the
loop ends, and the last iteration of each uses the array itself: so it holds at the end what it
would.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from operator import eq

import islpy as isl

from vividc.machine.params import TRAP, LocalArray
from vividc.ssa.edit import first_free
from vividc.ssa.ir import Function
from vividc.ssa.polyhedral.forms import Form
from vividc.ssa.polyhedral.relations import Relations, Rows
from vividc.ssa.polyhedral.scop import Scop
from vividc.ssa.polyhedral.trees import Loop, Tree


def rows_of(tree: Tree) -> dict[str, Rows]:
    """The rows that the groups of a tree's loops have, by array."""
    if isinstance(tree, str):
        return {}
    found = {name: rows for child in tree.children for name, rows in rows_of(child).items()}
    if tree.factor > 1:
        found |= dict.fromkeys(tree.rows, Rows(tree.over, tree.factor, tree.base))
    return found


def with_own_rows(loop: Loop, relations: Relations) -> Loop | None:
    """The loop with rows of all temporaries that it may have any of; None if there are none."""
    limit = _limit(loop, relations.scop)
    if limit is None or loop.skew or relations.is_endless:
        return None
    with relations.asked(f"rows of {loop.over}"):
        arrays = frozenset(
            name
            for name in relations.scop.elements
            if _may_be_made(relations.scop.function, name)
            and _is_temporary(name, loop, relations)
            and _ends_in_last(name, loop, relations, limit)
        )
        return replace(loop, rows=arrays, base=limit) if arrays else None
    return None


def _limit(loop: Loop, scop: Scop) -> Form | None:
    """Where a loop ends, if that is the same for all statements and each time."""
    limits = {scop.dimension(name, over).bounds[1] for name, over in loop.over.items()}
    if len(limits) != 1:
        return None  # of a loop without statements, too
    limit = limits.pop()
    return limit if limit.names <= scop.symbols.keys() else None


def _is_temporary(array: str, loop: Loop, relations: Relations) -> bool:
    """Whether all reads of an array find what the same iteration of a loop has written."""
    reads, writes = relations.accesses(partial(eq, array))
    users = reads.domain().union(writes.domain())
    inside = relations.union(relations.domains(loop.over))
    if writes.is_empty() or not users.is_subset(inside):
        return False
    info = isl.UnionAccessInfo.from_sink(reads).set_must_source(writes)
    flow = info.set_schedule_map(relations.written).compute_flow()
    counted = relations.counted(loop.over, "{0}")
    same = counted.apply_range(counted.reverse())
    found = flow.get_must_dependence().is_subset(same)
    return bool(found and flow.get_must_no_source().is_empty())


def _ends_in_last(array: str, loop: Loop, relations: Relations, limit: Form) -> bool:
    """Whether the last iteration of a loop writes all that an array holds at the end."""
    for statement in relations.scop.statements:
        stores = [a for a in statement.accesses.values() if a.is_store and a.array == array]
        if len(stores) > 1:
            return False
    _, writes = relations.accesses(partial(eq, array))
    order = relations.written.lex_lt_union_map(relations.written)
    again = writes.apply_range(writes.reverse()).intersect(order).domain()
    last = relations.counted(loop.over, f"{{0}} - ({limit})").intersect_range(
        isl.UnionSet(f"{relations.parameters} -> {{ [-1] }}")
    )
    return bool(writes.domain().subtract(again).is_subset(last.domain()))


def _may_be_made(function: Function, array: str) -> bool:
    """Whether the size of an array is known at launch at the latest."""
    param = next((p for p in function.params if p.name == array), None)
    if param is not None:
        return not param.flat
    local = next((one for one in function.locals if one.name == array), None)
    return local is not None and local.contents is None and not array.startswith(TRAP)


def names_of_rows(function: Function, rows: Mapping[str, Rows]) -> dict[tuple[str, int], str]:
    """The array that each iteration of a group uses, by array and place in the group."""
    taken = {param.name for param in function.params}
    taken |= {local.name for local in function.locals}
    found = {}
    for array, one in rows.items():
        for place in range(one.factor - 1):
            found[array, place] = first_free(taken, f"{array}.row{place}")
            taken.add(found[array, place])
        found[array, one.factor - 1] = array
    return found


def arrays_of_rows(
    function: Function, names: Mapping[tuple[str, int], str]
) -> Iterator[LocalArray]:
    """The arrays to be made for rows."""
    params = {param.name: param for param in function.params}
    locals_ = {local.name: local for local in function.locals}
    for (array, _), name in names.items():
        if name == array:
            continue
        if array in locals_:
            yield replace(locals_[array], name=name)
            continue
        size: tuple[str | int, ...] = (1,)
        for axis in range(params[array].ndim):
            size += (f"u:{array}.shape{axis}", "*")
        yield LocalArray(name, 0, size=size)
