"""Trees worth trying: other orders of a part's loops, and which of them may be jammed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from vividc.host import time_limit
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.schedule import Loop, Tree, schedule_of, statements_in

Path = tuple[int, ...]
"""Where a loop is in a tree: positions among children, from the root."""

_MOST_ORDERS = 10


def orders(tree: Loop, relations: Relations) -> list[Loop]:
    """Legal orders of the loops, the source's first: loops interchanged and fused."""
    found = [tree]
    work = [tree]
    while work and len(found) < _MOST_ORDERS:
        base = work.pop(0)
        for moved in _moves(base):
            time_limit.step("orders of loops were tried")
            if moved not in found and is_legal(moved, relations):
                found.append(moved)
                work.append(moved)
    return found


def is_legal(tree: Loop, relations: Relations) -> bool:
    """Whether a tree keeps the order of all dependences."""
    return relations.respects(schedule_of(tree, relations).get_map())


def _moves(tree: Loop) -> Iterator[Loop]:
    """Trees that differ by one fusion or interchange."""
    for path, loop in loops_in(tree):
        for position in range(len(loop.children) - 1):
            first, second = loop.children[position : position + 2]
            if isinstance(first, Loop) and isinstance(second, Loop):
                over = {**first.over, **second.over}
                fused = replace(first, over=over, children=(*first.children, *second.children))
                children = (
                    *loop.children[:position],
                    fused,
                    *loop.children[position + 2 :],
                )
                yield put(tree, path, replace(loop, children=children))
        if len(loop.children) == 1 and isinstance(loop.children[0], Loop):
            inner = loop.children[0]
            outer = replace(loop, children=inner.children)
            yield put(tree, path, replace(inner, children=(outer,)))


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


def has_masks(tree: Tree) -> bool:
    """Whether a loop of it is masked."""
    return any(loop.masked for _, loop in loops_in(tree))


def groups(tree: Loop, relations: Relations) -> list[tuple[Path, ...]]:
    """Loops to jam together: the outermost that may be, and one inside it, for each way in."""
    result: list[tuple[Path, ...]] = []
    taken: list[Path] = []
    for path, _ in loops_in(tree):
        if any(path[: len(other)] == other for other in taken):
            continue
        time_limit.step("loops to jam were looked for")
        if not is_legal(with_factors(tree, {path: 2}), relations):
            continue
        taken.append(path)
        result.append((path, *_below(tree, path, relations)))
    return result


def _below(tree: Loop, path: Path, relations: Relations) -> Iterator[Path]:
    inner = path
    while True:
        loops = [n for n, c in enumerate(at(tree, inner).children) if isinstance(c, Loop)]
        if len(loops) != 1:
            return
        inner = (*inner, loops[0])
        if is_legal(with_factors(tree, {path: 2, inner: 2}), relations):
            yield inner
            return


def describe(tree: Loop) -> str:
    """A tree in one line, its name: `i0*4[S1, i1[S2]]` of as many statements."""

    def text(node: Tree) -> str:
        if isinstance(node, str):
            return node
        inside = ", ".join(map(text, node.children))
        factor = f"*{node.factor}{'?' if node.masked else ''}" if node.factor > 1 else ""
        return f"{'/'.join(sorted(set(node.over.values())))}{factor}[{inside}]"

    return f"{text(tree)} of {len(set(statements_in(tree)))}"
