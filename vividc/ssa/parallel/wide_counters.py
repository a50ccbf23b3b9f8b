"""Counters of 64 bits in two words, and loops of words whose limit has 64 bits, such as
`range(r, w - r)` and `range(n + 1)` of integers of 32 bits.

Where the first value and the limit are words in two, all values between are; then the low word
counts as if it were alone.
"""

from __future__ import annotations

from dataclasses import dataclass

from vividc.machine.opcodes import Opcode
from vividc.machine.words import WORD_BITS, signed
from vividc.ssa.analysis.induction import induction_of, initial, is_invariant
from vividc.ssa.flow import Loop
from vividc.ssa.ir import Const, Function, Instr, Phi, Ref, Value, definition_of

Pair = tuple[Value, Value]
"""The low and the high word of an integer."""


@dataclass(frozen=True, slots=True)
class WideCounter:
    """The loop runs while (phi, its high word) < `limit`, from `start` by `step`, which is
    positive; `test` is the id of the comparison.
    """

    phi: Phi
    start: Pair
    limit: Pair
    step: int
    test: int


def wide_counter(function: Function, loop: Loop) -> WideCounter | None:
    """The counter in two words that the header of a loop tests to leave it."""
    branch = function.by_name[loop.header].branch
    if branch.target not in loop.blocks or branch.otherwise in loop.blocks:
        return None
    if not isinstance(branch.cond, Ref) or (words := _less(function, branch.cond)) is None:
        return None
    (low, high), limit = words
    phi = definition_of(function, low)
    if not isinstance(phi, Phi) or function.block_of[phi.id] != loop.header:
        return None
    moves = induction_of(function, loop.blocks, phi)
    step = None if moves is None else moves.step
    if moves is None or moves.start is None or step is None or step <= 0:
        return None
    start = _high_start(function, loop, high, moves.update, moves.start)
    if start is None or not all(is_invariant(function, loop.blocks, word) for word in limit):
        return None
    return WideCounter(phi, (moves.start, start), limit, step, branch.cond.id)


def is_word(function: Function, pair: Pair) -> bool:
    """Whether an integer in two words is a word for certain: the high one is its sign."""
    low, high = pair
    if isinstance(low, Const) and isinstance(high, Const):
        return signed(high.word) == (-1 if signed(low.word) < 0 else 0)
    made = definition_of(function, high)
    return (
        isinstance(made, Instr)
        and made.op is Opcode.ASHR
        and made.operands == (low, Const(WORD_BITS - 1))
    )


def _high_start(
    function: Function, loop: Loop, high: Value, update: Instr, start: Value
) -> Value | None:
    """The first high word, if each iteration adds the carry to it, or if it is 0: then the loop
    starts at a natural number and never gets past 2**31.
    """
    if high == Const(0):
        return high if isinstance(start, Const) and signed(start.word) >= 0 else None
    phi = definition_of(function, high)
    if not isinstance(phi, Phi) or function.block_of[phi.id] != loop.header:
        return None
    again = {value for source, value in phi.incoming if source in loop.blocks}
    added = definition_of(function, again.pop()) if len(again) == 1 else None
    if not isinstance(added, Instr) or added.op is not Opcode.ADD or added.operands[0] != high:
        return None
    carry = definition_of(function, added.operands[1])
    if not isinstance(carry, Instr) or carry.op is not Opcode.ICMP_ULT:
        return None
    is_carry = carry.operands[0] == Ref(update.id) and carry.operands[1] in update.operands
    return initial(phi, loop.blocks) if is_carry else None


def _less(function: Function, test: Ref) -> tuple[Pair, Pair] | None:
    """(a, b) of a < b in two words each: a's high word < b's, or they are equal and a's low word is
    below b's, unsigned.
    """
    above, both = _operands(function, test, Opcode.OR)
    level, below = _operands(function, both, Opcode.AND)
    highs = _operands(function, above, Opcode.ICMP_SLT)
    lows = _operands(function, below, Opcode.ICMP_ULT)
    if highs[0] is None or lows[0] is None or highs[1] is None or lows[1] is None:
        return None
    if _operands(function, level, Opcode.ICMP_EQ) != highs:
        return None
    return (lows[0], highs[0]), (lows[1], highs[1])


def _operands(
    function: Function, value: Value | None, op: Opcode
) -> tuple[Value, Value] | tuple[None, None]:
    made = definition_of(function, value)
    if not isinstance(made, Instr) or made.op is not op:
        return None, None
    return made.operands[0], made.operands[1]
