"""Values of less than a word, where a whole word serves better: loads that sign-extend by
themselves, and sums that are stored without being cut to size before.

Elsewhere such a value is a word whose upper bits are 0 (see `narrow_int`), and every operation
keeps them so. Run when memory is resolved.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from vividc.frontend.ssa import (
    Int,
    Local,
    Op,
    Operand,
    WideBlock,
    WideFunction,
    WidePhi,
    remove_dead,
    type_of,
    uses,
)

_SMALL = {"i8": 8, "i16": 16}
_WORD = "i32"
_SIGNED = ".signed"
_LOW = ".low"
_EXTREMA = ("llvm.smin.", "llvm.smax.")
_SIGNED_OPS = frozenset({"sext", "sitofp", "ashr", "sdiv", "srem"})
_SIGNED_CALLS = ("llvm.abs.", "llvm.sadd.sat.", "llvm.ssub.sat.")
_UNSIGNED_OPS = frozenset({"zext", "uitofp", "lshr", "udiv", "urem"})
_RING = frozenset({"add", "sub", "mul", "and", "or", "xor"})


def extend_loads(function: WideFunction) -> WideFunction:
    """Let loads, and the phis and selects among them, hold signed words where most uses are signed.

    A use that needs the bits of the small type gets a `trunc`.
    """
    chosen = _signed_values(function)
    if not chosen:
        return function
    rewriter = _SignedWords(function, chosen)
    blocks = tuple(rewriter.block(block) for block in function.blocks)
    return remove_dead(replace(function, blocks=blocks))


def _signed_values(function: WideFunction) -> frozenset[str]:
    """Names of the values to hold sign-extended."""
    members = {name: item for name, item in function.definitions.items() if item.type in _SMALL}
    sources = {name: _merged(item) for name, item in members.items()}
    members = {name: item for name, item in members.items() if sources[name] is not None}
    while lost := [name for name in members if not _only(sources[name], members)]:
        for name in lost:
            del members[name]
    groups = _Groups(members)
    for name in members:
        for operand in sources[name] or ():
            if isinstance(operand, Local):
                groups.join(name, operand.name)
    votes = dict.fromkeys(members, 0)
    for block in function.blocks:
        for op in block.ops:
            for arg in op.args:
                if isinstance(arg, Local) and arg.name in members:
                    votes[groups.root(arg.name)] += _vote(op)
    return frozenset(name for name in members if votes[groups.root(name)] > 0)


def _merged(item: Op | WidePhi) -> tuple[Operand, ...] | None:
    """The values among which a phi, select or extremum chooses; none for a load; None for anything
    else.
    """
    if isinstance(item, WidePhi):
        return tuple(value for _, value in item.incoming)
    if item.op == "select":
        return item.args[1:]
    if item.op == "call" and item.pred.startswith(_EXTREMA):
        return item.args
    return () if item.op == "load" else None


def _only(operands: tuple[Operand, ...] | None, members: dict[str, Op | WidePhi]) -> bool:
    return operands is not None and all(
        isinstance(operand, Int) or (isinstance(operand, Local) and operand.name in members)
        for operand in operands
    )


def _vote(op: Op) -> int:
    """1 if the operation reads its operand as signed, -1 as unsigned, 0 if it does not matter."""
    if op.op == "icmp":
        return {"s": 1, "u": -1}.get(op.pred[0], 0)
    if op.op == "call":
        return 1 if op.pred.startswith((*_EXTREMA, *_SIGNED_CALLS)) else -1
    return int(op.op in _SIGNED_OPS) - int(op.op in _UNSIGNED_OPS)


@dataclass
class _Groups:
    """Disjoint sets of names."""

    parent: dict[str, str]

    def __init__(self, names: dict[str, Op | WidePhi]) -> None:
        self.parent = {name: name for name in names}

    def root(self, name: str) -> str:
        """The name that stands for the set of `name`."""
        while self.parent[name] != name:
            name = self.parent[name]
        return name

    def join(self, one: str, other: str) -> None:
        """Make one set of two."""
        self.parent[self.root(one)] = self.root(other)


@dataclass
class _SignedWords:
    """Rewrites the chosen values, each to a word called `name` + ".signed", and their uses."""

    function: WideFunction
    chosen: frozenset[str]

    def block(self, block: WideBlock) -> WideBlock:
        """One block; the small value of a phi is cut from its word behind all phis."""
        phis: list[WidePhi] = []
        ops: list[Op] = []
        for phi in block.phis:
            if phi.name not in self.chosen:
                phis.append(phi)
                continue
            incoming = tuple((pred, self.word(value, phi.type)) for pred, value in phi.incoming)
            phis.append(WidePhi(phi.name + _SIGNED, _WORD, incoming, phi.loc))
            ops.append(_cut(phi))
        for op in block.ops:
            ops.extend(self.rewritten(op))
        return replace(block, phis=tuple(phis), ops=tuple(ops))

    def rewritten(self, op: Op) -> Iterator[Op]:
        """The operation on words, and for a chosen value its small form."""
        if op.name in self.chosen:
            args = op.args
            if op.op == "select":
                args = (args[0], *(self.word(arg, op.type) for arg in args[1:]))
            elif op.op == "call":
                args = tuple(self.word(arg, op.type) for arg in args)
            pred = op.pred.replace(op.type, _WORD)
            is_load = op.op == "load"
            name = op.name + _SIGNED
            yield replace(op, name=name, type=_WORD, args=args, pred=pred, signed=is_load)
            yield _cut(op)
        else:
            yield self.use(op)

    def use(self, op: Op) -> Op:
        """The operation with words for its chosen operands, where that is possible."""
        if op.op == "icmp" and op.type in _SMALL and all(map(self.has_word, op.args)):
            args = tuple(self.word(arg, op.type) for arg in op.args)
            return replace(op, type=_WORD, args=args)
        if not op.args or not self.is_chosen(op.args[0]):
            return op
        if op.op == "store":
            word = self.word(op.args[0], op.type)
            return replace(op, type=_WORD, args=(word, *op.args[1:]))
        if op.op not in ("sext", "sitofp", "trunc"):
            return op
        args = (self.word(op.args[0], op.source),)
        if op.op == "sext" and op.type == _WORD:
            return replace(op, op="freeze", args=args, source="")
        opcode = "trunc" if op.op == "sext" and op.type in _SMALL else op.op
        return replace(op, op=opcode, args=args, source=_WORD)

    def is_chosen(self, operand: Operand) -> bool:
        """Whether the operand is held as a signed word."""
        return isinstance(operand, Local) and operand.name in self.chosen

    def has_word(self, operand: Operand) -> bool:
        """Whether a signed word costs nothing."""
        return isinstance(operand, Int) or self.is_chosen(operand)

    def word(self, operand: Operand, type_: str) -> Operand:
        """The signed word of a chosen value or constant."""
        if isinstance(operand, Int):
            half = 1 << _SMALL[type_] - 1
            return Int((operand.value + half) % (2 * half) - half)
        assert isinstance(operand, Local)
        return Local(operand.name + _SIGNED)


def _cut(item: Op | WidePhi) -> Op:
    word = Local(item.name + _SIGNED)
    return Op(item.name, "trunc", item.type, (word,), source=_WORD, loc=item.loc)


def store_low_bits(function: WideFunction) -> WideFunction:
    """Compute what is only stored in fewer bits in words: the store leaves the upper bits out."""
    counts: dict[str, int] = {}
    for block in function.blocks:
        for operand in uses(block):
            if isinstance(operand, Local):
                counts[operand.name] = counts.get(operand.name, 0) + 1
    low = _LowWords(function, counts)
    stores = [op for block in function.blocks for op in block.ops if _is_narrow_store(op)]
    if not stores:
        return function
    values = {op: low.word(op.args[0]) for op in stores}
    blocks = tuple(
        replace(block, ops=tuple(new for op in block.ops for new in low.placed(op, values)))
        for block in function.blocks
    )
    return remove_dead(replace(function, blocks=blocks))


def _is_narrow_store(op: Op) -> bool:
    return op.op == "store" and op.type in _SMALL


@dataclass
class _LowWords:
    """Words whose low bits are those of small values, made on demand next to the values.

    Attributes
    ----------
    counts
        Uses of each name: an operation with several is kept, rather than computed twice.
    added
        Operations to place behind the definition of each name.
    """

    function: WideFunction
    counts: dict[str, int]
    added: dict[str, Op] = field(default_factory=dict)

    def word(self, operand: Operand) -> Operand:
        """A word with the operand's bits, and anything above them."""
        if not isinstance(operand, Local):
            return operand
        type_ = type_of(self.function, operand)
        if type_ not in _SMALL:
            return operand
        definition = self.function.definitions.get(operand.name)
        if not isinstance(definition, Op):
            return operand
        if operand.name not in self.added:
            made = self.made(definition)
            if made is None:
                return operand
            self.added[operand.name] = made
        return Local(operand.name + _LOW)

    def made(self, op: Op) -> Op | None:
        """The operation in words; None if its result is cheapest as it is."""
        name = op.name + _LOW
        if op.op == "trunc":
            opcode = "trunc" if op.source == "i64" else "freeze"
            return replace(op, name=name, op=opcode, type=_WORD, args=(self.word(op.args[0]),))
        if self.counts.get(op.name, 0) > 1:
            return None
        if op.op in _RING:
            return replace(op, name=name, type=_WORD, args=tuple(map(self.word, op.args)))
        if op.op == "select":
            args = (op.args[0], *map(self.word, op.args[1:]))
            return replace(op, name=name, type=_WORD, args=args)
        return None

    def placed(self, op: Op, values: dict[Op, Operand]) -> Iterator[Op]:
        """The operation, a store with its word, and behind it the word it got."""
        if op in values:
            yield replace(op, type=_WORD, args=(values[op], *op.args[1:]))
            return
        yield op
        if op.name in self.added:
            yield self.added[op.name]
