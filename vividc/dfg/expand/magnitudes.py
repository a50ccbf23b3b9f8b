"""How large the floats of a graph can be: what lets `expand_math` leave out cases."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Final

from vividc.dfg.ir import DFG, Node
from vividc.dfg.order import evaluation_order
from vividc.machine.opcodes import PRED, Opcode, Type
from vividc.machine.words import float_of

Interval = tuple[float, float]
ANYTHING: Final[Interval] = (-math.inf, math.inf)
_SLACK: Final = 1 + 2.0**-20  # more than any rounding error
_LARGEST_INT: Final = 2.0**31
_O = Opcode


def magnitudes(dfg: DFG) -> dict[int, float]:
    """For each node whose word is a float: a bound of its magnitude wherever it is finite.

    NaNs and infinities may come besides. Operands of earlier iterations, live-ins and loads are
    unknown.
    """
    known: dict[int, Interval] = {}
    sources = {
        (edge.dst, edge.port): (edge.src, edge.distance) for edge in dfg.edges if edge.is_data
    }
    for node_id in evaluation_order(dfg):
        node = dfg.by_id[node_id]
        operands = []
        for port in range(node.info.arity):
            source, distance = sources.get((node_id, port), (-1, 0))
            operands.append(ANYTHING if distance else known.get(source, ANYTHING))
        known[node_id] = ANYTHING if (node_id, PRED) in sources else _interval(node, operands)
    return {key: max(-low, high) for key, (low, high) in known.items()}


def argument_magnitudes(dfg: DFG) -> dict[int, float]:
    """For each node: a bound of the magnitude of its first operand, as `magnitudes`."""
    known = magnitudes(dfg)
    return {
        edge.dst: known[edge.src]
        for edge in dfg.edges
        if edge.is_data and edge.port == 0 and not edge.distance
    }


def _interval(node: Node, operands: Sequence[Interval]) -> Interval:
    if node.const is not None:
        value = float_of(node.const)
        return (value, value) if math.isfinite(value) else ANYTHING
    if node.op is Opcode.SELECT:
        return _hull(*operands[1:])
    rule = _RULES.get(node.op)
    if rule is None:
        return ANYTHING
    low, high = rule(*operands)
    if math.isnan(low) or math.isnan(high) or node.info.result is not Type.F32:
        return ANYTHING
    return low, high


def _hull(*intervals: Interval) -> Interval:
    return min(low for low, _ in intervals), max(high for _, high in intervals)


def _smaller(a: Interval, b: Interval) -> Interval:
    """The minimum of a NaN and a number is the number, and a constant is a number."""
    for constant in (a, b):
        if constant[0] == constant[1]:
            return min(a[0], b[0]), constant[1]
    return _hull(a, b)


def _negated(a: Interval) -> Interval:
    return -a[1], -a[0]


def _larger(a: Interval, b: Interval) -> Interval:
    return _negated(_smaller(_negated(a), _negated(b)))


def _sum(a: Interval, b: Interval) -> Interval:
    bound = (_magnitude(a) + _magnitude(b)) * _SLACK
    return -bound, bound


def _product(a: Interval, b: Interval) -> Interval:
    bound = _magnitude(a) * _magnitude(b) * _SLACK
    return -bound, bound


def _fma(a: Interval, b: Interval, c: Interval) -> Interval:
    return _sum(_product(a, b), c)


def _magnitude(a: Interval) -> float:
    return max(-a[0], a[1])


def _within(bound: float) -> Callable[..., Interval]:
    return lambda *_: (-bound, bound)


def _remainder(a: Interval, b: Interval) -> Interval:
    bound = min(_magnitude(a), _magnitude(b))
    return -bound, bound


_RULES: Final[dict[Opcode, Callable[..., Interval]]] = {
    _O.FMIN: _smaller,
    _O.FMAX: _larger,
    _O.FNEG: _negated,
    _O.FABS: lambda a: (0.0, _magnitude(a)),
    _O.FADD: _sum,
    _O.FSUB: _sum,
    _O.FMUL: _product,
    _O.FMA: _fma,
    _O.FMS: _fma,
    _O.FNMA: _fma,
    _O.FREM: _remainder,
    _O.SITOFP: _within(_LARGEST_INT),
    _O.UITOFP: _within(2 * _LARGEST_INT),
    _O.SIN: _within(1.0),
    _O.COS: _within(1.0),
    _O.TANH: _within(1.0),
    _O.ATAN: _within(2.0),
    _O.ASIN: _within(2.0),
    _O.ACOS: _within(4.0),
    _O.ATAN2: _within(4.0),
    _O.LOG: _within(128.0),
    _O.LOG2: _within(256.0),
    _O.LOG10: _within(64.0),
    _O.LOG1P: _within(128.0),
}
