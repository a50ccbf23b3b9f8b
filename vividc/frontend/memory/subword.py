"""Values of less than a word, where a whole word serves better: loads that sign-extend by
themselves, and sums that are stored without being cut to size before.

Elsewhere such a value is a word whose upper bits are 0 (see `narrow.integer`), and every operation
keeps them so. Run when memory is resolved.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from vividc.frontend.llvm.ir import (
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
_WORD_BYTES = 4
_SIGNED = ".signed"
_LOW = ".low"
_EXTREMA = ("llvm.smin.", "llvm.smax.")
_SIGNED_OPS = frozenset({"sext", "sitofp", "ashr", "sdiv", "srem"})
_SIGNED_CALLS = ("llvm.abs.", "llvm.sadd.sat.", "llvm.ssub.sat.")
_UNSIGNED_OPS = frozenset({"zext", "uitofp", "lshr", "udiv", "urem"})
_RING = frozenset({"add", "sub", "mul", "and", "or", "xor"})


def extend_loads(function: WideFunction) -> WideFunction:
    """Let loads, and the phis and selects among them, hold signed words where most uses are signed.

    A use that needs the bits of the small type gets a `trunc`; a returned value needs none.
    """
    chosen = _signed_values(function)
    if not chosen:
        return function
    rewriter = _SignedWords(chosen, _read_by_phis(function, chosen))
    return replace(function, blocks=tuple(rewriter.block(block) for block in function.blocks))


def _read_by_phis(function: WideFunction, chosen: dict[str, str]) -> dict[str, tuple[WidePhi, ...]]:
    found: dict[str, tuple[WidePhi, ...]] = {}
    for block in function.blocks:
        for phi in block.phis:
            for pred, value in phi.incoming:
                if phi.name not in chosen and isinstance(value, Local) and value.name in chosen:
                    found[pred] = (*found.get(pred, ()), phi)
    return found


def _signed_values(function: WideFunction) -> dict[str, str]:
    """Small type of each value to hold sign-extended."""
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
    return {name: item.type for name, item in members.items() if votes[groups.root(name)] > 0}


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
    """Rewrites the chosen values, each to a word called `name` + ".signed", and their uses.

    Where the small value is read it is cut from its word, in the reading block: a loop need not
    cut what is read behind it.

    Attributes
    ----------
    chosen
        Small type of each chosen value.
    read_by_phis
        By block, the phis that read a chosen value from there and are not chosen themselves.
    """

    chosen: dict[str, str]
    read_by_phis: dict[str, tuple[WidePhi, ...]]
    cuts: int = 0

    def block(self, block: WideBlock) -> WideBlock:
        """One block."""
        ops = [new for op in block.ops for new in self.rewritten(op)]
        for phi in self.read_by_phis.get(block.name, ()):
            value = dict(phi.incoming)[block.name]
            assert isinstance(value, Local)
            ops.append(self.cut(value, _cut_name(phi, block.name), phi))
        leave = block.exit
        if leave.value is not None and self.has_word(leave.value):
            leave = replace(leave, value=self.word(leave.value))
        return WideBlock(block.name, tuple(map(self.phi, block.phis)), tuple(ops), leave)

    def phi(self, phi: WidePhi) -> WidePhi:
        """The phi on words if it is chosen, else on what its predecessors cut for it."""
        if phi.name in self.chosen:
            words = tuple((pred, self.word(value, phi.type)) for pred, value in phi.incoming)
            return WidePhi(phi.name + _SIGNED, _WORD, words, phi.loc)
        incoming = tuple(
            (pred, Local(_cut_name(phi, pred)) if self.has_word(value) else value)
            for pred, value in phi.incoming
        )
        return replace(phi, incoming=incoming)

    def rewritten(self, op: Op) -> Iterator[Op]:
        """The operation on words, behind the cuts that it needs."""
        if op.name in self.chosen:
            first = 1 if op.op == "select" else 0
            words = () if op.op == "load" else tuple(self.word(a, op.type) for a in op.args[first:])
            yield replace(
                op,
                name=op.name + _SIGNED,
                type=_WORD,
                args=op.args if op.op == "load" else (*op.args[:first], *words),
                pred=op.pred.replace(op.type, _WORD),
                signed=op.op == "load",
            )
            return
        op = self.use(op)
        args: list[Operand] = []
        for arg in op.args:
            if isinstance(arg, Local) and self.has_word(arg):
                self.cuts += 1
                yield self.cut(arg, f"{arg.name}.cut{self.cuts}", op)
                args.append(Local(f"{arg.name}.cut{self.cuts}"))
            else:
                args.append(arg)
        yield replace(op, args=tuple(args))

    def use(self, op: Op) -> Op:
        """The operation with words for its chosen operands, where that is possible."""
        if op.op == "icmp":
            return self.comparison(op)
        if not op.args or not self.has_word(op.args[0]):
            return op
        word = self.word(op.args[0])
        if op.op == "store":
            return replace(op, type=_WORD, args=(word, *op.args[1:]))
        if op.op not in ("sext", "sitofp", "trunc"):
            return op
        opcode = "trunc" if op.op == "sext" and op.type in _SMALL else op.op
        if op.op == "sext" and op.type == _WORD:
            opcode = "freeze"
        return replace(op, op=opcode, args=(word,), source=_WORD)

    def comparison(self, op: Op) -> Op:
        """Sign extension keeps the order of signed numbers and that of unsigned ones."""
        chosen = [self.has_word(arg) for arg in op.args]
        constant = [isinstance(arg, Int) for arg in op.args]
        if not any(chosen) or not all(a or b for a, b in zip(chosen, constant, strict=True)):
            return op
        args = tuple(self.word(arg, op.type) for arg in op.args)
        return replace(op, type=_WORD, args=args)

    def has_word(self, operand: Operand) -> bool:
        """Whether the operand is held as a signed word."""
        return isinstance(operand, Local) and operand.name in self.chosen

    def word(self, operand: Operand, type_: str = "") -> Operand:
        """The signed word of a chosen value, or of a constant of the small type `type_`."""
        if isinstance(operand, Int):
            half = 1 << _SMALL[type_] - 1
            return Int((operand.value + half) % (2 * half) - half)
        assert isinstance(operand, Local)
        return Local(operand.name + _SIGNED)

    def cut(self, value: Local, name: str, user: Op | WidePhi) -> Op:
        """The small value as `name`."""
        word = self.word(value)
        return Op(name, "trunc", self.chosen[value.name], (word,), source=_WORD, loc=user.loc)


def _cut_name(phi: WidePhi, pred: str) -> str:
    return f"{phi.name}.cut.{pred}"


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
    return op.op == "store" and op.width < _WORD_BYTES


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
        if op.op == "shl" and isinstance(op.args[1], Int):
            return replace(op, name=name, type=_WORD, args=(self.word(op.args[0]), op.args[1]))
        return None

    def placed(self, op: Op, values: dict[Op, Operand]) -> Iterator[Op]:
        """The operation, a store with its word, and behind it the word it got."""
        if op in values:
            yield replace(op, type=_WORD, args=(values[op], *op.args[1:]))
            return
        yield op
        if op.name in self.added:
            yield self.added[op.name]
