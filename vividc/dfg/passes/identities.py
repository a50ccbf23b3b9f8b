"""Algebraic identities that hold bit for bit, by operation, for `fold_constants`.

Each is a function that simplifies one unpredicated node and returns whether it changed the graph.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from vividc.dfg.ir import Node
from vividc.dfg.passes.rewrite import Rewrite, Value, change_operation
from vividc.machine.compare import INVERSES, is_comparison
from vividc.machine.opcodes import NEGATED_ADDEND, NEGATED_FACTOR, OPCODES, Opcode, Type
from vividc.machine.semantics import SEMANTICS
from vividc.machine.words import INFINITY, INT_MAX, SIGN_BIT, WORD_MASK

Identity = Callable[[Rewrite, Node], bool]

_ONE_F32: Final = 0x3F800000
_SHIFT_MASK: Final = 31
_NEUTRAL: Final = {
    Opcode.ADD: 0,
    Opcode.SUB: 0,
    Opcode.MUL: 1,
    Opcode.AND: WORD_MASK,
    Opcode.OR: 0,
    Opcode.XOR: 0,
    Opcode.SMIN: INT_MAX,
    Opcode.SMAX: SIGN_BIT,
}
_ABSORBING: Final = {
    Opcode.MUL: 0,
    Opcode.MULHS: 0,
    Opcode.MULHU: 0,
    Opcode.AND: 0,
    Opcode.OR: WORD_MASK,
    Opcode.SMIN: SIGN_BIT,
    Opcode.SMAX: INT_MAX,
}
_NEUTRAL_F32: Final = {Opcode.FADD: SIGN_BIT, Opcode.FSUB: 0, Opcode.FMUL: _ONE_F32}
# Results of these on equal operands; None: the operand itself.
_ON_EQUAL: Final = {
    Opcode.SUB: 0,
    Opcode.XOR: 0,
    Opcode.AND: None,
    Opcode.OR: None,
    Opcode.SMIN: None,
    Opcode.SMAX: None,
    Opcode.ICMP_EQ: 1,
    Opcode.ICMP_SLE: 1,
    Opcode.ICMP_ULE: 1,
    Opcode.ICMP_NE: 0,
    Opcode.ICMP_SLT: 0,
    Opcode.ICMP_ULT: 0,
}
_ASSOCIATIVE: Final = (Opcode.ADD, Opcode.MUL, Opcode.AND, Opcode.OR, Opcode.XOR)
_BIT_OPERATIONS: Final = frozenset(
    {Opcode.FNEG, Opcode.FABS, Opcode.LOAD, Opcode.LIVE_IN, Opcode.MOV, Opcode.SELECT}
)


def _constant_last(rewrite: Rewrite, node: Node) -> bool:
    """Let port 1 of a commuting operation read the constant."""
    first = rewrite.operand(node.id, 0)
    if rewrite.word(first) is None:
        return False
    second = rewrite.operand(node.id, 1)
    if rewrite.word(second) is not None:
        return False
    rewrite.set_operand(node.id, 0, second)
    rewrite.set_operand(node.id, 1, first)
    return True


def _neutral_element(rewrite: Rewrite, node: Node) -> bool:
    if rewrite.word(rewrite.operand(node.id, 1)) != _NEUTRAL[node.op]:
        return False
    return rewrite.forward(node.id, rewrite.operand(node.id, 0))


def _absorbing_element(rewrite: Rewrite, node: Node) -> bool:
    if rewrite.word(rewrite.operand(node.id, 1)) != _ABSORBING[node.op]:
        return False
    return rewrite.forward_constant(node.id, _ABSORBING[node.op])


def _neutral_float(rewrite: Rewrite, node: Node) -> bool:
    if rewrite.word(rewrite.operand(node.id, 1)) != _NEUTRAL_F32[node.op]:
        return False
    first = rewrite.operand(node.id, 0)
    return _has_canonical_nans(rewrite, first) and rewrite.forward(node.id, first)


def _has_canonical_nans(rewrite: Rewrite, value: Value) -> bool:
    """Whether a NaN among the words of `value` can only be the canonical one, which arithmetic
    keeps.
    """
    source = rewrite.nodes[value.src]
    words = [word for word in (source.const, _init_word(rewrite, value)) if word is not None]
    if any(word & INT_MAX > INFINITY for word in words):
        return False
    if value.init is not None and _init_word(rewrite, value) is None:
        return False
    if source.op in _BIT_OPERATIONS or rewrite.predicated(source.id):
        return False
    return source.const is not None or source.info.result is Type.F32


def _init_word(rewrite: Rewrite, value: Value) -> int | None:
    return None if value.init is None else rewrite.nodes[value.init].const


def _equal_operands(rewrite: Rewrite, node: Node) -> bool:
    first, second = rewrite.operands(node)
    if first != second:
        return False
    word = _ON_EQUAL[node.op]
    if word is None:
        return rewrite.forward(node.id, first)
    return rewrite.forward_constant(node.id, word)


def _nested_constant(rewrite: Rewrite, node: Node) -> bool:
    """`(x op c) op d` is `x op (c op d)`."""
    inner, outer_word = _inner(rewrite, node), rewrite.word(rewrite.operand(node.id, 1))
    if inner is None or inner.op is not node.op or outer_word is None:
        return False
    inner_word = rewrite.word(rewrite.operand(inner.id, 1))
    if inner_word is None:
        return False
    word = SEMANTICS[node.op](inner_word, outer_word)
    rewrite.set_operand(node.id, 0, rewrite.operand(inner.id, 0))
    rewrite.set_operand(node.id, 1, Value(rewrite.constant(word)))
    return True


def _inner(rewrite: Rewrite, node: Node, port: int = 0) -> Node | None:
    """The unpredicated operation of this iteration that a port reads."""
    value = rewrite.operand(node.id, port)
    source = rewrite.nodes[value.src]
    if value.distance or source.op not in SEMANTICS or rewrite.predicated(source.id):
        return None
    return source


def _subtract_constant(rewrite: Rewrite, node: Node) -> bool:
    """`x - c` is `x + -c`, which commutes and folds into addresses."""
    first, second = rewrite.operands(node)
    word = rewrite.word(second)
    if word is None:
        return False
    negated = Value(rewrite.constant(-word & WORD_MASK))
    change_operation(rewrite, node, Opcode.ADD, [first, negated])
    return True


def _multiply_by_power_of_two(rewrite: Rewrite, node: Node) -> bool:
    first, second = rewrite.operands(node)
    word = rewrite.word(second)
    if word is None or word.bit_count() != 1:
        return False
    amount = Value(rewrite.constant(word.bit_length() - 1))
    change_operation(rewrite, node, Opcode.SHL, [first, amount])
    return True


def _high_product_by_power_of_two(rewrite: Rewrite, node: Node) -> bool:
    """The high word of `x << k` is `x >> (32 - k)`; by 1 it is 0, or the sign."""
    first, second = rewrite.operands(node)
    word = rewrite.word(second)
    if word is None or word.bit_count() != 1 or (node.op is Opcode.MULHS and word == SIGN_BIT):
        return False
    if word == 1 and node.op is Opcode.MULHU:
        return rewrite.forward_constant(node.id, 0)
    amount = Value(rewrite.constant(min(32 - (word.bit_length() - 1), _SHIFT_MASK)))
    shift = Opcode.ASHR if node.op is Opcode.MULHS else Opcode.LSHR
    change_operation(rewrite, node, shift, [first, amount])
    return True


def _shift_by_zero(rewrite: Rewrite, node: Node) -> bool:
    first, second = rewrite.operands(node)
    if rewrite.word(first) == 0:
        return rewrite.forward(node.id, first)
    word = rewrite.word(second)
    if word is None or word & _SHIFT_MASK:
        return False
    return rewrite.forward(node.id, first)


def _and_true(rewrite: Rewrite, node: Node) -> bool:
    """`p and 1` is p, and `p or 1` is 1, for a predicate p."""
    first, second = rewrite.operands(node)
    if rewrite.word(second) != 1 or not _is_predicate(rewrite, first):
        return False
    return rewrite.forward(node.id, first if node.op is Opcode.AND else second)


def _is_predicate(rewrite: Rewrite, value: Value) -> bool:
    """Whether every word of `value` is 0 or 1."""
    source = rewrite.nodes[value.src]
    init = _init_word(rewrite, value)
    if value.init is not None and init not in (0, 1):
        return False
    if source.const is not None:
        return source.const <= 1
    return is_comparison(source.op) and not rewrite.predicated(source.id)


def _invert_comparison(rewrite: Rewrite, node: Node) -> bool:
    """`(a < b) xor 1` is the inverse comparison."""
    inner = _inner(rewrite, node)
    if inner is None or rewrite.word(rewrite.operand(node.id, 1)) != 1:
        return False
    if inner.op not in INVERSES or _is_read_as_float(rewrite, node):
        return False
    inverse, swapped = INVERSES[inner.op]
    operands = rewrite.operands(inner)
    change_operation(rewrite, node, inverse, operands[::-1] if swapped else operands)
    return True


def _is_read_as_float(rewrite: Rewrite, node: Node) -> bool:
    """A comparison's result may not feed a port of type f32."""
    ports = ((rewrite.nodes[edge.dst].info.operands, edge.port) for edge in rewrite.uses(node.id))
    return any(0 <= port < len(types) and types[port] is Type.F32 for types, port in ports)


