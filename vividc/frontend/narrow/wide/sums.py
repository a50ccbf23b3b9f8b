"""A sum or difference of two words against a word, by the sum's low word and tests of its terms.

What is compared in each iteration of a minimum or maximum is on its recurrence, which has one or
two operations here.
"""

from __future__ import annotations

from typing import NamedTuple

from vividc.frontend.narrow.emit import ALIASES
from vividc.frontend.narrow.wide.words import Words
from vividc.frontend.ranges.interval import S32, contains
from vividc.machine.opcodes import Opcode, Type
from vividc.ssa.ir import Instr, Int, Named, Ref, Value

_LEAST, _MOST = S32


class _Sum(NamedTuple):
    """first + second or first - second, both of them words.

    Attributes
    ----------
    low
        The low word of it.
    sign
        Of the second: 1, -1, or 0 if it may have any.
    is_steady
        Whether iterations of the innermost loop are likely to share the second.
    passes_least, passes_most
        Whether it may be less, or more, than any word.
    """

    low: Value
    adds: bool
    first: Value
    second: Value
    sign: int
    is_steady: bool
    passes_least: bool
    passes_most: bool


def less(
    w: Words, left: Value, right: Value, *, signed: bool, or_equal: bool = False
) -> Value | None:
    """left < right (or left <= right), of a sum of two words and a word; None if they are not."""
    for sum_, word in ((left, right), (right, left)):
        over = _overflow(w, sum_) if signed and _is_plain(w, word) else None
        if over is not None:
            low, is_left = w.emitter.value(sum_), sum_ is left
            test = Opcode.ICMP_SLE if or_equal else Opcode.ICMP_SLT
            exact = w.op(test, *map(w.emitter.value, (left, right)))
            wrapped = w.op(Opcode.ICMP_SLE, 0, low) if is_left else w.op(Opcode.ICMP_SLT, low, 0)
            return w.choose(over, wrapped, exact, type_=Type.PRED)
    return None


def equal(w: Words, left: Value, right: Value) -> Value | None:
    """Whether a sum of two words is a constant word; None if they are not that.

    a + b = c is a = c - b where c - b is a word: a test of b alone.
    """
    for sum_, constant in ((left, right), (right, left)):
        if not isinstance(constant, Int) or not contains(S32, w.range(constant)):
            continue
        made = _sum_of(w, sum_)
        if made is None:
            continue
        c, b = constant.value, made.second
        rest = w.op(Opcode.SUB if made.adds else Opcode.ADD, *((c, b) if made.adds else (b, c)))
        same = w.op(Opcode.ICMP_EQ, made.first, rest)
        if made.adds:  # c - b passes the most word for small b if c >= 0, else the least for large
            fits = (c - _MOST, b) if c >= 0 else (b, c - _LEAST)
        else:
            fits = (b, _MOST - c) if c >= 0 else (_LEAST - c, b)
        return w.both(same, w.op(Opcode.ICMP_SLE, *fits))
    return None


def extremum(w: Words, left: Value, right: Value, *, largest: bool) -> Value | None:
    """The low word of the largest (or least) of a sum of two words and a word; None if they are
    not that.

    Of a sum that no word holds, the largest is the sum if that is above all words, else the word.
    """
    for sum_, word in ((left, right), (right, left)):
        made = _sum_of(w, sum_) if _is_plain(w, word) else None
        if made is None:
            continue
        other = w.emitter.value(word)
        if made.sign:
            return _of_known_sign(w, made, other, largest)
        if made.is_steady or not (made.passes_least and made.passes_most):
            return _by_limits(w, made, other, largest)
        return _by_signs(w, made, other, largest)
    return None


def _of_known_sign(w: Words, made: _Sum, word: Value, largest: bool) -> Value:
    """A sum that passes no word is on that side of its first term that the second takes it to."""
    grows = (made.sign > 0) == made.adds
    holds = (made.first, made.low) if grows else (made.low, made.first)
    best = w.op(_better(largest), word, made.low)
    beyond = made.low if grows == largest else word
    return w.choose(w.op(Opcode.ICMP_SLE, *holds), best, beyond)


