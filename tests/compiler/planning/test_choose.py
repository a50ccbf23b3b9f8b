"""What is transformed, what is not, and what the user may ask for."""

from __future__ import annotations

import math

import numpy as np
import pytest

import vividc
from vividc import arch
from vividc.compiler.planning.choose import choose
from vividc.compiler.planning.estimate import Estimator
from vividc.compiler.planning.options import LoopOptions
from vividc.compiler.planning.plan import Plan, Stage
from vividc.dfg.pipeline import PassOptions
from vividc.errors import KernelError
from vividc.ssa.flow import find_loops

MACHINE = arch.load("vivid-tile")


@vividc.kernel("void(int32[::1], int32[::1])")
def windows(x, y):
    """Sums of three neighbours."""
    for i in range(len(x) - 2):
        total = np.int32(0)
        for k in range(3):
            total += x[i + k]
        y[i] = total


@vividc.kernel("void(float32[:, ::1], float32[::1], float32[::1])")
def product(a, x, y):
    """y = a @ x."""
    for i in range(a.shape[0]):
        total = np.float32(0.0)
        for j in range(a.shape[1]):
            total += a[i, j] * x[j]
        y[i] = total


@vividc.kernel("void(float32[::1])")
def running(x):
    """Prefix sums: a recurrence that no unrolling shortens."""
    for i in range(1, len(x)):
        x[i] += x[i - 1]


_PLANS: dict[tuple[int, str], Plan] = {}


def plan(kernel: vividc.KernelFunction, **given: object) -> Plan:
    """What is chosen, once."""
    key = id(kernel.lower()), repr(given)
    if key not in _PLANS:
        options = LoopOptions(**given)
        _PLANS[key] = choose(kernel.lower(), Estimator(MACHINE, PassOptions()), options)
    return _PLANS[key]


def chosen(kernel: vividc.KernelFunction, **given: object) -> list[tuple[str, int]]:
    return made(plan(kernel, **given).stages[-1])


def made(stage: Stage) -> list[tuple[str, int]]:
    """What made a stage, in order."""
    decisions = [one.decision for one in stage.lineage()]
    return [(item.kind, item.factor) for item in reversed(decisions) if item is not None]


def line_of(kernel: vividc.KernelFunction, text: str) -> int:
    with open(kernel.file, encoding="utf-8") as source:
        lines = source.read().splitlines()
    return next(n for n, line in enumerate(lines, 1) if n > kernel.line and text in line)


def test_short_constant_loops_are_unrolled() -> None:
    found = plan(windows)
    assert chosen(windows)[0] == ("full unrolling", 0)
    loops = [r for r in found.stages[1].estimate.regions if r.kind == "loop"]
    assert [loop.shape.ii for loop in loops] == [1]


def test_accumulations_of_rows_run_side_by_side() -> None:
    (kind, factor), *_ = chosen(product)
    assert kind in ("restructuring", "interleaving")
    assert factor >= 4
    asked = {line_of(product, "for i in"): 4}
    assert chosen(product, auto=False, jam=asked) == [("unroll-and-jam", 4)]


@vividc.kernel("void(int32[::1])")
def mixed(x):
    """More operations an element than a loop may have twice."""
    for i in range(len(x)):
        value, mixture = x[i], np.int32(0)
        for k in range(33):
            mixture ^= (value >> np.int32(k % 32)) * (value + np.int32(k))
        x[i] = mixture


def test_what_is_sure_to_be_too_large_is_not_unrolled_first() -> None:
    found = plan(mixed)
    assert made(found.stages[-1]) == [("full unrolling", 0)]
    tried = [one for one in found.decisions if one.kind == "unrolling" and not one.after]
    operations = found.stages[-1].estimate.largest_loop(16)
    assert tried
    assert tried[-1].reason == f"a loop would have {2 * operations} operations, more than 192"


@vividc.kernel("void(float32[:, ::1], float32[:, ::1], float32[:, ::1])")
def multiplied(c, a, b):
    """c += a @ b, with the rows of b innermost."""
    for i in range(c.shape[0]):
        for k in range(a.shape[1]):
            for j in range(c.shape[1]):
                c[i, j] += a[i, k] * b[k, j]


