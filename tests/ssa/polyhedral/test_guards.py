"""Guards as forms that are not negative, and groups whose missing iterations are masked."""

from __future__ import annotations

import pytest

import vividc
from tests.ssa.polyhedral.test_generate import parts_of
from vividc.machine.opcodes import Opcode
from vividc.ssa.flow import find_loops
from vividc.ssa.polyhedral import loops as loops_module
from vividc.ssa.polyhedral import schedule
from vividc.ssa.polyhedral.forms import Form, symbol
from vividc.ssa.polyhedral.generate import generate
from vividc.ssa.polyhedral.guards import ALWAYS, Guard, both, guard_of, implies, is_maskable, masked
from vividc.ssa.polyhedral.loops import (
    Code,
    For,
    If,
    Loops,
    Quotient,
    Run,
    expected_trips,
    iterations_of,
    loops_of,
)
from vividc.ssa.polyhedral.loops import Test as Comparison
from vividc.ssa.polyhedral.orders.search import loops_in, with_factors
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.trees import Loop, tree_of
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

X, Y = symbol("x"), symbol("y")


def least(form: Form, number: int) -> Guard:
    """The guard that a form is at least a number."""
    return frozenset((form.plus(Form((), -number)),))


@pytest.mark.parametrize(
    ("relation", "guard"),
    [
        (">=", least(X, 0)),
        (">", least(X, 1)),
        ("<=", least(X.times(-1), 0)),
        ("<", least(X.times(-1), 1)),
        ("==", least(X, 0) | least(X.times(-1), 0)),
        ("or", None),
    ],
)
def test_a_comparison_is_a_guard(relation: str, guard: Guard | None) -> None:
    assert guard_of(Comparison(relation, X)) == guard


def test_of_two_bounds_on_one_sum_the_sharper_stays() -> None:
    joined = guard_of(
        Comparison("and", parts=(Comparison(">=", X), Comparison(">", X), Comparison("<", Y)))
    )
    assert joined == least(X, 1) | least(Y.times(-1), 1)
    assert guard_of(Comparison("and", parts=(Comparison(">=", X), Comparison("or")))) is None


def test_a_guard_implies_what_is_weaker() -> None:
    narrow = both(least(X, 3), least(Y, 0))
    assert implies(narrow, least(X, 2))
    assert implies(narrow, ALWAYS)
    assert not implies(least(X, 2), least(X, 3))
    assert not implies(least(X, 3), narrow)


def test_branches_within_branches_are_masked_under_both_guards() -> None:
    one, other = Run("S0", ()), Run("S1", ())
    inner: Code = If(Comparison(">", X), (other,))
    nested = If(Comparison(">=", Y), (one, inner))
    assert is_maskable(nested)
    assert list(masked(nested)) == [(one, least(Y, 0)), (other, least(Y, 0) | least(X, 1))]
    assert not is_maskable(If(Comparison(">=", Y), (one,), (other,)))
    assert not is_maskable(If(Comparison(">=", Y), (For("c", (), (), 1, ()),)))


def test_a_last_group_counts_half_of_what_it_may_lack() -> None:
    loop = For("c", (Form(),), (symbol("n"),), 8, ())
    assert expected_trips(Loops((loop,)), {"n": 16.0}) == {"c": (16 + 3.5) / 8}
    assert expected_trips(Loops((loop,)), {"n": 0.0}) == {"c": 0.0}


@pytest.mark.parametrize(("limit", "trips"), [(24, 3.0), (25, 4.0), (31, 4.0), (1, 1.0), (0, 0.0)])
def test_a_last_group_of_a_known_length_counts_whole(limit: int, trips: float) -> None:
    loop = For("c", (Form(),), (Form((), limit),), 8, ())
    assert expected_trips(Loops((loop,)), {}) == {"c": trips}


@pytest.mark.parametrize(("before", "trips"), [(-4, 14.5), (-3, 14.5), (0, 14.5)])
def test_whole_groups_of_an_expected_length_are_as_many_however_isl_writes_it(
    before: int, trips: float
) -> None:
    """16 iterations from 1, less half of what a group of 4 may lack: up to a limit that lies so
    many before the end of the last whole group.
    """
    rest = Quotient(symbol("n").plus(Form((), 2)), 4, remainder=True)  # n ends at 18: 16 % 4
    limit = symbol("n").plus(symbol("q"), -1).plus(Form((), -1 if before == 0 else before))
    loops = Loops((For("c", (Form((), 1),), (limit,), 4, ()),), {"q": rest})
    assert expected_trips(loops, {"n": 18.0})["c"] == pytest.approx(trips / 4)


def test_iterations_of_tiles_stand_for_all_that_run_together() -> None:
    inner = For("k", (Form(),), (symbol("n"),), 1, ())
    columns = For("j", (Form(),), (symbol("n"),), 8, (If(Comparison(">", symbol("n")), (inner,)),))
    rows = For("i", (Form(),), (symbol("n"),), 4, (columns,))
    assert iterations_of((rows,)) == {"i": 4, "j": 32, "k": 32}


