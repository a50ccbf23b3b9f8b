"""Ordinary Python constructs, one tiny kernel each: against numba, and some on the machine."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import vividc
from tests.dfg.memory_trace import Trace
from tests.e2e.constructs import arrays, calls, control, numbers, tables, whole_arrays  # noqa: F401 - they register
from tests.e2e.constructs.registry import CONSTRUCTS, Construct
from tests.e2e.test_kernels import assert_close
from tests.marks import with_slow
from vividc import arch
from vividc.compiler.driver import lower
from vividc.dfg.interpret.interpreter import interpret
from vividc.sim.bind import bind, returned

pytestmark = pytest.mark.filterwarnings("ignore::vividc.VividcWarning")
SLOW = {
    "columns_mean_and_largest",
    "local_ones_and_full",
    "longest_row_of_flags",
    "normalised_rows",
    "outer_products_of_other_types",
    "product_of_matrices",
    "reductions_of_a_matrix",
    "sorted_copy_with_a_nan",
    "sorts_of_bytes_nothing_and_one",
    "sums_along_an_axis_that_outgrow_a_word",
    "sums_of_a_cube",
    "where_of_scalars_and_types",
    "where_rows_are_repeated",
}
"""Numba takes seconds for them; others make the same calls with less."""
MAPPED = {name: item for name, item in CONSTRUCTS.items() if item.mapped}


@pytest.mark.parametrize("name", with_slow(CONSTRUCTS, SLOW))
def test_a_construct_means_what_it_means_to_numba(name: str) -> None:
    construct = CONSTRUCTS[name]
    ours, theirs = construct.fresh(), construct.fresh()
    value = interpreted(construct, ours)
    assert_same((*ours, value), (*theirs, construct.kernel(*theirs)))


@pytest.mark.parametrize("name", MAPPED)
def test_a_construct_runs_on_the_machine(name: str) -> None:
    construct = CONSTRUCTS[name]
    program = vividc.compile(construct.kernel, time_limit_s=20.0, effort="fast")
    ours, theirs = construct.fresh(), construct.fresh()
    result = vividc.simulate(program, *ours)
    assert_same((*ours, result.value), (*theirs, construct.kernel(*theirs)))


def interpreted(construct: Construct, args: tuple[object, ...]) -> object:
    """Run the optimised graphs, before any mapping; arrays are updated in place."""
    kernel = lower(construct.kernel)
    launch = SimpleNamespace(
        pitches={},
        parallel=None,
        name=kernel.name,
        params=kernel.params,
        fabric=arch.load("vivid-tile"),
        banks={},
        locals=kernel.locals,
        stored_arrays=frozenset(),
    )
    bound = bind(launch, args, {})  # type: ignore[arg-type]
    memory = bound.memory.copy()
    trace = Trace(kernel)
    done = interpret(kernel, memory, bound.inputs, watch=trace)
    trace.demand_order()
    bound.copy_back(memory, frozenset(bound.arrays))
    if kernel.returns is None or done.value is None:
        return None
    return returned(kernel.returns, done.value)


def assert_same(ours: tuple[object, ...], theirs: tuple[object, ...]) -> None:
    """As `assert_close`; a returned value last, None if there is none."""
    assert (ours[-1] is None) == (theirs[-1] is None)
    keep = len(ours) - (ours[-1] is None)
    assert_close(ours[:keep], theirs[:keep])
    assert all(
        np.asarray(a).shape == np.asarray(b).shape for a, b in zip(ours, theirs, strict=True)
    )
