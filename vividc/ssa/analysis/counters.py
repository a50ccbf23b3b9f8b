"""Counters that a loop's header tests: `while j < limit` with a constant step; and which numbers
are lengths, small and natural.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from vividc.machine.opcodes import Opcode
from vividc.machine.params import MAX_ELEMENTS, Formula
from vividc.ssa.analysis.induction import Induction, induction_of, is_invariant, never_wraps
from vividc.ssa.analysis.order import Order, Sum
from vividc.ssa.edit import block_of, defined_types
from vividc.ssa.flow import Loop
from vividc.ssa.ir import (
    Const,
    Function,
    Input,
    Instr,
    Phi,
    Ref,
    Value,
    definition_of,
    is_dimension,
)

LONGEST: Final = 1 << 20
"""No dimension of an array is longer, and no scalar that is a length."""

_INT_MAX = (1 << 31) - 1
_INT_MIN = -(1 << 31)


@dataclass(frozen=True, slots=True)
class Counter:
    """The loop runs while `phi` < `limit` (or > if `step` is negative), as signed words.

    Attributes
    ----------
    phi
        The header phi; each iteration adds `step` to it and never wraps.
    initial
        Its word when the loop is entered.
    step
        Not zero.
    limit
        A value from outside the loop.
    """

    phi: Phi
    initial: Value
    step: int
    limit: Value


def counter_of(function: Function, loop: Loop, *, inclusive: bool = False) -> Counter | None:
    """The counter that the header of `loop` tests to leave it, or None.

    The loop may have other exits. Refused: a test of another word than the phi itself, a limit that
    changes in the loop, and a counter that may wrap before it meets the limit.

    Parameters
    ----------
    inclusive
        The counter of a loop that runs once more, while the phi is at its limit, instead.
    """
    test = header_test(function, loop, inclusive=inclusive)
    if test is None or len(loop.latches) != 1:
        return None
    for found, step, limit in bounded(function, loop, *test):
        moving, by_one = Ref(found.phi.id), abs(step) == 1 and not inclusive
        exact = never_wraps(function, loop.blocks, moving, by_one=by_one)
        if exact and found.start is not None:
            return Counter(found.phi, found.start, step, limit)
    return None


def header_test(
    function: Function, loop: Loop, *, inclusive: bool = False
) -> tuple[Value, Value] | None:
    """(less, more): the header lets the loop go on while less < more, as signed words; while
    less <= more if `inclusive`.
    """
    branch = block_of(function, loop.header).branch
    test = definition_of(function, branch.cond)
    if not isinstance(test, Instr) or function.block_of[test.id] != loop.header:
        return None
    stays = (branch.target in loop.blocks, branch.otherwise in loop.blocks)
    direct, negated = Opcode.ICMP_SLT, Opcode.ICMP_SLE
    if inclusive:
        direct, negated = negated, direct
    if test.op is direct and stays == (True, False):
        return test.operands[0], test.operands[1]
    if test.op is negated and stays == (False, True):
        return test.operands[1], test.operands[0]  # leaves if a <= b: stays while b < a
    return None


def bounded(
    function: Function, loop: Loop, less: Value, more: Value
) -> Iterator[tuple[Induction, int, Value]]:
    """Induction variables that meet a fixed limit, so that less < more no longer holds: with their
    steps and limits.
    """
    for phi in block_of(function, loop.header).phis:
        induction = induction_of(function, loop.blocks, phi)
        step = None if induction is None else induction.step
        if induction is None or not step:
            continue
        moving, limit = (less, more) if step > 0 else (more, less)
        if moving == Ref(phi.id) and is_invariant(function, loop.blocks, limit):
            yield induction, step, limit


def defined_in(function: Function, loop: Loop) -> set[int]:
    """Ids of the values that `loop` defines."""
    inside: set[int] = set()
    for block in function.blocks:
        if block.name in loop.blocks:
            inside |= defined_types(block).keys()
    return inside


def is_length(value: Value) -> bool:
    """Whether `value` is known to be a small natural number: a dimension of an array, or such a
    constant.
    """
    if isinstance(value, Const):
        return value.word <= 1 << 14
    return is_dimension(value)


def lengths(function: Function, order: Order, block: str) -> frozenset[Value]:
    """Scalars that prove to be from 0 to `LONGEST` where `block` runs.

    Of `np.zeros((n, n))` n is one: the launch makes an array of as many words as a formula says,
    which are no more than there are addresses. So what is multiplied by itself there, and by
    nothing that may be 0, is small, and a branch to what raises may tell that it is not negative.
    """
    facts = order.facts(block)

    def is_at_least(value: Input, least: int) -> bool:
        return order.is_proved(Sum(((value, 1),), -least), facts)

    found: set[Value] = set()
    for formula in _formulas(function):
        factors, constant = _product(formula)
        for one in dict.fromkeys(factors):
            is_small = constant * (LONGEST + 1) ** factors.count(one) > MAX_ELEMENTS
            others = (other for other in factors if other != one)
            if is_small and all(is_at_least(other, 1) for other in others) and is_at_least(one, 0):
                found.add(one)
    return frozenset(found)


def _formulas(function: Function) -> Iterator[Formula]:
    """How many words the arrays have that the kernel makes."""
    yield from (param.made for param in function.params if param.made)
    yield from (array.size for array in function.locals if array.size)


def _product(formula: Formula) -> tuple[list[Input], int]:
    """The scalars that a formula multiplies by a constant; none if it does anything else."""
    factors, constant = list[Input](), 1
    for item in formula:
        if isinstance(item, int):
            constant *= item
        elif item.startswith("s:"):
            factors.append(Input(item[len("s:") :]))
        elif item != "*":
            return [], 1
    is_known = constant > 0 and not any(map(is_dimension, factors))
    return (factors, constant) if is_known else ([], 1)


def moved_limit(counter: Counter) -> tuple[tuple[Opcode, int], ...]:
    """Operations with constants that turn the limit L into M such that a counter which has not met
    L meets it in the next step if, and only if, it is not on this side of M.

    For step > 0: j + step < L, and then also j < L, if and only if j < M = max(L, least + step) -
    step, where the maximum keeps the subtraction from wrapping.
    """
    step = counter.step
    moved = (Opcode.ADD, -step)
    if step > 0:
        safe = is_length(counter.limit) and step < _INT_MAX
        return (moved,) if safe else ((Opcode.SMAX, _INT_MIN + step), moved)
    return ((Opcode.SMIN, _INT_MAX + step), moved)
