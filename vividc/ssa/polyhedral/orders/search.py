"""Trees worth trying: other orders of a part's loops, and which of them may be jammed."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import replace

from vividc.host import time_limit
from vividc.ssa.polyhedral.forms import ZERO, Form, symbol
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.rows import rows_of, with_own_rows
from vividc.ssa.polyhedral.schedule import schedule_of
from vividc.ssa.polyhedral.scop import Scop
from vividc.ssa.polyhedral.trees import Loop, Tree, is_bound_to, statements_in

Path = tuple[int, ...]
"""Where a loop is in a tree: positions among children, from the root."""

_MOST_ORDERS = 10

_SKEWS = (1, 2)
"""Iterations by which a loop starts later: a stencil of three rows needs 2 (its last neighbour)."""


def orders(tree: Loop, relations: Relations) -> list[Loop]:
    """Orders of the loops, the source's first: loops interchanged and fused. Those along diagonals
    and with loops that start later are legal as they are, or only with iterations run together.
    """
    found = [tree]
    work = [tree]
    while work and len(found) < _MOST_ORDERS:
        base = work.pop(0)
        for moved in moves(base, relations.scop):
            time_limit.step("orders of loops were tried")
            if moved not in found and is_legal(moved, relations):
                found.append(moved)
                work.append(moved)
    level = [base for base in found if not _has_rows(base, relations)]
    diagonal = (fronts(base, relations.scop) for base in level)
    first = (next((one for one in some if _has_rows(one, relations)), None) for some in diagonal)
    later = (one for base in level for one in skewed(base) if _has_rows(one, relations))
    return [*found, *(one for one in first if one is not None), *later]


def interchanged(loop: Loop) -> Iterator[Loop]:
    """A loop and the only one in it, the other way round."""
    inner = _only_loop(loop)
    if inner is not None:
        yield replace(inner, children=(replace(loop, children=inner.children),))


def _has_rows(tree: Loop, relations: Relations) -> bool:
    """Whether a loop around another one may be jammed."""
    holding = (path for path, loop in loops_in(tree) if _depth(loop.children))
    return any(_rows(tree, path, relations) for path in holding)


def is_legal(tree: Loop, relations: Relations) -> bool:
    """Whether a tree is known to keep the order of all dependences."""
    rows = rows_of(tree)
    known, name = relations.legal, f"{describe(tree)} {rows}"
    if name not in known and not relations.is_endless:
        with relations.asked(name):
            known[name] = relations.respects(schedule_of(tree, relations).get_map(), rows)
    return known.get(name, False)


def moves(tree: Loop, scop: Scop) -> Iterator[Loop]:
    """Trees that differ by one fusion, interchange, or loop that takes in what follows it."""
    for path, loop in loops_in(tree):
        for changed in (*fused(loop), *_taken_in(loop, scop)):
            yield put(tree, path, changed)
        for changed in interchanged(loop):
            yield put(tree, path, changed)


def fused(loop: Loop) -> Iterator[Loop]:
    """Loops inside, one and the next after it, as one at the place of the first: those inside them
    too, or one after the other.
    """
    places = [n for n, child in enumerate(loop.children) if isinstance(child, Loop)]
    for one, other in itertools.pairwise(places):
        first, second = loop.children[one], loop.children[other]
        assert isinstance(first, Loop)
        assert isinstance(second, Loop)
        over = {**first.over, **second.over}
        together = (*first.children, *second.children)
        merged = _merged(first.children, second.children)
        between, behind = loop.children[one + 1 : other], loop.children[other + 1 :]
        for children in (merged, together)[: 1 + (merged != together)]:
            fused = replace(first, over=over, children=children)
            yield replace(loop, children=(*loop.children[:one], fused, *between, *behind))


def _merged(first: tuple[Tree, ...], second: tuple[Tree, ...]) -> tuple[Tree, ...]:
    """Two sequences as one: if each has one loop, these as one, statements before and after."""
    loops = [[n for n, c in enumerate(part) if isinstance(c, Loop)] for part in (first, second)]
    if any(len(places) != 1 for places in loops):
        return (*first, *second)
    [[one], [other]] = loops
    left, right = first[one], second[other]
    assert isinstance(left, Loop)
    assert isinstance(right, Loop)
    inside = _merged(left.children, right.children)
    fused = replace(left, over={**left.over, **right.over}, children=inside)
    return (*first[:one], *second[:other], fused, *first[one + 1 :], *second[other + 1 :])


def _taken_in(loop: Loop, scop: Scop) -> Iterator[Loop]:
    """What follows a loop that ends where the counter around it is, as its last iteration: `for j
    in range(i): ...` and then the same for element i (cholesky).
    """
    for position, child in enumerate(loop.children[:-1]):
        behind = loop.children[position + 1 :]
        if not isinstance(child, Loop) or _depth(behind) != _depth(child.children):
            continue
        limits = {scop.dimension(name, child.over[name]).bounds[1] for name in child.over}
        if _depth(behind) and limits == {symbol(loop.over[name]) for name in child.over}:
            over = {name: loop.over[name] for one in behind for name in statements_in(one)}
            children = _merged(child.children, behind)
            longer = replace(child, over={**child.over, **over}, children=children)
            yield replace(loop, children=(*loop.children[:position], longer))


def _depth(children: tuple[Tree, ...]) -> int:
    """How many loops are in each other."""
    return max((1 + _depth(c.children) for c in children if isinstance(c, Loop)), default=0)


def skewed(tree: Loop, _: Scop | None = None) -> Iterator[Loop]:
    """Trees in which the loops in one loop start later in each of its iterations."""
    for path, loop in loops_in(tree):
        if not any(isinstance(child, Loop) for child in loop.children):
            continue
        yield from (put(tree, path, tiled) for tiled in _skewed_twice(loop))
        for factor in _SKEWS:
            children = tuple(
                replace(child, skew={n: symbol(loop.over[n]).times(factor) for n in child.over})
                if isinstance(child, Loop)
                else child
                for child in loop.children
            )
            yield put(tree, path, replace(loop, children=children))


def _skewed_twice(loop: Loop) -> Iterator[Loop]:
    """A loop in which the only loop in it starts one iteration later each time, and the only one in
    that some later for each iteration of both: tiles of the two are points of one front, as of
    stencils in place, whose points need those around them, of this step or the last.
    """
    inner = _only_loop(loop)
    last = None if inner is None else _only_loop(inner)
    if inner is None or last is None:
        return
    later = replace(inner, skew={n: symbol(loop.over[n]) for n in inner.over})
    for factor in _SKEWS:
        skew = {
            n: symbol(inner.over[n]).plus(symbol(loop.over[n]), 2).times(factor) for n in last.over
        }
        children = (replace(later, children=(replace(last, skew=skew),)),)
        yield replace(loop, children=children)


def _only_loop(loop: Loop) -> Loop | None:
    """What a loop has in it, if that is a loop."""
    child = loop.children[0] if len(loop.children) == 1 else None
    return child if isinstance(child, Loop) else None


def fronts(tree: Loop, scop: Scop) -> Iterator[Loop]:
    """Trees in which a loop and the only one in it go along diagonals, the inner one's counter
    first; loops inside start so that all iterations on a diagonal run them equally if they may.
    """
    for path, loop in loops_in(tree):
        inner = _only_loop(loop)
        if inner is None:
            continue
        for factor in _SKEWS:
            skew = {n: symbol(loop.over[n]).times(factor) for n in inner.over}
            first = replace(inner, children=(), skew=skew)
            around = (first, replace(loop, children=()))
            children = tuple(
                _level_with(child, around, scop) if isinstance(child, Loop) else child
                for child in inner.children
            )
            yield put(tree, path, replace(first, children=(replace(loop, children=children),)))


def _level_with(tree: Loop, around: tuple[Loop, ...], scop: Scop) -> Loop:
    """A loop that starts so that its bounds do not change with the one around it, if it may."""
    outer = around[-1]
    for factor in (0, *_SKEWS, *(-one for one in _SKEWS)):
        skew = {n: symbol(outer.over[n]).times(factor) for n in tree.over}
        moved = replace(tree, skew=skew if factor else {})
        if not any(is_bound_to(moved, outer, n, around, scop) for n in tree.over):
            return moved
    return tree


def loops_in(tree: Tree, path: Path = ()) -> Iterator[tuple[Path, Loop]]:
    """All loops of a tree with their places, outermost first."""
    if isinstance(tree, Loop):
        yield path, tree
        for position, child in enumerate(tree.children):
            yield from loops_in(child, (*path, position))


def at(tree: Tree, path: Path) -> Loop:
    """The loop at a place."""
    for position in path:
        assert isinstance(tree, Loop)
        tree = tree.children[position]
    assert isinstance(tree, Loop)
    return tree


def put(tree: Loop, path: Path, loop: Loop) -> Loop:
    """The tree with another loop at a place."""
    if not path:
        return loop
    child = tree.children[path[0]]
    assert isinstance(child, Loop)
    children = list(tree.children)
    children[path[0]] = put(child, path[1:], loop)
    return replace(tree, children=tuple(children))


def with_factors(tree: Loop, factors: Mapping[Path, int], *, masked: bool = False) -> Loop:
    """The tree with factors of loops."""
    for path, factor in factors.items():
        tree = put(tree, path, replace(at(tree, path), factor=factor, masked=masked))
    return tree


def with_factors_of(tree: Loop, other: Loop) -> list[Loop]:
    """The tree with the factors and masks of another order of the same statements: of loops over
    the same coordinates, and of loops in the same places; as far as it has such loops.
    """
    theirs = [loop for _, loop in loops_in(other)]
    own = list(loops_in(tree))
    by_name = {frozenset(loop.over.items()): loop for loop in theirs}
    named = [(path, by_name.get(frozenset(loop.over.items()))) for path, loop in own]
    placed = [(path, loop) for (path, _), loop in zip(own, theirs, strict=False)]
    found: dict[str, Loop] = {}
    for pairs in (named, placed):
        made = tree
        for path, loop in pairs:
            if loop is not None:
                made = with_factors(made, {path: loop.factor}, masked=loop.masked)
        found[describe(made)] = made
    return list(found.values())


def has_skews(tree: Tree) -> bool:
    """Whether a loop of it is skewed."""
    return any(loop.skew for _, loop in loops_in(tree))


def _are_tiles(tree: Tree) -> bool:
    """Whether a loop of it is skewed by two."""
    skews = (skew for _, loop in loops_in(tree) for skew in loop.skew.values())
    return any(len(skew.terms) > 1 for skew in skews)


def has_masks(tree: Tree) -> bool:
    """Whether a loop of it is masked."""
    return any(loop.masked for _, loop in loops_in(tree))


def groups(tree: Loop, relations: Relations) -> tuple[Loop, list[tuple[Path, ...]]]:
    """Loops to jam together: the outermost that may be, and one inside it, for each way in; and the
    tree, in which the groups of some loops run in order, if they may not otherwise.
    """
    result: list[tuple[Path, ...]] = []
    for path, loop in loops_in(tree):
        is_inside = any(path[: len(group[0])] == group[0] for group in result)
        if is_inside or _runs_once(loop, relations.scop):
            continue
        time_limit.step("loops to jam were looked for")
        rows = _rows(tree, path, relations)
        if rows is None:
            continue
        tree, trees = rows
        if has_skews(tree) and not _are_tiles(tree):
            trees = trees[:0]  # rows alone: what is left over of two would be long
        found = ((t, way) for t, way in trees if may_jam(t, (path, way), relations))
        tree, *inner = next(found, (tree,))
        result.append((path, *inner))
    return tree, result


def _runs_once(loop: Loop, scop: Scop) -> bool:
    """Whether a loop is known to have one iteration."""
    bounds = (scop.dimension(name, over).bounds for name, over in loop.over.items())
    return all(limit == first.plus(Form(constant=1)) for first, limit in bounds)


def _rows(
    tree: Loop, path: Path, relations: Relations
) -> tuple[Loop, list[tuple[Loop, Path]]] | None:
    """The tree in which a loop may be jammed, with groups in order if it may not otherwise, and
    trees with a loop inside that may be worth jamming with it; None if it may not be.
    """
    ways = list(_ways_in(tree, path))
    if may_jam(tree, (path,), relations):
        return tree, [(t, way) for way in ways for t in (tree, _in_order(tree, way))]
    for way in (*reversed(ways), path):
        ordered = _in_order(tree, way)
        if _depth(at(tree, way).children) and may_jam(ordered, (path,), relations):
            return ordered, [(ordered, w) for w in reversed(ways) if len(w) <= len(way)]
    return None


def groups_with_rows(
    tree: Loop, relations: Relations
) -> Iterator[tuple[Loop, list[tuple[Path, ...]]]]:
    """As `groups`, for each loop that may be jammed only if temporaries have rows: it and a loop
    inside it with loops in it, if there is one, and the others inside it.
    """
    if has_skews(tree):
        return
    for path, loop in loops_in(tree):
        time_limit.step("temporaries were looked for")
        made = with_own_rows(loop, relations)
        if made is None or may_jam(tree, (path,), relations):
            continue
        given = put(tree, path, made)
        if not may_jam(given, (path,), relations):
            continue
        inside = [
            (bool(_depth(inner.children)), below)
            for below, inner in loops_in(loop, path)
            if below != path and may_jam(given, (path, below), relations)
        ]
        inside.sort(key=lambda one: not one[0])
        taken = [below for _, below in inside[:1]]
        with_it = tuple(taken)
        for _, below in inside[1:]:
            if not any(_is_around(one, below) or _is_around(below, one) for one in taken):
                taken.append(below)
        yield given, [(path, *with_it), *((one,) for one in taken[1:])]


def _is_around(path: Path, other: Path) -> bool:
    """Whether a loop is around another one."""
    return other[: len(path)] == path


def _ways_in(tree: Tree, path: Path) -> Iterator[Path]:
    """The loops inside a loop, as long as one alone is in another."""
    while True:
        loops = [n for n, c in enumerate(at(tree, path).children) if isinstance(c, Loop)]
        if len(loops) != 1:
            return
        path = (*path, loops[0])
        yield path


def may_jam(tree: Loop, paths: tuple[Path, ...], relations: Relations) -> bool:
    """Whether pairs of iterations of these loops may run together."""
    return is_legal(with_factors(tree, dict.fromkeys(paths, 2)), relations)


def _in_order(tree: Loop, path: Path) -> Loop:
    """The tree with the groups of a loop, and of those around it, in order."""
    return put(tree, path, replace(at(tree, path), in_order=True))


def describe(tree: Loop) -> str:
    """A tree in one line, its name: `i0*4[S1, i1[S2]]` of as many statements."""

    def text(node: Tree) -> str:
        if isinstance(node, str):
            return node
        inside = ", ".join(map(text, node.children))
        factor = f"*{node.factor}{'?' if node.masked else ''}" if node.factor > 1 else ""
        order = " in order" if node.in_order else ""
        names = {name + "".join(_skew(node, s)) for s, name in node.over.items()}
        own = f" rows of {'/'.join(sorted(node.rows))} " if node.rows else ""
        return f"{'/'.join(sorted(names))}{factor}{order}{own}[{inside}]"

    def _skew(node: Loop, statement: str) -> Iterator[str]:
        for name, factor in node.skew.get(statement, ZERO).terms:
            yield f"+{factor}{name}"

    return f"{text(tree)} of {len(set(statements_in(tree)))}"