def _double_sign(rewrite: Rewrite, node: Node) -> bool:
    """`-(-x)` is x; `|-x|` and `||x||` are `|x|`."""
    inner = _inner(rewrite, node)
    if inner is None or inner.op not in (Opcode.FNEG, Opcode.FABS):
        return False
    if node.op is Opcode.FABS:
        rewrite.set_operand(node.id, 0, rewrite.operand(inner.id, 0))
        return True
    return inner.op is Opcode.FNEG and rewrite.forward(node.id, rewrite.operand(inner.id, 0))


def _fused_sign(rewrite: Rewrite, node: Node) -> bool:
    """A negated factor or addend of a fused operation is another one's that is not."""
    for port, others in ((0, NEGATED_FACTOR), (1, NEGATED_FACTOR), (2, NEGATED_ADDEND)):
        inner, other = _inner(rewrite, node, port), others.get(node.op)
        if inner is None or inner.op is not Opcode.FNEG or other is None:
            continue
        operands = rewrite.operands(node)
        operands[port] = rewrite.operand(inner.id, 0)
        change_operation(rewrite, node, other, operands)
        return True
    return False


def _copy(rewrite: Rewrite, node: Node) -> bool:
    return rewrite.forward(node.id, rewrite.operand(node.id, 0))


def _select_arm(rewrite: Rewrite, node: Node) -> bool:
    """A select between equal arms, by a constant, between 1 and 0, or between 0 and 1."""
    pred, if_true, if_false = rewrite.operands(node)
    word = rewrite.word(pred)
    if word is not None:
        return rewrite.forward(node.id, if_true if word else if_false)
    if if_true == if_false:
        return rewrite.forward(node.id, if_true)
    arms = rewrite.word(if_true), rewrite.word(if_false)
    if arms == (1, 0) and _is_predicate(rewrite, pred):
        return rewrite.forward(node.id, pred)
    if arms == (0, 1) and _is_predicate(rewrite, pred):
        change_operation(rewrite, node, Opcode.XOR, [pred, if_false])
        return True
    if arms[0] is not None and arms[0] == arms[1]:
        return rewrite.forward_constant(node.id, arms[0])
    return False


