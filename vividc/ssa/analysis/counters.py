"""Counters that a loop's header tests: `while j < limit` with a constant step."""

from __future__ import annotations

from dataclasses import dataclass

from vividc.machine.opcodes import Opcode
from vividc.ssa.analysis.affine import AffineAnalysis
from vividc.ssa.edit import block_of, defined_types
from vividc.ssa.flow import Loop
from vividc.ssa.ir import Const, Function, Input, Phi, Ref, Value

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


def counter_of(function: Function, loop: Loop) -> Counter | None:
    """The counter that the header of `loop` tests to leave it, or None.

    The loop may have other exits. Refused: a test of another word than the phi itself, a limit that
    changes in the loop, and a counter that may wrap before it meets the limit.
    """
    header = block_of(function, loop.header)
    test = next((i for i in header.instrs if Ref(i.id) == header.branch.cond), None)
    if test is None or len(loop.latches) != 1:
        return None
    stays = header.branch.target in loop.blocks
    less, more = test.operands[0], test.operands[-1]
    if test.op is Opcode.ICMP_SLE and not stays:
        less, more = more, less  # leaves if a <= b: stays while b < a
    elif test.op is not Opcode.ICMP_SLT or not stays:
        return None
    analysis = AffineAnalysis(function, loop)
    for phi in header.phis:
        moving, limit = (less, more) if less == Ref(phi.id) else (more, less)
        step = analysis.step(phi) if moving == Ref(phi.id) else None
        if not step or (step > 0) != (moving == less) or not analysis.is_invariant(limit):
            continue
        if analysis.never_wraps(moving, by_one=abs(step) == 1):
            return Counter(phi, analysis.initial(phi), step, limit)
    return None


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
    return isinstance(value, Input) and ".shape" in value.key


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