def test_a_nest_is_restructured_unless_that_is_ruled_out() -> None:
    assert "restructuring" not in [kind for kind, _ in chosen(multiplied, restructure=False)]
    stages = plan(multiplied).stages
    assert [kind for kind, _ in made(stages[-1])] == ["restructuring"]
    assert stages[-1].estimate.cycles < stages[0].estimate.cycles / 4


@vividc.kernel("int32(float32[:, ::1], float32[:, ::1], float32[:, ::1], float32)")
def repeated(c, a, b, enough):
    """c = a @ b, then b = c, until little changes."""
    change, times = np.float32(3e38), np.int32(0)
    while change > enough and times < 100:
        for i in range(c.shape[0]):
            for j in range(c.shape[1]):
                total = np.float32(0.0)
                for k in range(a.shape[1]):
                    total += a[i, k] * b[k, j]
                c[i, j] = total
        change = np.float32(0.0)
        for i in range(c.shape[0]):
            for j in range(c.shape[1]):
                change = max(change, abs(c[i, j] - b[i, j]))
                b[i, j] = c[i, j]
        times += 1
    return times


def test_nests_in_a_loop_that_is_not_counted_are_restructured() -> None:
    stages = plan(repeated).stages
    assert "restructuring" in [kind for kind, _ in made(stages[-1])]
    rng = np.random.default_rng(1)
    a = (rng.standard_normal((9, 9)) / 16).astype(np.float32)
    b = rng.standard_normal((9, 9)).astype(np.float32)
    ours, theirs = [[np.zeros_like(a), a, b.copy(), np.float32(1e-3)] for _ in range(2)]
    result = vividc.simulate(vividc.compile(repeated), *ours)
    written = vividc.compile(repeated, loops=vividc.LoopOptions(restructure=False))
    assert result.value == repeated(*theirs) > 1
    np.testing.assert_allclose(ours[2], theirs[2], rtol=1e-5, atol=1e-6)
    others = np.zeros_like(a), a, b.copy(), np.float32(1e-3)
    assert result.cycles < 0.8 * vividc.simulate(written, *others).cycles


@vividc.kernel("void(float32[:, ::1], float32[:, ::1])")
def refused_shapes(c, a):
    """A nest of each kind: for equal shapes, and for others, which are the exception."""
    if c.shape[0] == a.shape[0] and c.shape[1] == a.shape[1]:
        for i in range(1, c.shape[0] - 1):
            for j in range(c.shape[1]):
                c[i, j] = a[i - 1, j] + a[i, j] + a[i + 1, j]
    else:
        for i in range(1, min(c.shape[0], a.shape[0]) - 1):
            for j in range(min(c.shape[1], a.shape[1])):
                c[i, j] = a[i - 1, j] - a[i, j] - a[i + 1, j]


def test_a_nest_that_seldom_runs_is_left_alone() -> None:
    tried = [one for one in plan(refused_shapes).decisions if one.kind == "restructuring"]
    assert {one.loc.line for one in tried if one.loc and one.after is None} == {
        line_of(refused_shapes, "for i in range(1, min")
    }


def is_interleaved(stage: Stage) -> bool:
    decisions = [one.decision for one in stage.lineage()]
    return any(one is not None and one.kind == "interleaving" for one in decisions)


def test_what_pays_without_other_loops_is_planned_too_and_the_better_comes_last() -> None:
    for kernel in (product, multiplied):
        plain = plan(kernel, restructure=False).stages
        both = plan(kernel).stages
        kinds = {kind for stage in both for kind, _ in made(stage)}
        assert "restructuring" in kinds
        written = [stage for stage in plain if not is_interleaved(stage)]
        assert set(map(str, (stage.decision for stage in written))) <= set(
            map(str, (stage.decision for stage in both))
        )
        last = both[-1].estimate.cycles
        assert last == min(stage.estimate.cycles for stage in both) <= plain[-1].estimate.cycles