def _select_by_inverse(rewrite: Rewrite, node: Node) -> bool:
    """`select(p xor 1, a, b)` is `select(p, b, a)`."""
    inner = _inner(rewrite, node)
    if inner is None or inner.op is not Opcode.XOR:
        return False
    pred, mask = rewrite.operands(inner)
    if rewrite.word(mask) != 1 or not _is_predicate(rewrite, pred):
        return False
    _, if_true, if_false = rewrite.operands(node)
    change_operation(rewrite, node, Opcode.SELECT, [pred, if_false, if_true])
    return True


def _table() -> dict[Opcode, tuple[Identity, ...]]:
    table: dict[Opcode, list[Identity]] = {op: [] for op in SEMANTICS}

    def rows(ops: object, *identities: Identity) -> None:
        assert isinstance(ops, dict | tuple)
        for op in ops:
            table[op].extend(identities)

    rows(tuple(op for op in SEMANTICS if OPCODES[op].commutes), _constant_last)
    rows(_NEUTRAL, _neutral_element)
    rows(_ABSORBING, _absorbing_element)
    rows(_NEUTRAL_F32, _neutral_float)
    rows(_ON_EQUAL, _equal_operands)
    rows((Opcode.XOR,), _invert_comparison)
    rows((Opcode.AND, Opcode.OR), _and_true)
    rows(_ASSOCIATIVE, _nested_constant)
    rows((Opcode.SUB,), _subtract_constant)
    rows((Opcode.MUL,), _multiply_by_power_of_two)
    rows((Opcode.MULHS, Opcode.MULHU), _high_product_by_power_of_two)
    rows((Opcode.SHL, Opcode.LSHR, Opcode.ASHR), _shift_by_zero)
    rows((Opcode.FNEG, Opcode.FABS), _double_sign)
    rows((Opcode.FMA, Opcode.FMS, Opcode.FNMA), _fused_sign)
    rows((Opcode.MOV,), _copy)
    rows((Opcode.SELECT,), _select_arm, _select_by_inverse)
    return {op: tuple(identities) for op, identities in table.items() if identities}


IDENTITIES: Final[dict[Opcode, tuple[Identity, ...]]] = _table()
