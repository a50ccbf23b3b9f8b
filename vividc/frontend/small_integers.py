"""Operations on integers of less than a word, written as operations on words.

A value of i2 .. i31 is a word whose upper bits are 0 (see `narrow_int`). Sums, products and logic
in such types stay as they are; what depends on the sign, or brings in bits from above, is computed
here from extended operands and cut to size again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from vividc.frontend.ssa import Int, Local, Op, Operand, WideFunction

_WORD = "i32"
_WORD_BITS = 32
_SIGNED = frozenset({"ashr", "sdiv", "srem"})
_UNSIGNED = frozenset({"lshr", "udiv", "urem", "shl"})
_SIGNED_CALLS = frozenset({"smin", "smax", "abs"})
_UNSIGNED_CALLS = frozenset({"umin", "umax", "usub.sat", "ctpop"})


def compute_in_words(function: WideFunction) -> WideFunction:
    """Rewrite every operation on a small type that has a rule here; others stay."""
    blocks = tuple(
        replace(block, ops=tuple(new for op in block.ops for new in _rewritten(op)))
        for block in function.blocks
    )
    return function if blocks == function.blocks else replace(function, blocks=blocks)


def is_computed_in_words(op: Op) -> bool:
    """Whether `compute_in_words` replaces the operation."""
    return _rule(op) is not None


@dataclass
class _Words:
    """The operations that replace `op`, in order."""

    op: Op
    ops: list[Op]

    @property
    def bits(self) -> int:
        """Bits of the small type."""
        return int(self.op.type[1:])

    def emit(self, opcode: str, *args: Operand, type_: str = _WORD, source: str = "") -> Operand:
        """A new operation."""
        name = f"{self.op.name}.w{len(self.ops)}"
        self.ops.append(Op(name, opcode, type_, args, source=source, loc=self.op.loc))
        return Local(name)

    def call(self, stem: str, *args: Operand) -> Operand:
        """A call of an intrinsic on words."""
        name = f"{self.op.name}.w{len(self.ops)}"
        callee = f"llvm.{stem}.{_WORD}"
        self.ops.append(Op(name, "call", _WORD, args, pred=callee, loc=self.op.loc))
        return Local(name)

    def extended(self, operand: Operand, *, signed: bool) -> Operand:
        """The word of an operand's value."""
        if not isinstance(operand, Int):
            opcode = "sext" if signed else "zext"
            return self.emit(opcode, operand, source=self.op.type)
        half = 1 << self.bits - 1
        low = operand.value % (2 * half)
        return Int(low - 2 * half if signed and low >= half else low)

    def cut(self, word: Operand) -> None:
        """`op`'s result is the low bits of `word`."""
        self.ops.append(replace(self.op, op="trunc", args=(word,), pred="", source=_WORD))

    def name(self, word: Operand) -> None:
        """`op`'s result is `word`, which has no upper bits."""
        self.ops.append(replace(self.op, op="freeze", args=(word,), pred=""))


_Rule = Callable[[_Words], None]


def _rewritten(op: Op) -> Iterator[Op]:
    rule = _rule(op)
    if rule is None:
        yield op
        return
    words = _Words(op, [])
    rule(words)
    yield from words.ops


def _is_small(type_: str) -> bool:
    return type_[:1] == "i" and type_[1:].isdigit() and 1 < int(type_[1:]) < _WORD_BITS


def _rule(op: Op) -> _Rule | None:
    if op.op == "sitofp":
        return _to_float if _is_small(op.source) else None
    if not _is_small(op.type):
        return None
    if op.op in _CONVERSIONS:
        return _CONVERSIONS[op.op]
    if op.op == "icmp":
        return _compare if op.pred[0] == "s" else None
    if op.op in _SIGNED or op.op in _UNSIGNED:
        return _operation
    return _call_rule(op) if op.op == "call" and op.pred.startswith("llvm.") else None


