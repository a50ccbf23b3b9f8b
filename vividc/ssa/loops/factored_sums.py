"""Sums of products by a number that a loop does not change: the number times the sum.

Of `alpha * A @ x` each element of A is multiplied by alpha in each iteration, where loops by hand
multiply the sum. It rounds otherwise: only where sums of floats may be reassociated. Products of
matrices keep it, as what is multiplied is read for a whole row of results.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import Final

from vividc.machine.opcodes import Opcode
from vividc.ssa.analysis.induction import is_invariant
from vividc.ssa.edit import FreshIds, map_values, read_values, replaced, with_blocks
from vividc.ssa.flow import Loop, find_loops, predecessors
from vividc.ssa.ir import Block, Const, Function, Instr, Phi, Ref, Value, definition_of

_DEEPEST: Final = 2
"""Loops around a sum: in more, what it multiplies is multiplied for many sums at once."""


def factored_sums(function: Function) -> Function:
    """The function with such factors behind the loops of their sums."""
    loops = find_loops(function)
    for loop in loops:
        around = sum(loop.header in other.blocks for other in loops)
        holds = any(other.header in loop.blocks - {loop.header} for other in loops)
        if around == _DEEPEST and not holds:
            for phi in function.by_name[loop.header].phis:
                function = _factored(function, loop, phi) or function
    return function


def _factored(function: Function, loop: Loop, phi: Phi) -> Function | None:
    """With a factor of all that is added to a phi behind its loop."""
    starts = [value for name, value in phi.incoming if name not in loop.blocks]
    sums = [value for name, value in phi.incoming if name in loop.blocks]
    if starts != [Const(0)] or len(sums) != 1:
        return None
    uses = Counter(value for block in function.blocks for value in read_values(block))
    inside = Counter(value for name in loop.blocks for value in read_values(function.by_name[name]))
    added = definition_of(function, sums[0])
    if not isinstance(added, Instr) or inside[Ref(phi.id)] != 1:
        return None
    found = _in_sum(function, loop, phi, added, uses)
    behind = {target for _, target in loop.exits}
    if found is None or len(behind) != 1:
        return None
    [exit_] = behind
    block = function.by_name[exit_]
    if predecessors(function)[exit_] != (loop.header,) or _comes_in(block, phi):
        return None
    product, factor, rest = found
    operands, ids = (factor, Ref(phi.id)), FreshIds(function)
    whole = replace(product, id=ids(), op=Opcode.FMUL, operands=operands)
    changed: list[Block] = []
    for one in (one for one in function.blocks if one.name not in loop.blocks):
        made = map_values(one, lambda v: Ref(whole.id) if v == Ref(phi.id) else v)
        if one.name == exit_:
            made = replace(made, instrs=(whole, *made.instrs))
        changed.append(made)
    if product is not added:
        return replaced(with_blocks(function, changed), {product.id: rest})
    home = function.by_name[function.block_of[added.id]]
    sum_ = replace(added, op=Opcode.FADD, operands=(Ref(phi.id), rest))
    instrs = tuple(sum_ if one is added else one for one in home.instrs)
    return with_blocks(function, (*changed, replace(home, instrs=instrs)))


def _in_sum(
    function: Function, loop: Loop, phi: Phi, added: Instr, uses: Counter[Value]
) -> tuple[Instr, Value, Value] | None:
    """As `_product`, of what is added to a phi, by that or by a multiplication of its own."""
    terms = [value for value in added.operands if value != Ref(phi.id)]
    if added.op is Opcode.FADD and len(terms) == 1:
        return _product(function, loop, terms[0], uses)
    if added.op is not Opcode.FMA or added.operands[2] != Ref(phi.id) or len(terms) == 1:
        return None
    for factor, rest in (terms, terms[::-1]):
        if is_invariant(function, loop.blocks, factor):
            return added, factor, rest
    parts = (_product(function, loop, term, uses) for term in terms)
    return next((part for part in parts if part is not None), None)


def _product(
    function: Function, loop: Loop, value: Value, uses: Counter[Value]
) -> tuple[Instr, Value, Value] | None:
    """A multiplication among those that make a value, which nothing else reads: it, its factor that
    the loop does not change, and the other one.
    """
    made = definition_of(function, value)
    if not isinstance(made, Instr) or made.op is not Opcode.FMUL or uses[value] != 1:
        return None
    left, right = made.operands
    for factor, rest in ((left, right), (right, left)):
        if is_invariant(function, loop.blocks, factor):
            return made, factor, rest
    for part in (left, right):
        found = _product(function, loop, part, uses)
        if found is not None:
            return found
    return None


def _comes_in(block: Block, phi: Phi) -> bool:
    return any(value == Ref(phi.id) for one in block.phis for _, value in one.incoming)
