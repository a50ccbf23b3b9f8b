"""Loops whose trip count is known before they start: the tile controller counts them."""

from __future__ import annotations

from dataclasses import dataclass, replace

from vividc.machine.opcodes import Opcode, Type
from vividc.ssa.analysis.affine import Affine, AffineAnalysis
from vividc.ssa.edit import block_of, incoming, next_id, with_blocks
from vividc.ssa.flow import Loop
from vividc.ssa.ir import Block, Const, Function, Instr, Ref, Value


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
    limits = _limits(function, loop, header)
    if limits is None:
        return function, None
    low, high = limits
    step = low.stride - high.stride
    if step <= 0 or step & (step - 1):
        return function, None
    emitter = _Emitter(next_id(function), header)
    total = emitter.difference(replace(low, stride=0), replace(high, stride=0), clamp=step > 1)
    if step > 1:
        total = emitter.emit(Opcode.ADD, total, Const(step - 1))
        total = emitter.emit(Opcode.LSHR, total, Const(step.bit_length() - 1))
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


def _limits(function: Function, loop: Loop, header: Block) -> tuple[Affine, Affine] | None:
    """(low, high): the loop goes on while low < high, signed, each a function of the iteration."""
    branch = header.branch
    test = next((i for i in header.instrs if Ref(i.id) == branch.cond), None)
    if test is None:
        return None
    stays = branch.target in loop.blocks
    first, second = test.operands[0], test.operands[-1]
    if test.op is Opcode.ICMP_SLE and not stays:
        first, second = second, first  # leaves if a <= b: stays while b < a
    elif test.op is not Opcode.ICMP_SLT or not stays:
        return None
    analysis = AffineAnalysis(function, loop)
    low, high = analysis.of(first), analysis.of(second)
    if low is None or high is None or (low.stride and high.stride):
        return None
    moving, stride = (first, low.stride) if low.stride else (second, high.stride)
    if not analysis.never_wraps(moving, by_one=abs(stride) == 1):
        return None
    return low, high


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

    def difference(self, low: Affine, high: Affine, *, clamp: bool) -> Value:
        """high - low as a trip count: at most 2**31 - 1, and not above 0 if high <= low.

        A plain difference of two words may overflow; one from zero, or of constants, does not.
        With `clamp` the count is not negative.
        """
        if not low.terms and not high.terms:
            return Const(max(high.constant - low.constant, 0) & 0x7FFFFFFF)
        if low == Affine(0, 0) and not clamp:
            return self.sum(high)
        least = self.sum(low)
        most = self.emit(Opcode.SMAX, self.sum(high), least)
        count = self.emit(Opcode.SUB, most, least)
        if not low.terms and low.constant >= 0:
            return count
        overflows = self.emit(Opcode.ICMP_SLT, count, Const(0))
        operands = (overflows, Const(0x7FFFFFFF), count)
        self.instrs.append(Instr(self._next, Opcode.SELECT, Type.I32, operands, loc=self._loc))
        self._next += 1
        return Ref(self._next - 1)

    def sum(self, total: Affine) -> Value:
        """The value of an invariant affine form."""
        value: Value | None = None
        for term, factor in total.terms:
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
        constant = Const(total.constant & 0xFFFFFFFF)
        if value is None:
            return constant
        return value if total.constant == 0 else self.emit(Opcode.ADD, value, constant)
