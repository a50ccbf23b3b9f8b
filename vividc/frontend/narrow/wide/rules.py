"""Instructions on 64-bit integers in two words, wherever the low word alone is not enough.

`demand_high` says which; each rule here gives the result as words; what nobody reads is dropped.
"""

from __future__ import annotations

from collections.abc import Callable

from vividc.errors import KernelError
from vividc.frontend.advice import Advice
from vividc.frontend.narrow.demand_high import WIDE, reads_high, stem
from vividc.frontend.narrow.emit import Emitter
from vividc.frontend.narrow.wide import sums
from vividc.frontend.narrow.wide.divide import divide, divide_down
from vividc.frontend.narrow.wide.float import to_float
from vividc.frontend.narrow.wide.shifts import ashr, funnel_left, funnel_right, lshr, shl
from vividc.frontend.narrow.wide.words import ZERO, Pair, Words
from vividc.frontend.ranges.interval import S32, contains
from vividc.machine.opcodes import Opcode
from vividc.machine.words import WORD_BITS, WORD_MASK
from vividc.ssa.ir import Const, Instr, Int, Value

Rule = Callable[[Words, Instr], Pair | Value]
_MIN = 1 << 31


def translate_wide(emitter: Emitter, op: Instr) -> bool:
    """Emits `op` in two words if one does not do; False if one does.

    Raises
    ------
    KernelError
        Two words are needed, and there is no rule for them.
    """
    wanted = emitter.high_ids.get(op.id)
    if wanted is None and not reads_high(op, emitter.facts, wanted=False):
        return False
    rule = _CALLS.get(stem(op.pred)) if op.op == "call" else _RULES.get(op.mnemonic)
    if rule is None:
        what = stem(op.pred) if op.op == "call" else op.op
        raise KernelError(
            f"an integer that LLVM's `{what}` makes may not fit in 32 bits",
            loc=op.loc,
            hint=Advice(
                "wrap it in np.int32(...) or np.uint32(...)", c="cast it to int32_t or uint32_t"
            ),
        )
    words = Words(emitter, op)
    value = rule(words, op)
    words.results(emitter.ids.get(op.id), wanted, value)
    return True


def saturates_wide(op: Instr) -> bool:
    """Whether a call is a saturating sum or difference that has a rule in two words only."""
    return op.type == WIDE and stem(op.pred) in ("uadd.sat", "sadd.sat", "ssub.sat")


def _add(w: Words, op: Instr) -> Pair:
    return w.add(*_pairs(w, op))


def _sub(w: Words, op: Instr) -> Pair:
    return w.sub(*_pairs(w, op))


def _pairs(w: Words, op: Instr) -> tuple[Pair, Pair]:
    left, right = op.operands[:2]
    return w.pair(left), w.pair(right)


def _mul(w: Words, op: Instr) -> Pair:
    """A signed word times a signed word is one high product; a factor's sign else takes the other
    factor away.
    """
    left, right = op.operands
    a, b = _pairs(w, op)
    if w.emitter.signed(left, right):
        return Pair(w.op(Opcode.MUL, a.low, b.low), w.op(Opcode.MULHS, a.low, b.low))
    low, high = w.product(a.low, b.low)
    for one, factor, other in ((left, a, b), (right, b, a)):
        if contains(S32, w.range(one)):
            high = w.op(Opcode.SUB, high, w.op(Opcode.AND, factor.high, other.low))
        else:
            high = w.op(Opcode.ADD, high, w.op(Opcode.MUL, factor.high, other.low))
    return Pair(low, high)


def _logic(opcode: Opcode) -> Rule:
    def rule(w: Words, op: Instr) -> Pair:
        # A mask of a word hides the other operand's high word, which then is not computed.
        pairs = [Pair(w.emitter.value(arg), _high_or_hidden(w, op, arg)) for arg in op.operands]
        return w.logic(opcode, pairs[0], pairs[1])

    return rule


def _high_or_hidden(w: Words, op: Instr, operand: Value) -> Value:
    hides = any(isinstance(arg, Int) and 0 <= arg.value <= WORD_MASK for arg in op.operands)
    return ZERO if op.op == "and" and hides else w.high(operand)


def _select(w: Words, op: Instr) -> Pair:
    condition, yes, no = op.operands
    return w.select(w.emitter.value(condition), w.pair(yes), w.pair(no))


def _freeze(w: Words, op: Instr) -> Pair:
    return w.pair(op.operands[0])


def _compare(w: Words, op: Instr) -> Value:
    a, b = _pairs(w, op)
    if op.pred in ("eq", "ne"):
        known = sums.equal(w, *op.operands)
        same = w.equal(a, b) if known is None else known
        return same if op.pred == "eq" else w.negated(same)
    left, right = reversed(op.operands) if op.pred[1] == "g" else op.operands
    return _less(w, left, right, signed=op.pred[0] == "s", or_equal=op.pred[2] == "e")


def _less(w: Words, left: Value, right: Value, *, signed: bool, or_equal: bool = False) -> Value:
    """left < right (or left <= right)."""
    known = sums.less(w, left, right, signed=signed, or_equal=or_equal)
    if known is not None:
        return known
    return w.less(w.pair(left), w.pair(right), signed=signed, or_equal=or_equal)


def _extremum(*, signed: bool, largest: bool) -> Rule:
    def rule(w: Words, op: Instr) -> Pair | Value:
        left, right = op.operands[:2]
        if signed and op.id not in w.emitter.high_ids:
            low = sums.extremum(w, left, right, largest=largest)
            if low is not None:
                return low
        a, b = _pairs(w, op)
        less = _less(w, left, right, signed=signed)
        return w.select(less, b, a) if largest else w.select(less, a, b)

    return rule


