"""Which bytes of its arrays a chunk of a parallel loop touches, as intervals of the terms of
`machine.parallel`, computed when the arguments are known.

Intervals are of signed words; what may leave them may be any word, as the machine's wraps around.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

from vividc.errors import ArgumentError, InternalError, SourceLoc
from vividc.machine.opcodes import Opcode
from vividc.machine.parallel import (
    ANY,
    CHOICE,
    CLAMPS,
    CONST,
    COUNTER,
    FIRST,
    INDEX,
    LAST,
    START,
    STEPS,
    UNION,
    Access,
    Parallel,
    Term,
    beside_keys,
)
from vividc.machine.semantics import evaluate
from vividc.machine.words import WORD_BITS, WORD_MASK, signed

Interval = tuple[int, int]
Rule = Callable[..., Interval]

ANYTHING: Final[Interval] = (-(1 << WORD_BITS - 1), (1 << WORD_BITS - 1) - 1)


@dataclass(frozen=True, slots=True)
class Touch:
    """First byte and end of what a chunk may read and write of an array; None: nothing.

    `load_loc`, `store_loc`: a line that does.
    """

    loads: Interval | None = None
    stores: Interval | None = None
    load_loc: SourceLoc | None = None
    store_loc: SourceLoc | None = None

    @property
    def hull(self) -> Interval | None:
        """Both together."""
        return _union(self.loads, self.stores)


def loop_bounds(parallel: Parallel, inputs: Mapping[str, int]) -> tuple[int, int]:
    """First iteration of the whole loop, and the one after the last (not below the first).

    Raises
    ------
    ArgumentError
        They are unsigned and larger than a signed word.
    """
    known = _intervals(parallel.terms, inputs, None)
    ends = (known[parallel.first], known[parallel.last])
    if any(end is None or end[0] != end[1] for end in ends):
        return 0, 0  # a division by zero: a kernel that comes to the loop is undefined
    first, last = map(_exact, ends)
    if parallel.is_unsigned and min(first, last) < 0:
        raise ArgumentError(
            "the loop over prange runs beyond iteration 2**31",
            loc=parallel.loc,
            hint="run the kernel on pieces of its arrays",
        )
    return first, max(first, last)


def start_words(parallel: Parallel, inputs: Mapping[str, int]) -> tuple[int, ...]:
    """The words with which the reductions start."""
    known = _intervals(parallel.terms, inputs, None)
    return tuple(
        item.start_word if item.start_word is not None else _exact(known[item.start]) & WORD_MASK
        for item in parallel.reductions
    )


def chunk_inputs(
    parallel: Parallel, first: int, last: int, starts: Sequence[int], is_first: bool
) -> dict[str, int]:
    """The launch words of the iterations from `first` to before `last`."""
    words = {FIRST: first & WORD_MASK, LAST: last & WORD_MASK}
    for number, (item, start) in enumerate(zip(parallel.reductions, starts, strict=True)):
        begins = is_first or item.identity is None
        words[f"{START}{number}"] = start if begins or item.identity is None else item.identity
    return words


def whole_loop(parallel: Parallel, inputs: Mapping[str, int]) -> dict[str, int]:
    """The launch words of all iterations."""
    first, last = loop_bounds(parallel, inputs)
    words = chunk_inputs(parallel, first, last, start_words(parallel, inputs), True)
    for number, ends in enumerate(bounds_beside(parallel, inputs)):
        words |= beside_words(number, *ends)
    return words


def bounds_beside(parallel: Parallel, inputs: Mapping[str, int]) -> list[Interval]:
    """First iteration of each loop beside the parallel one, and the one after the last."""
    if not parallel.beside:
        return []
    known = values_of(parallel.terms, inputs)
    ends = [(known[one.first], known[one.last]) for one in parallel.beside]
    return [
        (0, 0) if first is None or last is None else (first, max(first, last))
        for first, last in ends
    ]


def beside_words(number: int, first: int, last: int) -> dict[str, int]:
    """The launch words of these iterations of a loop beside the parallel one."""
    return dict(zip(beside_keys(number), (first & WORD_MASK, last & WORD_MASK), strict=True))


def chunk_intervals(
    parallel: Parallel, inputs: Mapping[str, int], first: int, last: int
) -> list[Interval | None]:
    """The values of each term in the iterations from `first` to before `last`; None: it has none
    there.
    """
    words = {**inputs, FIRST: first & WORD_MASK, LAST: last & WORD_MASK}
    return _intervals(parallel.terms, words, (first, last - 1))


def values_of(terms: Sequence[Term], words: Mapping[str, int]) -> list[int | None]:
    """The values that terms have at launch; None of those that it does not decide."""
    known = _intervals(terms, words, None)
    return [end[0] if end is not None and end[0] == end[1] else None for end in known]


def touched(
    parallel: Parallel,
    inputs: Mapping[str, int],
    sizes: Mapping[str, int],
    first: int,
    last: int,
) -> dict[str, Touch]:
    """What the iterations from `first` to before `last` touch of each array, within the arrays.

    Parameters
    ----------
    inputs
        The launch words of parameters and shapes.
    sizes
        Bytes of each array.
    """
    known = chunk_intervals(parallel, inputs, first, last)
    touches = dict.fromkeys(sizes, Touch())
    for access in parallel.accesses:
        part = bytes_of(access, known[access.term], sizes[access.array])
        if part is None:
            continue
        old = touches[access.array]
        if access.is_store:
            stores = _union(old.stores, part)
            touches[access.array] = Touch(old.loads, stores, old.load_loc, access.loc)
        else:
            loads = _union(old.loads, part)
            touches[access.array] = Touch(loads, old.stores, access.loc, old.store_loc)
    return touches


def bytes_of(access: Access, index: Interval | None, size: int) -> Interval | None:
    """First byte and end of what may be accessed of an array of `size` bytes. An access outside the
    array is undefined, so that it need not be there.
    """
    if index is None or size == 0:
        return None
    if index == ANYTHING:
        return (0, size)
    start = (index[0] << access.shift) + access.offset
    end = (index[1] << access.shift) + access.offset + access.width
    if end - start >= 1 << WORD_BITS:
        return (0, size)
    start, end = max(start, 0), min(end, size)
    return (start, end) if start < end else None


def _union(one: Interval | None, other: Interval | None) -> Interval | None:
    if one is None or other is None:
        return other if one is None else one
    return (min(one[0], other[0]), max(one[1], other[1]))


def _exact(interval: Interval | None) -> int:
    if interval is None or interval[0] != interval[1]:
        raise InternalError("a bound of a parallel loop has no value")
    return interval[0]


def _intervals(
    terms: Sequence[Term], inputs: Mapping[str, int], index: Interval | None
) -> list[Interval | None]:
    """Every term's values; None where there are none."""
    known: list[Interval | None] = []
    for term in terms:
        known.append(_interval(term, [known[arg] for arg in term.args], inputs, index))
    return known