@pytest.mark.parametrize(
    ("test", "chance"),
    [
        (Comparison(">=", symbol("n").plus(Form((), -16))), 0.95),
        (Comparison(">", symbol("n").plus(Form((), -16))), 0.05),
        (Comparison("<", symbol("c").plus(symbol("n"), -1)), 0.95),
        (Comparison(">=", symbol("c").plus(Form((), -8))), 0.5),
        (Comparison("==", symbol("r")), 0.25),
    ],
)
def test_how_often_a_branch_is_taken(test: Comparison, chance: float) -> None:
    """0.05 at least, and 0.95 at most; c is spread over 0 to 16, r over 0 to 3."""
    branch = If(test, (Run("S", ()),), name="b")
    loop = For("c", (Form(),), (symbol("n"),), 1, (branch,))
    loops = Loops((loop,), {"r": Quotient(symbol("n"), 4, remainder=True)})
    assert expected_trips(loops, {"n": 16.0})["b"] == pytest.approx(chance, abs=0.05)


@vividc.kernel("void(float32[:, ::1], float32[::1], float32[::1])")
def sums(a, x, y):
    """A product of a matrix and a vector."""
    for i in range(a.shape[0]):
        y[i] = 0
        for j in range(a.shape[1]):
            y[i] += a[i, j] * x[j]


def test_sums_of_masked_rows_stay_in_registers() -> None:
    """One loop for all rows; loads of its own row and stores are predicated, but for the first."""
    [scop] = parts_of(tidy(sums.lower()))
    relations = Relations(scop)
    tree = with_factors(tree_of(scop), {(): 8}, masked=True)
    loops = loops_of(tree, relations)
    assert not isinstance(loops, Refusal)
    made = generate(scop, loops, masks=True)
    assert not isinstance(made, Refusal)
    function = tidy(made.function)
    found = find_loops(function)
    [inner] = [o for o in found if not any(p.header in o.blocks for p in found if p != o)]
    assert len(found) == 2
    inside = [i for b in function.blocks if b.name in inner.blocks for i in b.instrs]
    outside = [i for b in function.blocks if b.name not in inner.blocks for i in b.instrs]
    loads = [len(i.operands) for i in inside if i.op is Opcode.LOAD]
    stores = [len(i.operands) for i in outside if i.op is Opcode.STORE]
    assert sorted(loads) == [2] * 2 + [3] * 7
    assert not any(i.op is Opcode.STORE for i in inside)
    assert sorted(stores) == [3] + [4] * 7
    assert sum(i.op is Opcode.FMA for i in inside) + sum(i.op is Opcode.FADD for i in inside) == 8


@pytest.mark.parametrize(
    "factors",
    [(3, 1), (3, 2), (1, 4), (2, 2)],
)
def test_groups_are_written_out_as_isl_does(
    factors: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The others of a group follow from its first, and those behind a limit from those before."""
    for part in parts_of(tidy(sums.lower())) + parts_of(tidy(moved_on.lower())):
        paths = (path for path, _ in loops_in(tree_of(part)))
        given = {path: factor for path, factor in zip(paths, factors, strict=True) if factor > 1}
        tree = with_factors(tree_of(part), given, masked=True)
        made = loops_of(tree, Relations(part))
        with monkeypatch.context() as patch:
            patch.setattr(loops_module, "grouped_schedule_of", _ungrouped)
            assert loops_of(tree, Relations(part)) == made


def test_masked_groups_beside_full_ones_are_written_out_as_isl_does(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Where masked groups end does not depend on which of the rows are full."""
    [part] = parts_of(tidy(moved_on.lower()))
    rows = with_factors(tree_of(part), {(): 3})
    tree = with_factors(rows, {(0,): 2}, masked=True)
    relations = Relations(part)
    assert schedule.grouped_schedule_of(tree, relations)[1].marks
    made = loops_of(tree, relations)
    with monkeypatch.context() as patch:
        patch.setattr(loops_module, "grouped_schedule_of", _ungrouped)
        assert loops_of(tree, relations) == made


def test_isl_is_told_of_one_of_several_statements_with_the_same_iterations() -> None:
    """A row begins with two of them, and so does each element."""
    [part] = parts_of(tidy(sums.lower()))
    _, grouped = schedule.grouped_schedule_of(tree_of(part), Relations(part))
    assert {len(others) for others in grouped.twins.values()} == {1}
    assert not grouped.left.keys() & {one for others in grouped.twins.values() for one in others}


def _ungrouped(tree: Loop, relations: Relations) -> tuple[object, schedule.Grouped]:
    return schedule.schedule_of(tree, relations), schedule.Grouped()


@vividc.kernel("void(int32[:, ::1], int32[:, ::1], int32)")
def moved_on(a, b, n):
    """Bounds that begin at 1, and end before the last and at a number."""
    for i in range(1, a.shape[0] - 1):
        for j in range(1, n):
            a[i, j] = b[i - 1, j] + b[i + 1, j]


def test_the_iterations_of_masked_rows_are_in_each_other() -> None:
    [scop] = parts_of(tidy(moved_on.lower()))
    tree = with_factors(tree_of(scop), {(): 3}, masked=True)
    made = loops_of(tree, Relations(scop))
    assert isinstance(made, Loops)
    [rows] = made.code
    assert isinstance(rows, For)
    [elements] = rows.body
    assert isinstance(elements, For)
    first, second = elements.body
    assert isinstance(first, Run)
    assert isinstance(second, If)
    following, third = second.then
    assert isinstance(following, Run)
    assert isinstance(third, If)
    assert following.coordinates[0] == first.coordinates[0].plus(Form((), 1))
    assert third.test.left == second.test.left.plus(Form((), -1))
    assert third.name != second.name
