"""Kernels of many small nests, which take fewer contexts as flattened ones."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import vividc
from vividc import arch
from vividc.arch.fabric import Fabric
from vividc.compiler.driver import estimator_for
from vividc.compiler.planning.choose import choose
from vividc.compiler.planning.fit import fitted
from vividc.compiler.planning.options import LoopOptions
from vividc.compiler.planning.plan import Draft, Stage
from vividc.compiler.planning.state import State
from vividc.compiler.stage import CompileOptions
from vividc.frontend import KernelFunction
from vividc.ssa.rewrite.tidy import tidy

M = "int32[:, ::1]"


@vividc.kernel(f"void({M}, {M}, {M})")
def many(x: Any, y: Any, z: Any) -> None:
    """Each nest needs the one before it, in another order: none is part of another."""
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            y[i, j] = x[i, j] * 3
    for i in range(y.shape[0]):
        for j in range(y.shape[1]):
            z[i, j] = y[y.shape[0] - 1 - i, j] ^ x[i, j]
    for i in range(z.shape[0]):
        for j in range(z.shape[1]):
            x[i, j] += z[i, z.shape[1] - 1 - j]
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            y[i, j] -= x[x.shape[0] - 1 - i, j]


@vividc.kernel(f"void({M}, {M}, {M})")
def more(x: Any, y: Any, z: Any) -> None:
    """So many that not all are flattened at once."""
    y[:, :] = x * 3
    z[:, :] = y[::-1] ^ x
    x += z[:, ::-1]
    y -= x[::-1]
    z[:, :] = y[:, ::-1] ^ x
    x += z[::-1]
    y -= x[:, ::-1]
    z[:, :] = y[::-1] ^ x
    x += z[:, ::-1]
    y -= x[::-1]
    z[:, :] = y[:, ::-1] ^ x
    x += z[::-1]


def tile(contexts: int) -> Fabric:
    fabric = arch.load("vivid-tile")
    return replace(fabric, controller=replace(fabric.controller, contexts=contexts))


def taken(
    fabric: Fabric, kernel: KernelFunction = many, options: CompileOptions | None = None
) -> float:
    return estimator_for(fabric, options or CompileOptions()).estimate(kernel.lower(), {}).contexts


def test_a_kernel_beyond_the_contexts_has_its_nests_flattened() -> None:
    whole = arch.load("vivid-tile")
    as_written = int(taken(whole))
    fabric = tile(as_written - 1)
    with pytest.warns(vividc.VividcWarning, match=f"has {as_written - 1}: others are brought"):
        vividc.compile(many, fabric, loops=LoopOptions(auto=False))
    program = vividc.compile(many, fabric, loops=LoopOptions(restructure=False))
    assert len(program.words) < as_written
    kinds = {made.kind for loop in program.loops for made in loop.transforms if not made.reason}
    assert "flattening" in kinds
    arrays = [np.arange(30, dtype=np.int32).reshape(5, 6) * k for k in (1, 2, 3)]
    expected = [one.copy() for one in arrays]
    many(*expected)
    vividc.simulate(program, *arrays)
    assert all((mine == numbas).all() for mine, numbas in zip(arrays, expected, strict=True))


def test_before_the_first_stage_that_may_fit_are_some_that_take_fewer_contexts() -> None:
    held = CompileOptions(resident=True)  # what hardly ever runs counts, too
    fabric = tile(int(taken(arch.load("vivid-tile"), more, held)) - 20)
    estimator = estimator_for(fabric, held)
    function = tidy(more.lower())
    written = Stage(State(function, {}), estimator.estimate(function, {}))
    least, *_, first = fitted(Draft(estimator, LoopOptions(), [written], frozenset()), written)
    assert least.estimate.contexts < first.estimate.contexts <= fabric.controller.contexts
    assert first.estimate.cycles < least.estimate.cycles


def test_nests_that_the_user_wants_left_alone_stay() -> None:
    fabric = tile(int(taken(arch.load("vivid-tile"))) - 1)
    first = many.loc.line
    lines = range(first, first + 20)
    options = LoopOptions(restructure=False, flatten=dict.fromkeys(lines, False))
    plan = choose(many.lower(), estimator_for(fabric, CompileOptions()), options)
    assert not any(one.kind == "flattening" and not one.reason for one in plan.decisions)


def test_a_kernel_that_fits_is_left_to_what_pays() -> None:
    estimator = estimator_for(arch.load("vivid-tile"), CompileOptions())
    plan = choose(many.lower(), estimator, LoopOptions(restructure=False))
    first = plan.stages[0].estimate
    assert first.contexts <= 512
    assert all(
        one.after is None or one.after < one.before for one in plan.decisions if not one.reason
    )


def test_what_hardly_ever_runs_counts_where_the_memory_holds_all() -> None:
    """A tile of an accelerator; one by itself brings loops for broadcasting when it needs them."""
    whole = arch.load("vivid-tile")
    assert taken(whole, more) < taken(whole, more, CompileOptions(resident=True))


def test_no_form_is_looked_for_of_a_kernel_far_beyond_the_contexts() -> None:
    fabric = tile(int(taken(arch.load("vivid-tile"))) // 2)
    plan = choose(many.lower(), estimator_for(fabric, CompileOptions()), LoopOptions())
    assert len(plan.stages) == 1
    assert len(plan.decisions) == 4
    assert all("contexts, and there are" in decision.reason for decision in plan.decisions)