def _interval(
    term: Term,
    args: list[Interval | None],
    inputs: Mapping[str, int],
    index: Interval | None,
) -> Interval | None:
    if not term.args:
        return _leaf(term, inputs, index)
    if term.op == UNION:
        result: Interval | None = None
        for arg in args:
            result = _union(result, arg)
        return result
    if term.op == CHOICE:
        return _chosen(*args)
    present = [arg for arg in args if arg is not None]
    return None if len(present) < len(args) else _of_intervals(term.op, present)


def _leaf(term: Term, inputs: Mapping[str, int], index: Interval | None) -> Interval | None:
    if term.op == INDEX:
        return index
    if term.op == CONST:
        return (term.word, term.word)
    if term.op == ANY:
        return ANYTHING if term.word >= WORD_BITS else (0, (1 << term.word) - 1)
    word = inputs.get(term.key)
    return ANYTHING if word is None else (signed(word), signed(word))


def _chosen(cond: Interval | None, yes: Interval | None, no: Interval | None) -> Interval | None:
    if cond is None:
        return None
    if cond[0] == cond[1]:
        return yes if cond[0] else no
    return _union(yes, no)


def _of_intervals(op: str, args: list[Interval]) -> Interval | None:
    if op in CLAMPS:
        return _clamped(op, args[0], args[1])
    if op == COUNTER:
        return _word(_counter(*args))
    if op == STEPS:
        return _steps(*args)
    by_zero = op in _DIVISIONS and args[1] == (0, 0)
    if not by_zero and all(low == high for low, high in args):
        word = signed(evaluate(Opcode(op), [low & WORD_MASK for low, _ in args]))
        return (word, word)
    rule = _RULES.get(op)
    if rule is None:
        return (0, 1) if op.startswith("icmp") else ANYTHING
    return _word(rule(*args))


def _word(interval: Interval) -> Interval:
    inside = ANYTHING[0] <= interval[0] and interval[1] <= ANYTHING[1]
    return interval if inside else ANYTHING


def _clamped(op: str, value: Interval, other: Interval) -> Interval | None:
    low, high = value
    if op in ("lt", "le"):
        high = min(high, other[1] - (op == "lt"))
    elif op in ("gt", "ge"):
        low = max(low, other[0] + (op == "gt"))
    elif op == "eq":
        low, high = max(low, other[0]), min(high, other[1])
    elif other[0] >= 0:
        low, high = max(low, 0), min(high, other[1] - 1)
    return (low, high) if low <= high else None


