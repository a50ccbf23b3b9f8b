"""What every loop transformation ends with: the function it leaves has no redundant work."""

from __future__ import annotations

from vividc.dfg.cfg import Function
from vividc.dfg.normalize import canonical_loops
from vividc.dfg.transform.combine_additions import combine_additions
from vividc.dfg.transform.hoist import hoist_invariants
from vividc.dfg.transform.number_values import number_values
from vividc.dfg.transform.simplify import remove_unused, simplify


def tidy(function: Function) -> Function:
    """Simplified, without common subexpressions, invariants hoisted, loops canonical."""
    function = canonical_loops(combine_additions(simplify(function)))
    return remove_unused(number_values(hoist_invariants(function)))
