"""Sets and relations of a part, as isl has them."""

from __future__ import annotations

import islpy as isl

import vividc
from tests.ssa.polyhedral.test_generate import parts_of
from vividc.ssa.ir import is_dimension
from vividc.ssa.polyhedral.loops import loops_of
from vividc.ssa.polyhedral.orders.search import is_legal
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.scop import Scop
from vividc.ssa.polyhedral.trees import tree_of
from vividc.ssa.polyhedral.values import bounded
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

SIGNATURE = "void(int32[:, ::1], int32)"


@vividc.kernel(SIGNATURE)
def summed(a, n):
    """Each row takes the one before, up to the diagonal; then the first element of all."""
    for i in range(1, a.shape[0]):
        for j in range(i):
            a[i, j] += a[i - 1, j]
        a[0, 0] = n


@vividc.kernel("void(int32[::1], int32)")
def between(a, n):
    """The loop inside needs each word that is stored before it, and changes it."""
    for i in range(n):
        a[0] = i
        for j in range(4):
            a[j] += n


def part(kernel: vividc.KernelFunction = summed) -> tuple[Scop, Relations]:
    [scop] = parts_of(tidy(kernel.lower()))
    return scop, Relations(scop)


def test_what_is_known_of_symbols_holds_for_iterations() -> None:
    """A length is not negative."""
    scop, relations = part()
    for statement in scop.statements:
        domain = relations.domain(statement)
        assert domain.params().is_subset(relations.context)
        lengths = [name for name, value in scop.symbols.items() if is_dimension(value)]
        below = isl.Set(f"{relations.parameters} -> {{ : {lengths[0]} < 1 }}")
        assert domain.params().intersect(below).is_empty()


def test_iterations_lie_within_bounds() -> None:
    scop, relations = part()
    [inner] = [s for s in scop.statements if len(s.dims) > 1]
    lengths = [name for name, value in scop.symbols.items() if is_dimension(value)]
    text = f"{{ {inner.name}[i, j] : 1 <= i < {lengths[0]} and 0 <= j < i }}"
    wanted = isl.Set(f"{relations.parameters} -> {text}").intersect_params(relations.context)
    assert relations.domain(inner).is_equal(wanted)


def test_dependences_go_from_what_is_earlier() -> None:
    """From a row to the next below it, and among stores to one element from each to all later."""
    scop, relations = part()
    [inner] = [s for s in scop.statements if len(s.dims) > 1]
    [outer] = [s for s in scop.statements if len(s.dims) == 1 and s.accesses]
    wanted = isl.UnionMap(
        f"{relations.parameters} -> {{ {inner.name}[i, j] -> {inner.name}[i + 1, j] : j < i;"
        f" {outer.name}[i] -> {outer.name}[k] : i < k }}"
    )
    within = isl.UnionMap(
        f"{{ {inner.name}[i, j] -> {inner.name}[k, l]; {outer.name}[i] -> {outer.name}[k] }}"
    )
    every = relations.union({s.name: relations.domain(s) for s in scop.statements})
    wanted = wanted.intersect_domain(every).intersect_range(every)
    assert relations.dependences.intersect(within).is_equal(wanted)


def test_a_schedule_that_turns_a_loop_round_is_not_respected() -> None:
    scop, relations = part()
    written = relations.written
    assert relations.respects(written)
    images = [
        f"{s.name}[{', '.join(s.coordinates)}] -> [-{s.coordinates[0]}]" for s in scop.statements
    ]
    turned = isl.UnionMap(f"{relations.parameters} -> {{ {'; '.join(images)} }}")
    every = relations.union({s.name: relations.domain(s) for s in scop.statements})
    assert not relations.respects(turned.intersect_domain(every))
    met = relations.accesses_out_of_order(turned.intersect_domain(every))
    assert met is not None
    assert {access.array for access in met} == {"a"}


def test_dependences_that_are_left_out_follow_from_others() -> None:
    """Of a sum into one element, from one iteration to the next: not to every later one."""
    _, relations = part()
    few = isl.Set(f"{relations.parameters} -> {{ : {' = '.join((*relations.scop.symbols, '6'))} }}")
    direct, every = (
        one.intersect_params(few) for one in (relations.direct({}), relations.dependences)
    )
    assert direct.is_strict_subset(every)
    closure, known = direct, None
    while known is None or not closure.is_equal(known):
        known, closure = closure, closure.union(closure.apply_range(direct))
    assert every.is_subset(closure)


def test_what_no_schedule_gives_times_leaves_nothing_out() -> None:
    """Two iterations are in order for a third one between them only if that one has a time."""
    scop, relations = part(between)
    [outer] = [s for s in scop.statements if len(s.dims) == 1 and s.accesses]
    back = isl.UnionMap(f"{relations.parameters} -> {{ {outer.name}[i] -> [-i] }}")
    assert not relations.respects(back.intersect_domain(relations.domain(outer)))


def test_what_would_take_isl_too_long_is_not_known() -> None:
    """Trees are not legal and have no loops then."""
    scop, relations = part()
    tree = tree_of(scop)
    with bounded(10) as in_full:
        assert in_full
        assert not is_legal(tree, relations)
        assert isinstance(loops_of(tree, relations), Refusal)
        assert isl.DEFAULT_CONTEXT.get_max_operations() == 10
    assert isl.DEFAULT_CONTEXT.get_max_operations() == 0
    assert is_legal(tree, relations)
    assert not isinstance(loops_of(tree, relations), Refusal)
    assert not relations.endless


def test_after_two_endless_trees_isl_is_asked_no_more() -> None:
    scop, relations = part()
    relations.endless.update("ab")
    assert not is_legal(tree_of(scop), relations)
    assert isinstance(loops_of(tree_of(scop), relations), Refusal)