def _by_signs(w: Words, made: _Sum, word: Value, largest: bool) -> Value:
    """A sum that a word holds is below its first term if the second is negative, else it is not."""
    below = w.op(Opcode.ICMP_SLT, made.low, made.first)
    falls = (made.second, 0) if made.adds else (0, made.second)
    over = w.either_only(below, w.op(Opcode.ICMP_SLT, *falls))
    best = w.op(_better(largest), word, made.low)
    ends = (made.low, word) if largest else (word, made.low)
    return w.choose(over, w.choose(below, *ends), best)


def _by_limits(w: Words, made: _Sum, word: Value, largest: bool) -> Value:
    """By which first terms take the sum beyond all words, which depends on the second alone. The
    largest: a sum below all words is raised to the least of them by raising its first term.
    """
    near, far = (_LEAST, _MOST) if largest else (_MOST, _LEAST)
    passes_near, passes_far = made.passes_least, made.passes_most
    if not largest:
        passes_near, passes_far = passes_far, passes_near
    low = made.low
    if passes_near:
        first = w.op(_better(largest), made.first, _first_of(w, made, near))
        low = w.op(Opcode.ADD if made.adds else Opcode.SUB, first, made.second)
    best = w.op(_better(largest), word, low)
    if not passes_far:
        return best
    fits = (made.first, _first_of(w, made, far))
    return w.choose(w.op(Opcode.ICMP_SLE, *(fits if largest else fits[::-1])), best, low)


def _better(largest: bool) -> Opcode:
    return Opcode.SMAX if largest else Opcode.SMIN


def _first_of(w: Words, made: _Sum, limit: int) -> Value:
    """The first term that makes the sum the least or the most word; where no first term makes it
    pass that, the least or the most word itself.
    """
    below = (limit == _LEAST) == made.adds  # then negative second terms take it there
    part = w.op(Opcode.SMIN if below else Opcode.SMAX, made.second, 0)
    return w.op(Opcode.SUB, limit, part) if made.adds else w.op(Opcode.ADD, part, limit)


def _sum_of(w: Words, operand: Value) -> _Sum | None:
    """The terms of a sum or difference of two words; None if it is none, or fits into a word. The
    second is one whose sign is known, if there is such a one.
    """
    made = w.emitter.function.definitions.get(operand.id) if isinstance(operand, Ref) else None
    if not isinstance(made, Instr) or made.op not in ("add", "sub") or w.emitter.signed(operand):
        return None
    if not w.emitter.signed(*made.operands):
        return None
    first, second = made.operands
    adds = made.op == "add"
    if adds and _likelier(w, first, second):
        first, second = second, first
    low, *terms = map(w.emitter.value, (operand, first, second))
    least, most = w.range(operand)
    return _Sum(
        low,
        adds,
        terms[0],
        terms[1],
        _sign(w, second),
        _is_steady(w, second),
        least < _LEAST,
        most > _MOST,
    )


def _likelier(w: Words, one: Value, other: Value) -> bool:
    """Whether the second term of a sum had better be `one`: its sign is known, or other iterations
    share what is computed of it.
    """
    if _sign(w, one) or _sign(w, other):
        return not _sign(w, other)
    return _is_steady(w, one) and not _is_steady(w, other)


def _is_steady(w: Words, operand: Value) -> bool:
    """Whether the innermost loop around here leaves an operand, or where it is loaded, as it is."""
    made = w.emitter.function.definitions.get(operand.id) if isinstance(operand, Ref) else None
    if isinstance(made, Instr) and made.op in ALIASES:
        return _is_steady(w, made.operands[0])
    if isinstance(made, Instr) and made.op == "load":
        return w.emitter.is_invariant(made.operands[0])
    return w.emitter.is_invariant(operand)


def _sign(w: Words, operand: Value) -> int:
    low, high = w.range(operand)
    return 1 if low >= 0 else -1 if high <= 0 else 0


def _is_plain(w: Words, operand: Value) -> bool:
    """Whether it is a word whose high word is its sign, and neither a constant nor known."""
    return isinstance(operand, Named) and w.emitter.known_high(operand) is None


def _overflow(w: Words, operand: Value) -> Value | None:
    """Whether a sum or difference of two words has another sign than its low word; None if it is
    none, or fits into a word.
    """
    made = _sum_of(w, operand)
    if made is None:
        return None
    low, one, other = made.low, made.first, made.second
    changed = w.op(Opcode.XOR, one, low)
    differs = w.op(Opcode.XOR, *((other, low) if made.adds else (one, other)))
    return w.op(Opcode.ICMP_SLT, w.op(Opcode.AND, changed, differs), 0)
