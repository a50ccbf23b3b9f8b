"""A graph of operations on many words at once, in numpy: for sweeps over all mantissas."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vividc import arch
from vividc.dfg.expand.expand import expand_math
from vividc.dfg.forms.text import parse
from vividc.dfg.interpret.interpreter import interpret_region
from vividc.dfg.ir import DFG
from vividc.dfg.order import evaluation_order
from vividc.machine.opcodes import OPCODES, PRED, Opcode
from vividc.machine.semantics import evaluate

_O = Opcode
_SHIFT_MASK = np.uint32(31)


def fma(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """binary32 fma: exact product, sum rounded to odd in binary64, then rounded once."""
    product = a.astype(np.float64) * b.astype(np.float64)
    addend = np.broadcast_to(np.asarray(c, np.float32), product.shape).astype(np.float64)
    total = product + addend
    virtual = total - product
    error = (product - (total - virtual)) + (addend - virtual)
    bits = total.view(np.int64)
    away = np.where((error > 0) == (total > 0), 1, -1)
    inexact = (error != 0) & np.isfinite(error) & (bits & 1 == 0)
    odd = np.where(inexact, bits + away, bits).view(np.float64)
    return odd.astype(np.float32)


def _float(words: np.ndarray) -> np.ndarray:
    return words.view(np.float32)


def _of_floats(function: Callable[..., np.ndarray]) -> Callable[..., np.ndarray]:
    def words(*operands: np.ndarray) -> np.ndarray:
        result = function(*map(_float, operands)).astype(np.float32)
        return np.where(np.isnan(result), np.uint32(0x7FC00000), result.view(np.uint32))

    return words


def _test_floats(function: Callable[..., np.ndarray]) -> Callable[..., np.ndarray]:
    return lambda a, b: function(_float(a), _float(b)).astype(np.uint32)


def _to_int(a: np.ndarray) -> np.ndarray:
    x = _float(a).astype(np.float64)
    inside = np.trunc(np.clip(np.where(np.isnan(x), 0, x), -(2.0**31), 2.0**31 - 1))
    return inside.astype(np.int64).astype(np.uint32)


def _signed(a: np.ndarray) -> np.ndarray:
    return a.view(np.int32)


def _high(product: np.ndarray) -> np.ndarray:
    return (product >> product.dtype.type(32)).astype(np.uint32)


OPERATIONS: dict[Opcode, Callable[..., np.ndarray]] = {
    _O.ADD: lambda a, b: a + b,
    _O.SUB: lambda a, b: a - b,
    _O.MUL: lambda a, b: a * b,
    _O.MULHS: lambda a, b: _high(_signed(a).astype(np.int64) * _signed(b)),
    _O.MULHU: lambda a, b: _high(a.astype(np.uint64) * b),
    _O.AND: lambda a, b: a & b,
    _O.OR: lambda a, b: a | b,
    _O.XOR: lambda a, b: a ^ b,
    _O.SHL: lambda a, b: a << (b & _SHIFT_MASK),
    _O.LSHR: lambda a, b: a >> (b & _SHIFT_MASK),
    _O.ASHR: lambda a, b: (_signed(a) >> _signed(b & _SHIFT_MASK)).view(np.uint32),
    _O.SMIN: lambda a, b: np.minimum(_signed(a), _signed(b)).view(np.uint32),
    _O.SMAX: lambda a, b: np.maximum(_signed(a), _signed(b)).view(np.uint32),
    _O.MOV: lambda a: a,
    _O.ICMP_NE: lambda a, b: (a != b).astype(np.uint32),
    _O.ICMP_ULT: lambda a, b: (a < b).astype(np.uint32),
    _O.ICMP_SLT: lambda a, b: (_signed(a) < _signed(b)).astype(np.uint32),
    _O.SELECT: lambda p, a, b: np.where(p != 0, a, b),
    _O.FADD: _of_floats(np.add),
    _O.FSUB: _of_floats(np.subtract),
    _O.FMUL: _of_floats(np.multiply),
    _O.FMA: _of_floats(fma),
    _O.FMS: _of_floats(lambda a, b, c: fma(a, b, -c)),
    _O.FNMA: _of_floats(lambda a, b, c: fma(-a, b, c)),
    _O.FMIN: _of_floats(np.fmin),
    _O.FMAX: _of_floats(np.fmax),
    _O.FNEG: lambda a: a ^ np.uint32(0x80000000),
    _O.FABS: lambda a: a & np.uint32(0x7FFFFFFF),
    _O.FCMP_OEQ: _test_floats(np.equal),
    _O.FCMP_UNE: _test_floats(np.not_equal),
    _O.FCMP_ONE: _test_floats(lambda a, b: (a < b) | (a > b)),
    _O.FCMP_ORD: _test_floats(lambda a, b: ~(np.isnan(a) | np.isnan(b))),
    _O.FCMP_UNO: _test_floats(lambda a, b: np.isnan(a) | np.isnan(b)),
    _O.FCMP_OLE: _test_floats(np.less_equal),
    _O.FCMP_OLT: _test_floats(np.less),
    _O.FCMP_ULE: _test_floats(lambda a, b: ~(a > b)),
    _O.FCMP_ULT: _test_floats(lambda a, b: ~(a >= b)),
    _O.SITOFP: lambda a: _signed(a).astype(np.float32).view(np.uint32),
    _O.UITOFP: lambda a: a.astype(np.float32).view(np.uint32),
    _O.FPTOSI: _to_int,
}


def evaluate_many(dfg: DFG, node_id: int, given: dict[int, np.ndarray]) -> np.ndarray:
    """Words of node `node_id` where the nodes of `given` have these words; no carried edges."""
    needed, pending = set(given), [node_id]
    while pending:
        current = pending.pop()
        if current not in needed:
            needed.add(current)
            pending += [edge.src for edge in dfg.edges if edge.dst == current]
    words = {key: np.asarray(value, np.uint32) for key, value in given.items()}
    shape = next(iter(words.values())).shape
    for current in evaluation_order(dfg):
        if current in needed and current not in words:
            words[current] = np.broadcast_to(_evaluate(dfg, current, words), shape)
    return words[node_id]


def _evaluate(dfg: DFG, node_id: int, words: dict[int, np.ndarray]) -> np.ndarray:
    node = dfg.by_id[node_id]
    if node.const is not None:
        return np.array([node.const], np.uint32)
    sources = {edge.port: edge.src for edge in dfg.edges if edge.dst == node_id}
    operands = [words[sources[port]] for port in range(node.info.arity)]
    with np.errstate(all="ignore"):
        result = OPERATIONS[node.op](*(np.ascontiguousarray(operand) for operand in operands))
    if PRED in sources:
        return np.where(words[sources[PRED]] != 0, result, operands[-1])
    return result


BINARY = """dfg "{op}"
%0 = iv
%1 = live_in "&x"
%2 = load "x" %0 shift 2 base %1
%3 = load "x" %0 shift 2 offset {offset} base %1
%4 = {op} %2, %3
%5 = store "x" %0, %4 shift 2 base %1 after %2, %3
"""
UNARY = """dfg "{op}"
%0 = iv
%1 = live_in "&x"
%2 = load "x" %0 shift 2 base %1
%4 = {op} %2
%5 = store "x" %0, %4 shift 2 base %1 after %2
"""


STRAIGHT = """dfg "{op}"
%2 = live_in "a"
%3 = live_in "b"
%6 = const 0x3f800000
{before}%4 = {op} {operands}
%5 = live_out "%v" %4
"""


LATE_DIVIDEND = 13
"""The first operand of straight code where that comes late, through products with 1."""


def graph(
    op: Opcode, count: int = 0, *, straight: bool = False, late_dividend: bool = False
) -> DFG:
    """x[i] = op(x[i]), or op(x[i], x[i + count]), for `count` words; or straight code, whose first
    operand may come late.
    """
    if straight:
        products = zip((2, *range(7, LATE_DIVIDEND)), range(7, LATE_DIVIDEND + 1), strict=True)
        before = (
            "".join(f"%{n} = fmul %{one}, %6\n" for one, n in products) if late_dividend else ""
        )
        operands = [f"%{LATE_DIVIDEND}" if late_dividend else "%2", "%3"][: OPCODES[op].arity]
        text = STRAIGHT.format(op=op.value, before=before, operands=", ".join(operands))
        return parse(text)
    text = BINARY if OPCODES[op].arity > 1 else UNARY
    return parse(text.format(op=op.value, offset=4 * count))


def interpreted(op: Opcode, *operands: np.ndarray) -> np.ndarray:
    """Words of the expanded operation by the interpreter."""
    count = len(operands[0])
    memory = np.concatenate(operands).astype(np.uint32)
    interpret_region(expand_math(graph(op, count)), "loop", count, {"&x": 0}, memory)
    return memory[:count]


def expanded(
    op: Opcode, *operands: np.ndarray, straight: bool = False, late_dividend: bool = False
) -> np.ndarray:
    """Words of the expanded operation in numpy."""
    dfg = expand_math(graph(op, len(operands[0]), straight=straight, late_dividend=late_dividend))
    port = 0 if straight else 1
    [result] = [edge.src for edge in dfg.edges if edge.dst == 5 and edge.port == port]
    return evaluate_many(dfg, result, dict(zip((2, 3), operands, strict=False)))


def latency(dfg: DFG, first: int, last: int) -> int:
    """Cycles from a node's result on the longest path to another one's start, on vivid-tile."""
    fabric = arch.load("vivid-tile")
    ready = {first: 0}
    for node_id in evaluation_order(dfg):
        reached = [ready[e.src] for e in dfg.in_edges[node_id] if e.is_data and e.src in ready]
        if reached and node_id == last:
            return max(reached)
        if reached:
            ready[node_id] = max(reached) + fabric.latencies[dfg.by_id[node_id].latency_class]
    raise AssertionError(f"no path from {first} to {last}")


def by_semantics(op: Opcode, *operands: np.ndarray) -> np.ndarray:
    """Words that the table of semantics gives."""
    rows = zip(*(operand.tolist() for operand in operands), strict=True)
    return np.array([evaluate(op, row) for row in rows], np.uint32)


SPECIALS = np.array(
    [
        *(0, 1, 2, 0x7FFFFF, 0x800000, 0x800001, 0x3F7FFFFF, 0x3F800000, 0x3F800001, 0x3FFFFFFF),
        *(0x40400000, 0x4AFFFFFF, 0x4B000000, 0x4F000000, 0x5F000000, 0x7F000000, 0x7F7FFFFF),
        *(0x7F800000, 0x7F800001, 0x7FC00000, 0x7FFFFFFF),
    ],
    np.uint32,
)
SPECIALS = np.concatenate([SPECIALS, SPECIALS | np.uint32(0x80000000)])


def random_words(count: int, seed: int) -> np.ndarray:
    """Words of all kinds."""
    rng = np.random.default_rng(seed)
    return rng.integers(0, 1 << 32, count, dtype=np.uint64).astype(np.uint32)
