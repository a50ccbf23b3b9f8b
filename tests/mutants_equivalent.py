"""Defects of `tests.mutants` that change nothing anybody could notice, each with its reason."""

from __future__ import annotations

from typing import Final

EQUIVALENT: Final[dict[tuple[str, str], str]] = {
    (
        "rewrite/repair",
        "_Repair._rewritten: replace(block, phis=()) -> replace(block)",
    ): "the phis are put in their place afterwards",
    (
        "rewrite/dead",
        "has_effect: ('store', Opcode.STORE) -> (Opcode.STORE, 'store')",
    ): "membership does not depend on the order",
    (
        "rewrite/combine_additions",
        "_sum: (Opcode.ADD, Opcode.SUB) -> (Opcode.SUB, Opcode.ADD)",
    ): "membership does not depend on the order",
    (
        "loops/flatten/rectangle",
        "count_flattened: (Ref(ident), Const(stride & 4294967295))"
        " -> (Const(stride & 4294967295), Ref(ident))",
    ): "a product does not depend on the order of its operands",
    (
        "loops/flatten/rectangle",
        "_counters: (second.limit, second.initial) -> (second.initial, second.limit)",
    ): "whether one of them varies does not depend on the order",
    (
        "rewrite/normalize",
        "_add_one_preheader: not is_entry and len(outside) == 1 -> len(outside) == 1",
    ): "nothing that is reached leads to a loop at the entry from outside",
    (
        "rewrite/clone",
        "_used_elsewhere: isinstance(v, Ref) and name not in inside -> isinstance(v, Ref)",
    ): "at the end of a block that was copied, a value is its own: there is nothing to repair",
    (
        "parallel/independent",
        "_Proof._extent: (0, masks[0]) -> (masks[0], 0)",
    ): "the least and the greatest of both ends are taken",
    (
        "parallel/products/effects",
        "_Reader._expression: not isinstance(item, Instr) or item.id not in self.homes"
        " -> item.id not in self.homes",
    ): "a value has a definition, and a phi is in no statement",
}
