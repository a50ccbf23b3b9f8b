"""Which bytes a chunk is certain to write: a slice that is completely written need not be moved
in.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from vividc.machine.opcodes import Opcode
from vividc.machine.parallel import CHOICE, CLAMPS, COUNTER, INDEX, Access, Parallel, Term
from vividc.sim.footprint.footprint import ANYTHING, Interval, chunk_intervals

_BITS: Final = 32
_INDEX: Final = -1
"""The symbol of the loop's variable; those of inner loops are their counters' terms."""


@dataclass(frozen=True, slots=True)
class _Affine:
    """constant + the sum of factor * symbol."""

    constant: int
    factors: tuple[tuple[int, int], ...] = ()

    def plus(self, other: _Affine, sign: int = 1) -> _Affine:
        factors = dict(self.factors)
        for symbol, factor in other.factors:
            factors[symbol] = factors.get(symbol, 0) + sign * factor
        kept = tuple(sorted((s, f) for s, f in factors.items() if f))
        return _Affine(self.constant + sign * other.constant, kept)

    def times(self, factor: int) -> _Affine:
        factors = tuple((symbol, f * factor) for symbol, f in self.factors if factor)
        return _Affine(self.constant * factor, factors)


def written_whole(
    parallel: Parallel, inputs: Mapping[str, int], first: int, last: int, *, leading: bool = False
) -> dict[str, Interval]:
    """For each array the bytes that iterations `first` to before `last` write in any case, or if
    `leading` those that loops beside the parallel one write before anything loads some of the
    array.

    Stores that lie one behind the other in an iteration count as one; then the loops around must
    step by just what is inside them, as digits of a number do.
    """
    known = chunk_intervals(parallel, inputs, first, last)
    groups: dict[tuple[str, int, int, tuple[int, ...]], list[Access]] = {}
    for access in parallel.accesses:
        if access.is_store and access.counters is not None and access.leads >= leading:
            key = (access.array, access.term, access.shift, access.counters)
            groups.setdefault(key, []).append(access)
    extents: dict[str, Interval] = {}
    for (array, _, _, counters), group in groups.items():
        part = _part(parallel.terms, known, group, counters, (first, last))
        if part is not None and part[1] - part[0] > _size(extents.get(array)):
            extents[array] = part
    return extents


def fills(
    parallel: Parallel, known: Sequence[Interval | None], access: Access, first: int, last: int
) -> bool:
    """Whether a store writes every element between the least and the greatest of its subscripts in
    iterations `first` to before `last`: each is a counter of its own, plus what is fixed.
    """
    if access.counters is None or not access.subscripts:
        return False
    symbols = {_INDEX, *access.counters}
    used: list[int] = []
    for number in access.subscripts:
        affine = _affine(parallel.terms, known, number)
        if affine is None or any(abs(factor) != 1 for _, factor in affine.factors):
            return False
        used += [symbol for symbol, _ in affine.factors]
        if len(affine.factors) > 1:
            return False
    runs = {s: _run(parallel.terms, known, s, (first, last)) for s in symbols}
    if any(count <= 0 for _, _, count in runs.values()):
        return False
    return len(set(used)) == len(used) and all(abs(runs[symbol][1]) == 1 for symbol in used)


def _size(interval: Interval | None) -> int:
    return 0 if interval is None else interval[1] - interval[0]


def _part(
    terms: Sequence[Term],
    known: Sequence[Interval | None],
    group: list[Access],
    counters: tuple[int, ...],
    chunk: Interval,
) -> Interval | None:
    own = sorted(group, key=lambda access: access.offset)
    ends = [access.offset + access.width for access in own]
    if any(access.offset != end for access, end in zip(own[1:], ends, strict=False)):
        return None
    affine = _affine(terms, known, own[0].term)
    if affine is None or len(set(counters)) < len(counters):
        return None
    factors = dict(affine.factors)
    if not factors.keys() <= {_INDEX, *counters}:
        return None
    size = ends[-1] - own[0].offset
    start = (affine.constant << own[0].shift) + own[0].offset
    strides = []
    for symbol in (_INDEX, *counters):
        factor = factors.get(symbol, 0)
        begin, step, count = _run(terms, known, symbol, chunk)
        if count <= 0:
            return None
        stride = factor * step << own[0].shift
        start += (factor * begin << own[0].shift) + min(0, stride * (count - 1))
        strides.append((abs(stride), count))
    for stride, count in sorted(strides):
        if count > 1 and stride not in (0, size):
            return None
        size *= count if stride else 1
    return (start, start + size)


def _run(
    terms: Sequence[Term], known: Sequence[Interval | None], symbol: int, chunk: Interval
) -> tuple[int, int, int]:
    """First value, step and number of values of a symbol; no value if they are not known."""
    if symbol == _INDEX:
        return chunk[0], 1, chunk[1] - chunk[0]
    ends = [known[arg] for arg in terms[symbol].args]
    if any(end is None or end[0] != end[1] for end in ends):
        return 0, 1, 0
    start, limit, step = (end[0] for end in ends if end is not None)
    return start, step, -((start - limit) // step) if step else 0


def _affine(terms: Sequence[Term], known: Sequence[Interval | None], number: int) -> _Affine | None:
    """A term as a sum; None if it is not one, or may wrap around."""
    term, interval = terms[number], known[number]
    if term.op in (INDEX, COUNTER):
        return _Affine(0, ((_INDEX if term.op == INDEX else number, 1),))
    if term.op in CLAMPS:
        # The value is the first argument's: the clamp only says where it can be.
        return _affine(terms, known, term.args[0])
    if interval is None or interval == ANYTHING:
        return None
    if interval[0] == interval[1]:
        return _Affine(interval[0])
    if term.op == CHOICE:
        cond = known[term.args[0]]
        is_known = cond is not None and cond[0] == cond[1]
        taken = term.args[1 if cond is not None and cond[0] else 2]
        return _affine(terms, known, taken) if is_known else None
    return _sum(terms, known, term)


def _sum(terms: Sequence[Term], known: Sequence[Interval | None], term: Term) -> _Affine | None:
    rule = _RULES.get(term.op)
    if rule is None:
        return None
    left, right = (_affine(terms, known, arg) for arg in term.args)
    return None if left is None or right is None else rule(left, right)


def _shl(value: _Affine, by: _Affine) -> _Affine | None:
    return value.times(1 << by.constant) if not by.factors and 0 <= by.constant < _BITS else None


def _mul(left: _Affine, right: _Affine) -> _Affine | None:
    if left.factors and right.factors:
        return None
    return left.times(right.constant) if left.factors else right.times(left.constant)


_RULES: Final[dict[str, Callable[[_Affine, _Affine], _Affine | None]]] = {
    Opcode.ADD.value: lambda left, right: left.plus(right),
    Opcode.SUB.value: lambda left, right: left.plus(right, -1),
    Opcode.SHL.value: _shl,
    Opcode.MUL.value: _mul,
}