def _call_rule(op: Op) -> _Rule | None:
    stem = _stem(op)
    if stem in _SIGNED_CALLS or stem in _UNSIGNED_CALLS:
        return _intrinsic
    if stem in ("fshl", "fshr") and not isinstance(op.args[2], Int):
        return None
    if stem == "bswap" and op.type != "i16":
        return None
    return _CALLS.get(stem)


def _stem(op: Op) -> str:
    return op.pred.removeprefix("llvm.").rsplit(".", 1)[0]


def _compare(words: _Words) -> None:
    """With its sign bit turned over, a signed number is ordered as an unsigned one."""
    op = words.op
    sign = 1 << words.bits - 1
    args = tuple(
        Int((arg.value ^ sign) % (2 * sign))
        if isinstance(arg, Int)
        else words.emit("xor", arg, Int(sign), type_=op.type)
        for arg in op.args
    )
    words.ops.append(replace(op, args=args, pred="u" + op.pred[1:]))


def _operation(words: _Words) -> None:
    """Shifts by the type's bits or more give poison in LLVM, so their amounts need no care."""
    op = words.op
    signed = op.op in _SIGNED
    left = words.extended(op.args[0], signed=signed)
    right = words.extended(op.args[1], signed=signed and op.op != "ashr")
    word = words.emit(op.op, left, right)
    (words.cut if signed or op.op == "shl" else words.name)(word)


def _to_float(words: _Words) -> None:
    op = words.op
    word = words.emit("sext", *op.args, source=op.source)
    words.ops.append(replace(op, args=(word,), source=_WORD))


def _from_float(words: _Words) -> None:
    """What the small type cannot hold is poison in LLVM, and a signed word holds what it can."""
    words.cut(words.emit("fptosi", *words.op.args, source=words.op.source))


def _intrinsic(words: _Words) -> None:
    stem = _stem(words.op)
    count = 1 if stem in ("abs", "ctpop") else 2
    signed = stem in _SIGNED_CALLS
    args = [words.extended(arg, signed=signed) for arg in words.op.args[:count]]
    word = words.call(stem, *args, *words.op.args[count:])
    (words.cut if signed else words.name)(word)


def _saturating(opcode: str, *, signed: bool) -> _Rule:
    """The exact sum or difference fits in a word; it is clipped to the small type there."""

    def rule(words: _Words) -> None:
        left, right = (words.extended(arg, signed=signed) for arg in words.op.args)
        total = words.emit(opcode, left, right)
        half = 1 << words.bits - 1
        high = words.call("smin", total, Int(half - 1 if signed else 2 * half - 1))
        if signed:
            words.cut(words.call("smax", high, Int(-half)))
        else:
            words.name(high)

    return rule


def _funnel(*, left: bool) -> _Rule:
    """fshl, fshr by a constant, which counts modulo the type's bits."""

    def rule(words: _Words) -> None:
        high, low, amount = words.op.args
        assert isinstance(amount, Int)
        by = amount.value % words.bits
        if not left:
            by = words.bits - by
        # By 0 all comes from `high`, by all bits (fshr by 0) from `low`.
        up = words.emit("shl", words.extended(high, signed=False), Int(by))
        down = words.emit("lshr", words.extended(low, signed=False), Int(words.bits - by))
        words.cut(words.emit("or", up, down))

    return rule


def _swap_bytes(words: _Words) -> None:
    word = words.extended(words.op.args[0], signed=False)
    up, down = words.emit("shl", word, Int(8)), words.emit("lshr", word, Int(8))
    words.cut(words.emit("or", up, down))


def _sign_extend(words: _Words) -> None:
    """The bits above the wider type must be 0 again."""
    words.cut(words.emit("sext", *words.op.args, source=words.op.source))


_CONVERSIONS: dict[str, _Rule] = {
    "sext": _sign_extend,
    "fptosi": _from_float,
    "fptoui": _from_float,
}
_CALLS: dict[str, _Rule] = {
    "sadd.sat": _saturating("add", signed=True),
    "ssub.sat": _saturating("sub", signed=True),
    "uadd.sat": _saturating("add", signed=False),
    "fshl": _funnel(left=True),
    "fshr": _funnel(left=False),
    "bswap": _swap_bytes,
}
