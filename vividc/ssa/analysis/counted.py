"""Loops whose trip count is known before they start: the tile controller counts them."""

from __future__ import annotations

from dataclasses import dataclass, replace

from vividc.machine.opcodes import Opcode, Type
from vividc.machine.words import WORD_BITS
from vividc.ssa.analysis.counters import header_test
from vividc.ssa.analysis.induction import never_wraps
from vividc.ssa.analysis.polynomial import ITERATION, LoopPolynomials, Polynomial
from vividc.ssa.edit import block_of, incoming, next_id, with_blocks
from vividc.ssa.flow import Loop
from vividc.ssa.ir import Block, Const, Function, Instr, Ref, Value

_MOST = 0x7FFFFFFF


@dataclass(frozen=True, slots=True)
class Trip:
    """Trip count of a counted loop: a value of its preheader; negative means none."""

    value: Value


def count_loop(function: Function, loop: Loop, preheader: str) -> tuple[Function, Trip | None]:
    """Recognises `while bound - start - step * i > 0` tested in the header, with a power-of-two
    step.

    The trip count is computed in the preheader. Refused (None), and then run by an exit predicate:
    tests elsewhere than in the header, stores in the header, other comparisons, other steps, a
    counter that may wrap before it reaches the limit, and a header value other than a phi that is
    used after the loop (the header runs once more than the body).
    """
    header = block_of(function, loop.header)
    target = _exit_of(header, loop)
    if target is None or any(instr.op is Opcode.STORE for instr in header.instrs):
        return function, None
    if not _header_values_stay_inside(function, header, target):
        return function, None
    limits = _limits(function, loop)
    if limits is None:
        return function, None
    low, high = limits
    step = low.coefficient(ITERATION) - high.coefficient(ITERATION)
    if step <= 0 or step & (step - 1):
        return function, None
    emitter = _Emitter(next_id(function), header)
    ends = low.without(ITERATION), high.without(ITERATION)
    total = emitter.difference(*ends) if step == 1 else emitter.steps(*ends, step)
    block = block_of(function, preheader)
    block = replace(block, instrs=(*block.instrs, *emitter.instrs))
    return with_blocks(function, (block,)), Trip(total)


def _exit_of(header: Block, loop: Loop) -> str | None:
    if header.branch.cond is None:
        return None
    outside = [name for name in header.branch.successors if name not in loop.blocks]
    return outside[0] if len(outside) == 1 else None


def _header_values_stay_inside(function: Function, header: Block, target: str) -> bool:
    own = {instr.id for instr in header.instrs}
    exit_block = block_of(function, target)
    closing = (incoming(phi, header.name) for phi in exit_block.phis)
    return not any(isinstance(value, Ref) and value.id in own for value in closing)


def _limits(function: Function, loop: Loop) -> tuple[Polynomial, Polynomial] | None:
    """(low, high): the loop goes on while low < high, signed, each a function of the iteration."""
    test = header_test(function, loop)
    if test is None:
        return None
    forms = LoopPolynomials(function, loop)
    low, high = map(forms.of, test)
    if low is None or high is None:
        return None
    strides = [form.coefficient(ITERATION) for form in (low, high)]
    if all(strides):
        return None
    moving, stride = (test[0], strides[0]) if strides[0] else (test[1], strides[1])
    exact = never_wraps(function, loop.blocks, moving, by_one=abs(stride) == 1)
    return (low, high) if exact else None


class _Emitter:
    def __init__(self, first_id: int, header: Block) -> None:
        self.instrs: list[Instr] = []
        self._next = first_id
        self._loc = header.branch.loc

    def emit(self, op: Opcode, left: Value, right: Value) -> Value:
        """One more integer instruction."""
        result = Type.PRED if op is Opcode.ICMP_SLT else Type.I32
        instr = Instr(self._next, op, result, (left, right), loc=self._loc)
        self._next += 1
        self.instrs.append(instr)
        return Ref(instr.id)

    def difference(self, low: Polynomial, high: Polynomial) -> Value:
        """high - low as a trip count: at most 2**31 - 1, and not above 0 if high <= low.

        A plain difference of two words may overflow; one from zero, or of constants, does not.
        """
        if low.constant is not None and high.constant is not None:
            return Const(min(max(high.constant - low.constant, 0), _MOST))
        if low.constant == 0:
            return self.sum(high)
        count = self._distance(low, high)
        if low.constant is not None and low.constant >= 0:
            return count
        overflows = self.emit(Opcode.ICMP_SLT, count, Const(0))
        operands = (overflows, Const(_MOST), count)
        self.instrs.append(Instr(self._next, Opcode.SELECT, Type.I32, operands, loc=self._loc))
        self._next += 1
        return Ref(self._next - 1)

    def steps(self, low: Polynomial, high: Polynomial, step: int) -> Value:
        """How many steps of two or more, a power of two, lead from low to high or beyond; at most
        2**31 - 1. The distance is an unsigned word: it may be larger than any signed one.
        """
        if low.constant is not None and high.constant is not None:
            return Const(min(-(-max(high.constant - low.constant, 0) // step), _MOST))
        distance, shift = self._distance(low, high), Const(step.bit_length() - 1)
        if low.constant is not None and low.constant >= 0:
            return self.emit(Opcode.LSHR, self.emit(Opcode.ADD, distance, Const(step - 1)), shift)
        whole = self.emit(Opcode.LSHR, distance, shift)
        rest = self.emit(Opcode.AND, distance, Const(step - 1))
        count = self.emit(Opcode.ADD, whole, self.emit(Opcode.SMIN, rest, Const(1)))
        if step > 2:  # noqa: PLR2004 - of two there may be 2**31, a negative count
            return count
        return self.emit(Opcode.SUB, count, self.emit(Opcode.LSHR, count, Const(WORD_BITS - 1)))

    def _distance(self, low: Polynomial, high: Polynomial) -> Value:
        """From low to high, 0 if that is not above it."""
        least = self.sum(low)
        return self.emit(Opcode.SUB, self.emit(Opcode.SMAX, self.sum(high), least), least)

    def sum(self, total: Polynomial) -> Value:
        """The value of an invariant affine form."""
        value: Value | None = None
        for term, factor in total.linear().items():
            scaled = (
                term
                if abs(factor) == 1
                else self.emit(Opcode.MUL, term, Const(abs(factor) & 0xFFFFFFFF))
            )
            if value is None and factor > 0:
                value = scaled
            else:
                op = Opcode.ADD if factor > 0 else Opcode.SUB
                value = self.emit(op, Const(0) if value is None else value, scaled)
        constant = Const(total.coefficient() & 0xFFFFFFFF)
        if value is None:
            return constant
        return value if constant == Const(0) else self.emit(Opcode.ADD, value, constant)
