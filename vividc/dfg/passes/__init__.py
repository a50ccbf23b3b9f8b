"""Passes from DFG to DFG; each returns the same object when nothing changes.

In order: `rewrite` (a graph being rewritten), `fold_constants` with `identities`, `min_max`,
`common_subexpressions`, `fused_sums`, `balance`, `contract_fma`, `fold_selects`, `dead_nodes`;
`pipeline` calls them, and `expand` between them.
"""

from vividc.dfg.passes.balance import balance_reductions
from vividc.dfg.passes.common_subexpressions import eliminate_common_subexpressions
from vividc.dfg.passes.contract_fma import contract_fma
from vividc.dfg.passes.dead_nodes import remove_dead_nodes
from vividc.dfg.passes.fold_constants import fold_constants
from vividc.dfg.passes.fold_selects import fold_selects
from vividc.dfg.passes.min_max import recognize_min_max

__all__ = [
    "balance_reductions",
    "contract_fma",
    "eliminate_common_subexpressions",
    "fold_constants",
    "fold_selects",
    "recognize_min_max",
    "remove_dead_nodes",
]
