"""Values that an index can have, as far as loops and conditions bound it."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS, loop_at, term_text
from vividc.machine.opcodes import Opcode
from vividc.ssa.ir import Function
from vividc.ssa.parallel.terms import TermTable


def run(function: Function) -> str:
    """A line for each store: its index, and the counters of the loops around it."""
    table = TermTable(function, 0)
    loop = loop_at(function, "b1")
    lines = [""]
    for block in function.blocks:
        for instr in block.instrs:
            if instr.op is Opcode.STORE:
                index = table.of(instr.operands[1], table.facts(block.name))
                counters = table.counters_around(block.name, loop)
                told = None if counters is None else [term_text(table.terms, c) for c in counters]
                lines.append(f"{block.name}: {term_text(table.terms, index)} counters {told}")
    return "\n".join(lines)


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run)