def test_tiles_fill_a_nest_of_known_sizes() -> None:
    """It is restructured before its constant loops are unrolled, and no rest is left behind."""
    sized = multiplied.sized({"c": (20, 25), "a": (20, 30), "b": (30, 25)})
    stages = plan(sized).stages
    decision = stages[-1].decision
    assert decision is not None
    assert decision.kind == "restructuring"
    assert decision.factor in (5, 10)
    assert len(find_loops(stages[-1].state.function)) == 3


@vividc.kernel("void(int32[:, ::1])")
def shortest(paths):
    """An iteration reads what the one before may have written, in the same row and column."""
    n = paths.shape[0]
    for k in range(n):
        for i in range(n):
            for j in range(n):
                paths[i, j] = min(paths[i, j], paths[i, k] + paths[k, j])


def test_rows_share_the_latency_of_a_recurrence_along_them() -> None:
    stages = plan(shortest).stages
    assert [kind for kind, _ in made(stages[-1])] == ["restructuring"]
    first, last = (stage.estimate.loop(stage.estimate.hottest) for stage in (stages[0], stages[-1]))
    assert first is not None
    assert last is not None
    assert last.shape.ii <= first.shape.ii
    assert last.shape.operations >= 4 * first.shape.operations
    assert stages[-1].estimate.cycles < stages[0].estimate.cycles / 2


@vividc.kernel("void(float32[:, ::1], float32[:, ::1])")
def layer_norm(x, y):
    for i in range(x.shape[0]):
        total = np.float32(0)
        for j in range(x.shape[1]):
            total += x[i, j]
        mean = total / np.float32(x.shape[1])
        squares = np.float32(0)
        for j in range(x.shape[1]):
            away = x[i, j] - mean
            squares += away * away
        scale = np.float32(1) / np.sqrt(squares / np.float32(x.shape[1]) + np.float32(1e-5))
        for j in range(x.shape[1]):
            y[i, j] = (x[i, j] - mean) * scale


def test_rows_with_several_reductions_run_side_by_side() -> None:
    """What may be too large for the stores of PEs has smaller forms in reserve."""
    first, *others = plan(layer_norm).stages
    kinds = [stage.decision.kind for stage in others if stage.decision is not None]
    assert kinds[-3:] == ["restructuring"] * 3
    others = others[-3:]
    sure, likely, _ = others
    assert [stage.reserve for stage in others] == [True, True, False]
    sizes = [stage.estimate.largest_straight for stage in others]
    assert sizes[0] <= 40 * 16 < sizes[1] <= 60 * 16 < sizes[2]
    assert 3 * sure.estimate.cycles < first.estimate.cycles
    assert 4 * likely.estimate.cycles < first.estimate.cycles


@vividc.kernel("void(float32[:, ::1], float32[:, ::1])")
def scaled_rows(x, y):
    """Rows over their lengths, then each element over a root."""
    for i in range(x.shape[0]):
        total = np.float32(0)
        for j in range(x.shape[1]):
            total += x[i, j] * x[i, j]
        scale = np.float32(1) / np.sqrt(total / np.float32(x.shape[1]) + np.float32(1e-5))
        for j in range(x.shape[1]):
            y[i, j] = x[i, j] * scale
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            y[i, j] /= np.sqrt(x[i, j])


@pytest.mark.slow
def test_large_straight_regions_are_no_reason_for_large_loops() -> None:
    stages = plan(scaled_rows).stages
    assert max(stage.estimate.largest_straight for stage in stages) > 500
    assert all(stage.estimate.largest_loop(16) <= 24 * 16 for stage in stages)


@vividc.kernel("void(float32[:, ::1], float32[::1], float32[:, ::1], float32[:, ::1])")
def centred_product(a, mean, b, c):
    """The means of a's columns, a small part of the work, then a product."""
    for j in range(a.shape[1]):
        mean[j] = np.float32(0)
        for i in range(a.shape[0]):
            mean[j] += a[i, j]
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            for k in range(a.shape[1]):
                c[i, j] += a[i, k] * b[k, j]