def _abs(w: Words, op: Instr) -> Pair:
    a = w.pair(op.operands[0])
    return w.negate_if(a, w.sign(a))


def _three_way(*, signed: bool) -> Rule:
    """scmp, ucmp: (a > b) - (a < b)."""

    def rule(w: Words, op: Instr) -> Pair:
        a, b = _pairs(w, op)
        below = w.less(a, b, signed=signed)
        above = w.less(b, a, signed=signed)
        word = w.op(Opcode.SUB, above, below)
        return Pair(word, w.op(Opcode.ASHR, word, WORD_BITS - 1))

    return rule


def _saturating_unsigned(w: Words, op: Instr) -> Pair:
    a, b = _pairs(w, op)
    if stem(op.pred) == "usub.sat":
        return w.select(w.less(a, b, signed=False), Pair(ZERO, ZERO), w.sub(a, b))
    total = w.add(a, b)
    return w.select(w.less(total, a, signed=False), Pair(Const(WORD_MASK), Const(WORD_MASK)), total)


def _saturating_signed(w: Words, op: Instr) -> Pair:
    """The sum overflows if its sign differs from both operands' (a - b: from a's, and b's from
    a's).
    """
    a, b = _pairs(w, op)
    adds = stem(op.pred) == "sadd.sat"
    total = w.add(a, b) if adds else w.sub(a, b)
    changed = w.op(Opcode.XOR, total.high, a.high)
    other = w.op(Opcode.XOR, total.high if adds else a.high, b.high)
    overflowed = w.op(Opcode.ICMP_SLT, w.op(Opcode.AND, changed, other), ZERO)
    sign = w.sign(a)
    limit = Pair(w.op(Opcode.XOR, sign, WORD_MASK), w.op(Opcode.XOR, sign, _MIN - 1))
    return w.select(overflowed, limit, total)


def _bytes_reversed(opcode: Opcode) -> Rule:
    """bswap, bitreverse."""

    def rule(w: Words, op: Instr) -> Pair:
        low, high = w.pair(op.operands[0])
        return Pair(w.op(opcode, high), w.op(opcode, low))

    return rule


def _population(w: Words, op: Instr) -> Pair:
    low, high = w.pair(op.operands[0])
    return Pair(w.op(Opcode.ADD, w.op(Opcode.CTPOP, low), w.op(Opcode.CTPOP, high)), ZERO)


def _zeros(opcode: Opcode) -> Rule:
    """ctlz, cttz: those of the first word looked at, and of the second where that is 0."""

    def rule(w: Words, op: Instr) -> Pair:
        low, high = w.pair(op.operands[0])
        first, second = (high, low) if opcode is Opcode.CTLZ else (low, high)
        beyond = w.op(Opcode.ADD, w.op(opcode, second), WORD_BITS)
        is_zero = w.op(Opcode.ICMP_EQ, first, ZERO)
        return Pair(w.choose(is_zero, beyond, w.op(opcode, first)), ZERO)

    return rule


def _funnel(*, left: bool) -> Rule:
    def rule(w: Words, op: Instr) -> Pair:
        high, low, amount = op.operands
        by: Value | int = amount.value % 64 if isinstance(amount, Int) else w.emitter.value(amount)
        return (funnel_left if left else funnel_right)(w, w.pair(high), w.pair(low), by)

    return rule


def _shift(shift: Callable[..., Pair]) -> Rule:
    def rule(w: Words, op: Instr) -> Pair:
        value, amount = op.operands
        if isinstance(amount, Int):
            by = amount.value % 64
            # All that is shifted beyond the high word leaves it unread.
            unread = op.op == "shl" and by >= WORD_BITS
            pair = Pair(w.emitter.value(value), ZERO) if unread else w.pair(value)
            return shift(w, pair, by, (by, by))
        return shift(w, w.pair(value), w.emitter.value(amount), w.range(amount))

    return rule


_RULES: dict[str, Rule] = {
    "add": _add,
    "sub": _sub,
    "mul": _mul,
    "and": _logic(Opcode.AND),
    "or": _logic(Opcode.OR),
    "xor": _logic(Opcode.XOR),
    "select": _select,
    "freeze": _freeze,
    "icmp": _compare,
    "shl": _shift(shl),
    "lshr": _shift(lshr),
    "ashr": _shift(ashr),
    "sdiv": divide,
    "udiv": divide,
    "srem": divide,
    "urem": divide,
    "sfloordiv": divide_down,
    "sfloorrem": divide_down,
    "ufloordiv": divide_down,
    "ufloorrem": divide_down,
    "sitofp": to_float,
    "uitofp": to_float,
}
_CALLS: dict[str, Rule] = {
    "smin": _extremum(signed=True, largest=False),
    "smax": _extremum(signed=True, largest=True),
    "umin": _extremum(signed=False, largest=False),
    "umax": _extremum(signed=False, largest=True),
    "abs": _abs,
    "scmp": _three_way(signed=True),
    "ucmp": _three_way(signed=False),
    "usub.sat": _saturating_unsigned,
    "uadd.sat": _saturating_unsigned,
    "ssub.sat": _saturating_signed,
    "sadd.sat": _saturating_signed,
    "fshl": _funnel(left=True),
    "fshr": _funnel(left=False),
    "ctpop": _population,
    "ctlz": _zeros(Opcode.CTLZ),
    "cttz": _zeros(Opcode.CTTZ),
    "bswap": _bytes_reversed(Opcode.BSWAP),
    "bitreverse": _bytes_reversed(Opcode.BITREVERSE),
}
