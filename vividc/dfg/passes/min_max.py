"""Recognition of minima and maxima written as a select of a comparison."""

from __future__ import annotations

from typing import Final

from vividc.dfg.ir import DFG, Node
from vividc.dfg.passes.rewrite import Rewrite, Value, change_operation, to_fixpoint
from vividc.machine.compare import is_comparison
from vividc.machine.opcodes import Opcode
from vividc.machine.semantics import SEMANTICS
from vividc.machine.words import CANONICAL_NAN, INFINITY, INT_MAX, SIGN_BIT, WORD_MASK

_SIGNED_COMPARISONS: Final = (Opcode.ICMP_SLT, Opcode.ICMP_SLE)


def recognize_min_max(dfg: DFG) -> DFG:
    """Turn `select(a < b, a, b)` and its variants into `smin`, `smax`, `fmin` or `fmax`.

    Floats only where one side is a constant and the result is the same for every other side, NaN
    and signed zeros included: `fmin` and `fmax` are not a comparison's select in general.
    """
    return to_fixpoint(dfg, _recognize)


def _recognize(rewrite: Rewrite, node: Node) -> bool:
    if node.op is not Opcode.SELECT or rewrite.predicated(node.id):
        return False
    pred, if_true, if_false = rewrite.operands(node)
    comparison = rewrite.nodes[pred.src]
    if pred.distance or not is_comparison(comparison.op) or rewrite.predicated(comparison.id):
        return False
    first, second = rewrite.operands(comparison)
    if first == second or (if_true, if_false) not in ((first, second), (second, first)):
        return False
    op = _operation(rewrite, comparison.op, [first, second], swapped=if_true == second)
    if op is None:
        return False
    change_operation(rewrite, node, op, [first, second])
    return True


def _operation(
    rewrite: Rewrite, comparison: Opcode, compared: list[Value], *, swapped: bool
) -> Opcode | None:
    if comparison in _SIGNED_COMPARISONS:
        return Opcode.SMAX if swapped else Opcode.SMIN
    words = [rewrite.word(value) for value in compared]
    for op in (Opcode.FMIN, Opcode.FMAX):
        if comparison.value.startswith("fcmp") and _agrees(comparison, op, words, swapped=swapped):
            return op
    return None


def _agrees(comparison: Opcode, op: Opcode, words: list[int | None], *, swapped: bool) -> bool:
    """Whether the select gives what `op` gives, whatever the side is that is no constant.

    For a constant c it is enough to try one float of each class that a comparison or a minimum can
    tell apart: below c, equal to c, both zeros, above c, and NaN.
    """
    constants = [word for word in words if word is not None]
    if len(constants) != 1 or constants[0] & INT_MAX > INFINITY:
        return False
    at = words.index(None)
    for probe in _probes(constants[0]):
        a, b = (probe, constants[0]) if at == 0 else (constants[0], probe)
        arms = (b, a) if swapped else (a, b)
        if SEMANTICS[Opcode.SELECT](SEMANTICS[comparison](a, b), *arms) != SEMANTICS[op](a, b):
            return False
    return True


def _probes(word: int) -> list[int]:
    neighbours = [(word + step) & WORD_MASK for step in (-1, 0, 1)]
    return [*neighbours, 0, SIGN_BIT, INFINITY, INFINITY | SIGN_BIT, CANONICAL_NAN]
