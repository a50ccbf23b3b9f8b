"""The clean-up after every loop transformation: the resulting function has no redundant work."""

from __future__ import annotations

from vividc.ssa.ir import Function
from vividc.ssa.rewrite.combine_additions import combine_additions
from vividc.ssa.rewrite.dead import remove_unused
from vividc.ssa.rewrite.hoist import hoist_invariants
from vividc.ssa.rewrite.normalize import canonical_loops
from vividc.ssa.rewrite.number_values import number_values
from vividc.ssa.rewrite.simplify import simplify


def tidy(function: Function) -> Function:
    """Simplified, without common subexpressions, invariants hoisted, loops canonical."""
    function = canonical_loops(combine_additions(simplify(function)))
    return remove_unused(number_values(hoist_invariants(function)))
