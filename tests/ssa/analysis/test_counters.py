"""Counters of loops, and the words of a loop as functions of its iterations."""

from __future__ import annotations

from tests.rules import Case, cases
from tests.ssa.support import FUNCTIONS
from vividc.machine.words import signed
from vividc.ssa.analysis.counters import Counter, counter_of
from vividc.ssa.analysis.polynomial import ITERATION, LoopPolynomials, Polynomial, Polynomials
from vividc.ssa.flow import find_loops
from vividc.ssa.ir import Const, Function, Input, Ref, Value


@cases(__file__)
def test_rules(case: Case) -> None:
    FUNCTIONS.check(case, run)


def run(function: Function) -> str:
    """A line for each loop, and for each index of an access in it."""
    known = Polynomials(function)
    lines = [""]
    for loop in find_loops(function):
        lines.append(f"{loop.header}: {_counter_text(counter_of(function, loop))}")
        forms = LoopPolynomials(function, loop)
        for block in function.blocks:
            for instr in block.instrs if block.name in loop.blocks else ():
                if instr.array:
                    index = instr.operands[1]
                    lines.append(f"  {_text(known.of(index))} is {_text(forms.of(index))}")
    return "\n".join(lines)


def _counter_text(found: Counter | None) -> str:
    if found is None:
        return "no counter"
    ends = f"{_name(found.initial)} to {_name(found.limit)}"
    return f"%{found.phi.id} from {ends} by {found.step}"


def _text(form: Polynomial | None) -> str:
    if form is None:
        return "not affine"
    terms = ("*".join([str(c), *map(_name, monomial)]) for monomial, c in form.terms.items())
    return " + ".join(terms) or "0"


def _name(value: Value) -> str:
    if value == ITERATION:
        return "iteration"
    if isinstance(value, Const):
        return str(signed(value.word))
    assert isinstance(value, Ref | Input)
    return f"%{value.id}" if isinstance(value, Ref) else value.key