def _counter(start: Interval, limit: Interval, step: Interval) -> Interval:
    """Up to where the loop's test ends it."""
    if step[0] > 0:
        return (start[0], max(start[1], limit[1] - 1 + step[1]))
    return (min(start[0], limit[0] + 1 + step[0]), start[1])


def _steps(start: Interval, step: Interval, count: Interval) -> Interval | None:
    if count[1] <= 0:
        return None
    moves = [by * times for by in step for times in (0, count[1] - 1)]
    return _word((start[0] + min(moves), start[1] + max(moves)))


def _add(a: Interval, b: Interval) -> Interval:
    return (a[0] + b[0], a[1] + b[1])


def _sub(a: Interval, b: Interval) -> Interval:
    return (a[0] - b[1], a[1] - b[0])


def _mul(a: Interval, b: Interval) -> Interval:
    corners = [x * y for x, y in product(a, b)]
    return (min(corners), max(corners))


def _mulhu(a: Interval, b: Interval) -> Interval:
    if a[0] < 0 or b[0] < 0:
        return ANYTHING
    return (a[0] * b[0] >> WORD_BITS, a[1] * b[1] >> WORD_BITS)


def _and(a: Interval, b: Interval) -> Interval:
    tops = [high for low, high in (a, b) if low >= 0]
    return (0, min(tops)) if tops else ANYTHING


def _xor(a: Interval, b: Interval) -> Interval:
    """Of -1, as LLVM writes -1 - a."""
    a, b = (b, a) if a == (-1, -1) else (a, b)
    return (-1 - a[1], -1 - a[0]) if b == (-1, -1) else ANYTHING


def _shl(a: Interval, b: Interval) -> Interval:
    return _mul(a, (1 << b[0], 1 << b[0])) if _is_shift(b) else ANYTHING


def _ashr(a: Interval, b: Interval) -> Interval:
    return (a[0] >> b[0], a[1] >> b[0]) if _is_shift(b) else ANYTHING


def _lshr(a: Interval, b: Interval) -> Interval:
    return _ashr(a, b) if a[0] >= 0 else ANYTHING


def _is_shift(b: Interval) -> bool:
    return b[0] == b[1] and 0 <= b[0] < WORD_BITS


def _slt(a: Interval, b: Interval) -> Interval:
    return (int(a[1] < b[0]), int(a[0] < b[1]))


def _sle(a: Interval, b: Interval) -> Interval:
    return (int(a[1] <= b[0]), int(a[0] <= b[1]))


def _smin(a: Interval, b: Interval) -> Interval:
    return (min(a[0], b[0]), min(a[1], b[1]))


def _smax(a: Interval, b: Interval) -> Interval:
    return (max(a[0], b[0]), max(a[1], b[1]))


def _sdiv(a: Interval, b: Interval) -> Interval:
    if b[0] <= 0:
        return ANYTHING
    ends = [_truncated(x, y) for x, y in product(a, b)]
    return (min(ends), max(ends))


def _udiv(a: Interval, b: Interval) -> Interval:
    if a[0] == a[1] < 0 < b[0]:
        a = (a[0] & WORD_MASK, a[0] & WORD_MASK)
    return _sdiv(a, b) if a[0] >= 0 else ANYTHING


def _truncated(a: int, b: int) -> int:
    return a // b if a >= 0 else -(-a // b)


def _rem(a: Interval, b: Interval) -> Interval:
    if a[0] < 0 or b[0] <= 0:
        return ANYTHING
    if b[0] == b[1] and a[0] // b[0] == a[1] // b[0]:
        return (a[0] % b[0], a[1] % b[0])
    return (0, min(a[1], b[1] - 1))


_DIVISIONS: Final = frozenset(
    op.value for op in (Opcode.SDIV, Opcode.UDIV, Opcode.SREM, Opcode.UREM)
)
_RULES: Final[dict[str, Rule]] = {
    Opcode.MOV.value: lambda a: a,
    Opcode.ADD.value: _add,
    Opcode.SUB.value: _sub,
    Opcode.MUL.value: _mul,
    Opcode.MULHU.value: _mulhu,
    Opcode.AND.value: _and,
    Opcode.XOR.value: _xor,
    Opcode.SHL.value: _shl,
    Opcode.LSHR.value: _lshr,
    Opcode.ASHR.value: _ashr,
    Opcode.ICMP_SLT.value: _slt,
    Opcode.ICMP_SLE.value: _sle,
    Opcode.SMIN.value: _smin,
    Opcode.SMAX.value: _smax,
    Opcode.SDIV.value: _sdiv,
    Opcode.UDIV.value: _udiv,
    Opcode.SREM.value: _rem,
    Opcode.UREM.value: _rem,
}
