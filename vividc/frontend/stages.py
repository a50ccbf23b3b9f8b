"""The stages on what was read from LLVM, in processing order: first to array accesses, then to
words.

`compiler.passes` lists them with those behind.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import wraps
from typing import Final

from vividc.errors import KernelError
from vividc.frontend.memory.arrays.local_arrays import OwnArray, keep_accessed, own_arrays
from vividc.frontend.memory.arrays.results import hold_results
from vividc.frontend.memory.flags import load_flags
from vividc.frontend.memory.null_choices import drop_null_choices
from vividc.frontend.memory.overlap import fold_overlaps
from vividc.frontend.memory.resolve import resolve_memory
from vividc.frontend.memory.subword import extend_loads, store_low_bits
from vividc.frontend.memory.traps import trap_raises
from vividc.frontend.narrow.floor_division import recover_divisions, sign_quotients
from vividc.frontend.narrow.narrow import refuse_calls
from vividc.frontend.narrow.single_trip import straighten_single_trips
from vividc.frontend.ranges.fold import fold_by_ranges, recover_extensions
from vividc.frontend.ranges.limits import clamp_limits
from vividc.host import time_limit
from vividc.host.watch import run_passes
from vividc.ssa.ir import Function
from vividc.ssa.loops.sizes.one_name import with_one_name
from vividc.ssa.rewrite.blocks import remove_unreachable_blocks
from vividc.ssa.rewrite.dead import remove_unused
from vividc.ssa.rewrite.hoist import hoist_invariants
from vividc.ssa.rewrite.number_values import merge_equal


@dataclass(frozen=True, slots=True)
class Pointers:
    """A function that has pointers yet.

    Attributes
    ----------
    text
        The module that it was read from, whose constant arrays become tables.
    packed
        As of `own_arrays`.
    arrays
        The function's own arrays by name, once they were found.
    """

    function: Function
    text: str
    packed: bool = False
    arrays: dict[str, OwnArray] = field(default_factory=dict)


def without_pointers(function: Function, text: str, *, packed: bool = False) -> Function:
    """A function of LLVM's with accesses of arrays instead of pointers; its own arrays are
    `locals`.

    Parameters
    ----------
    text
        The module it was read from.
    packed
        As of `own_arrays`.

    Raises
    ------
    KernelError
        The kernel calls what the array cannot run, never ends, or uses pointers other than into
        arrays.
    """
    made = run_passes(RESOLVING, Pointers(function, text, packed))
    own = tuple(held.array for held in made.arrays.values())
    return run_passes(STRAIGHTENING, replace(made.function, locals=own))


def _on_function(one: Callable[[Function], Function]) -> Callable[[Pointers], Pointers]:
    @wraps(one)
    def run(given: Pointers) -> Pointers:
        time_limit.step("it was lowered")
        return replace(given, function=one(given.function))

    return run


def find_arrays(given: Pointers) -> Pointers:
    """Make the kernel's own arrays inputs like others."""
    made = own_arrays(given.function, given.text, packed=given.packed)
    return replace(given, function=remove_unused(made.function), arrays=made.arrays)


def refuse_endless(function: Function) -> Function:
    """Refuse what cannot run: calls that the array does not have, and no way to end."""
    refuse_calls(function)
    if all(block.branch.successors for block in function.blocks):
        raise KernelError("the kernel never ends", hint="give its loop a condition or a break")
    return function


def resolve(given: Pointers) -> Pointers:
    """Give each access its array; no pointer is left."""
    return replace(given, function=resolve_memory(given.function, given.arrays))


def hold(given: Pointers) -> Pointers:
    """Describe the arrays and tuples that the kernel returns."""
    held = hold_results(given.function, given.arrays)
    return replace(given, function=held.function, arrays=held.arrays)


def trap(given: Pointers) -> Pointers:
    """Make accesses that the simulator reports of exceptions that numba's functions raise."""
    function, traps = trap_raises(given.function)
    return replace(given, function=function, arrays=given.arrays | traps)


RESOLVING: Final[tuple[Callable[[Pointers], Pointers], ...]] = (
    _on_function(remove_unreachable_blocks),
    _on_function(recover_divisions),
    _on_function(fold_overlaps),
    find_arrays,
    _on_function(refuse_endless),
    _on_function(drop_null_choices),
    resolve,
    trap,
    hold,
)
"""From pointers to accesses of arrays. Memory first: the stages behind know no pointers."""
STRAIGHTENING: Final[tuple[Callable[[Function], Function], ...]] = (
    recover_extensions,
    straighten_single_trips,
)
SIMPLIFYING: Final[tuple[Callable[[Function], Function], ...]] = (
    load_flags,
    extend_loads,
    store_low_bits,
    clamp_limits,
    fold_by_ranges,
    sign_quotients,
)
"""Without small integers in memory, and without what the ranges of values decide."""
TIDYING: Final[tuple[Callable[[Function], Function], ...]] = (
    keep_accessed,
    with_one_name,
    hoist_invariants,
    merge_equal,
)
"""On words."""