def test_a_nest_is_restructured_that_gains_of_its_own_cycles() -> None:
    """By all that the kernel takes as written, the means are nothing."""
    kinds = [kind for kind, _ in chosen(centred_product)]
    assert kinds.count("restructuring") == 2


@vividc.kernel("void(int32, float32[:, ::1])")
def smoothed(steps, a):
    """Each element from its neighbours, some of them new."""
    for _ in range(steps):
        for i in range(1, a.shape[0] - 1):
            for j in range(1, a.shape[1] - 1):
                a[i, j] = (a[i - 1, j + 1] + a[i, j - 1] + a[i, j] + a[i + 1, j]) / np.float32(4.0)


def test_rows_that_start_later_share_the_latency_of_a_recurrence() -> None:
    """A row needs the end of the one before: together they run if each is two elements behind."""
    stages = plan(smoothed).stages
    assert [kind for kind, _ in made(stages[-1])] == ["restructuring"]
    first, last = (stage.estimate.loop(stage.estimate.hottest) for stage in (stages[0], stages[-1]))
    assert first is not None
    assert last is not None
    assert last.shape.ii <= first.shape.ii
    assert stages[-1].estimate.cycles < stages[0].estimate.cycles / 2


def test_a_recurrence_is_left_alone() -> None:
    assert chosen(running) == []
    assert plan(running).stages[0].state.function is running.lower()


def test_nothing_is_chosen_without_transformations() -> None:
    assert chosen(windows, auto=False) == []


def test_the_user_decides_before_the_estimate() -> None:
    line = line_of(running, "for i in")
    assert chosen(running, auto=False, unroll={line: 4}) == [("unrolling", 4)]
    inner = line_of(windows, "for k in")
    assert chosen(windows, auto=False, unroll={inner: 4}) == [("full unrolling", 0)]
    assert ("full unrolling", 0) not in chosen(windows, unroll={inner: 1})


def test_a_line_without_a_loop_is_refused_with_those_that_have_one() -> None:
    with pytest.raises(KernelError, match="no loop starts on this line") as caught:
        plan(windows, unroll={2: 4})
    assert str(line_of(windows, "for k in")) in str(caught.value.hint)


def test_what_cannot_be_jammed_is_refused_with_the_reason() -> None:
    line = line_of(running, "for i in")
    with pytest.raises(KernelError, match="no loop is inside it"):
        plan(running, jam={line: 2})


@vividc.kernel("void(int32[::1], int32[::1])")
def whiles(x, y):
    """Loops whose lengths their conditions decide."""
    i = 0
    while i < len(x) and x[i] >= 0:
        k = x[i]
        while k > 1:
            k = k >> 1 if k & 1 == 0 else 3 * k + 1
            y[i] += 1
        while True:
            y[i] -= 2
            if y[i] < 3:
                break
        i += 1


def test_every_loop_that_is_reported_can_be_named() -> None:
    state = plan(whiles, auto=False).stages[0].state
    locs = (state.loc(loop.header) for loop in find_loops(state.function))
    lines = sorted({loc.line for loc in locs if loc is not None})
    assert [line_of(whiles, "while i"), line_of(whiles, "while k")] == lines[:2]
    assert len(lines) == 3
    for line in lines:
        chosen(whiles, unroll={line: 1})
        with pytest.raises(KernelError, match="unrolling by 2 is not possible here") as caught:
            plan(whiles, unroll={line: 2})
        assert f"test_choose.py:{line}: " in str(caught.value)


@vividc.kernel("void(float32[:, ::1], float32[::1])")
def density(features, out):
    """18 operations: 2 iterations have an II of 3, which may have no mapping, and 4 one of 5."""
    for i in range(features.shape[0]):
        out[i] = math.exp(features[i, 0])


def test_a_factor_that_is_little_better_is_kept_in_reserve() -> None:
    *_, spare, last = plan(density).stages
    assert (made(spare), spare.reserve) == ([("unrolling", 4)], True)
    assert (made(last), last.reserve) == ([("unrolling", 2)], False)
    assert spare.estimate.cycles < last.estimate.cycles
