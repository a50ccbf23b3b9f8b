"""Values of less than a word, where a whole word serves better: loads that sign-extend by
themselves, and sums that are stored without being cut to size before.

Elsewhere such a value is a word whose upper bits are 0 (see `narrow.integer`), and every operation
keeps them so. Run when memory is resolved.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field, replace

from vividc.ssa.edit import FreshIds, read_values
from vividc.ssa.ir import Block, Function, Instr, Int, Kind, Phi, Ref, Value, type_of
from vividc.ssa.rewrite.dead import remove_unused

_SMALL = {"i8": 8, "i16": 16}
_I32 = "i32"
_WORD_BYTES = 4
_EXTREMA = ("llvm.smin.", "llvm.smax.")
_SIGNED_OPS = frozenset({"sext", "sitofp", "ashr", "sdiv", "srem"})
_SIGNED_CALLS = ("llvm.abs.", "llvm.sadd.sat.", "llvm.ssub.sat.")
_UNSIGNED_OPS = frozenset({"zext", "uitofp", "lshr", "udiv", "urem"})
_RING = frozenset({"add", "sub", "mul", "and", "or", "xor"})


def extend_loads(function: Function) -> Function:
    """Let loads, and the phis and selects among them, hold signed words where most uses are signed.

    A use that needs the bits of the small type gets a `trunc`; a returned value needs none.
    """
    chosen = _signed_values(function)
    if not chosen:
        return function
    rewriter = _SignedWords(chosen, _read_by_phis(function, chosen), FreshIds(function))
    return replace(function, blocks=tuple(rewriter.block(block) for block in function.blocks))


def _read_by_phis(function: Function, chosen: dict[int, str]) -> dict[str, tuple[Phi, ...]]:
    feeding: dict[str, tuple[Phi, ...]] = {}
    for block in function.blocks:
        for phi in block.phis:
            for pred, value in phi.incoming:
                if phi.id not in chosen and isinstance(value, Ref) and value.id in chosen:
                    feeding[pred] = (*feeding.get(pred, ()), phi)
    return feeding


def _signed_values(function: Function) -> dict[int, str]:
    """Small type of each value to hold sign-extended."""
    small = [item for block in function.blocks for item in block.items if item.type in _SMALL]
    sources = {item.id: merged for item in small if (merged := _merged(item)) is not None}
    while lost := [id_ for id_, values in sources.items() if not _only(values, sources)]:
        for id_ in lost:
            del sources[id_]
    groups = _Groups(sources)
    for id_, values in sources.items():
        for value in values:
            if isinstance(value, Ref):
                groups.join(id_, value.id)
    votes = dict.fromkeys(sources, 0)
    for block in function.blocks:
        for op in block.instrs:
            for arg in op.operands:
                if isinstance(arg, Ref) and arg.id in sources:
                    votes[groups.root(arg.id)] += _vote(op)
    return {
        item.id: str(item.type)
        for item in small
        if item.id in sources and votes[groups.root(item.id)] > 0
    }


def _merged(item: Instr | Phi) -> tuple[Value, ...] | None:
    """The values among which a phi, select or extremum chooses; none for a load; None for anything
    else.
    """
    if isinstance(item, Phi):
        return tuple(value for _, value in item.incoming)
    if item.op == "select":
        return item.operands[1:]
    if item.op == "call" and item.pred.startswith(_EXTREMA):
        return item.operands
    return () if item.op == "load" else None


def _only(values: tuple[Value, ...], members: Collection[int]) -> bool:
    return all(
        isinstance(value, Int) or (isinstance(value, Ref) and value.id in members)
        for value in values
    )


def _vote(op: Instr) -> int:
    """1 if the operation reads its operand as signed, -1 as unsigned, 0 if it does not matter."""
    if op.op == "icmp":
        return {"s": 1, "u": -1}.get(op.pred[0], 0)
    if op.op == "call":
        return 1 if op.pred.startswith((*_EXTREMA, *_SIGNED_CALLS)) else -1
    return int(op.op in _SIGNED_OPS) - int(op.op in _UNSIGNED_OPS)


class _Groups:
    """Disjoint sets of ids."""

    def __init__(self, ids: Iterable[int]) -> None:
        self._parent = {id_: id_ for id_ in ids}

    def root(self, id_: int) -> int:
        """The id that stands for the set of `id_`."""
        while self._parent[id_] != id_:
            id_ = self._parent[id_]
        return id_

    def join(self, one: int, other: int) -> None:
        """Make one set of two."""
        self._parent[self.root(one)] = self.root(other)


@dataclass
class _SignedWords:
    """Rewrites the chosen values, each to a signed word, and their uses.

    Where the small value is read it is cut from its word, in the reading block: a loop need not
    cut what is read behind it.

    Attributes
    ----------
    chosen
        Small type of each chosen value.
    read_by_phis
        By block, the phis that read a chosen value from there and are not chosen themselves.
    """

    chosen: dict[int, str]
    read_by_phis: dict[str, tuple[Phi, ...]]
    ids: FreshIds

    def block(self, block: Block) -> Block:
        """One block."""
        ops = [new for op in block.instrs for new in self.rewritten(op)]
        for phi in self.read_by_phis.get(block.name, ()):
            value = dict(phi.incoming)[block.name]
            assert isinstance(value, Ref)
            ops.append(self.cut(value, self.ids(phi.id, block.name), phi))
        leave = block.branch
        if leave.value is not None and self.has_word(leave.value):
            leave = replace(leave, value=self.word(leave.value))
        return Block(block.name, tuple(map(self.phi, block.phis)), tuple(ops), leave)

    def phi(self, phi: Phi) -> Phi:
        """The phi on words if it is chosen, else on what its predecessors cut for it."""
        if phi.id in self.chosen:
            words = tuple((pred, self.word(value, phi.type)) for pred, value in phi.incoming)
            return Phi(self.ids(phi.id), _I32, words, phi.loc)
        incoming = tuple(
            (pred, Ref(self.ids(phi.id, pred)) if self.has_word(value) else value)
            for pred, value in phi.incoming
        )
        return replace(phi, incoming=incoming)

    def rewritten(self, op: Instr) -> Iterator[Instr]:
        """The operation on words, behind the cuts that it needs."""
        if op.id in self.chosen:
            first = 1 if op.op == "select" else 0
            words = (
                () if op.op == "load" else tuple(self.word(a, op.type) for a in op.operands[first:])
            )
            yield replace(
                op,
                id=self.ids(op.id),
                type=_I32,
                operands=op.operands if op.op == "load" else (*op.operands[:first], *words),
                pred=op.pred.replace(str(op.type), _I32),
                signed=op.op == "load",
            )
            return
        op = self.use(op)
        args: list[Value] = []
        for arg in op.operands:
            if isinstance(arg, Ref) and self.has_word(arg):
                cut = self.cut(arg, self.ids(), op)
                yield cut
                args.append(Ref(cut.id))
            else:
                args.append(arg)
        yield replace(op, operands=tuple(args))

    def use(self, op: Instr) -> Instr:
        """The operation with words for its chosen operands, where that is possible."""
        if op.op == "icmp":
            return self.comparison(op)
        if not op.operands or not self.has_word(op.operands[0]):
            return op
        word = self.word(op.operands[0])
        if op.op == "store":
            return replace(op, type=_I32, operands=(word, *op.operands[1:]))
        if op.op not in ("sext", "sitofp", "trunc"):
            return op
        opcode = "trunc" if op.op == "sext" and op.type in _SMALL else op.op
        if op.op == "sext" and op.type == _I32:
            opcode = "freeze"
        return replace(op, op=opcode, operands=(word,), source=_I32)

    def comparison(self, op: Instr) -> Instr:
        """Sign extension keeps the order of signed numbers and that of unsigned ones."""
        chosen = [self.has_word(arg) for arg in op.operands]
        constant = [isinstance(arg, Int) for arg in op.operands]
        if not any(chosen) or not all(a or b for a, b in zip(chosen, constant, strict=True)):
            return op
        args = tuple(self.word(arg, op.type) for arg in op.operands)
        return replace(op, type=_I32, operands=args)

    def has_word(self, operand: Value) -> bool:
        """Whether the operand is held as a signed word."""
        return isinstance(operand, Ref) and operand.id in self.chosen

    def word(self, operand: Value, type_: Kind = "") -> Value:
        """The signed word of a chosen value, or of a constant of the small type `type_`."""
        if isinstance(operand, Int):
            half = 1 << _SMALL[str(type_)] - 1
            return Int((operand.value + half) % (2 * half) - half)
        assert isinstance(operand, Ref)
        return Ref(self.ids(operand.id))

    def cut(self, value: Ref, id_: int, user: Instr | Phi) -> Instr:
        """The small value with an id of its own."""
        word = self.word(value)
        return Instr(id_, "trunc", self.chosen[value.id], (word,), source=_I32, loc=user.loc)


def store_low_bits(function: Function) -> Function:
    """Compute what is only stored in fewer bits in words: the store leaves the upper bits out."""
    counts: dict[int, int] = {}
    for block in function.blocks:
        for operand in read_values(block):
            if isinstance(operand, Ref):
                counts[operand.id] = counts.get(operand.id, 0) + 1
    low = _LowWords(function, counts, FreshIds(function))
    stores = [op for block in function.blocks for op in block.instrs if _is_narrow_store(op)]
    if not stores:
        return function
    values = {op: low.word(op.operands[0]) for op in stores}
    blocks = tuple(
        replace(block, instrs=tuple(new for op in block.instrs for new in low.placed(op, values)))
        for block in function.blocks
    )
    return remove_unused(replace(function, blocks=blocks))


def _is_narrow_store(op: Instr) -> bool:
    return op.op == "store" and op.width < _WORD_BYTES


@dataclass
class _LowWords:
    """Words whose low bits are those of small values, made on demand next to the values.

    Attributes
    ----------
    counts
        Uses of each result: an operation with several is kept, rather than computed twice.
    added
        Operations to place behind the definition of each result.
    """

    function: Function
    counts: dict[int, int]
    ids: FreshIds
    added: dict[int, Instr] = field(default_factory=dict)

    def word(self, operand: Value) -> Value:
        """A word with the operand's bits, and anything above them."""
        if not isinstance(operand, Ref):
            return operand
        type_ = type_of(self.function, operand)
        if type_ not in _SMALL:
            return operand
        definition = self.function.definitions.get(operand.id)
        if not isinstance(definition, Instr):
            return operand
        if operand.id not in self.added:
            made = self.made(definition)
            if made is None:
                return operand
            self.added[operand.id] = made
        return Ref(self.ids(operand.id))

    def made(self, op: Instr) -> Instr | None:
        """The operation in words; None if its result is cheapest as it is."""
        id_ = self.ids(op.id)
        if op.op == "trunc":
            opcode = "trunc" if op.source == "i64" else "freeze"
            return replace(op, id=id_, op=opcode, type=_I32, operands=(self.word(op.operands[0]),))
        if self.counts.get(op.id, 0) > 1:
            return None
        if op.op in _RING:
            return replace(op, id=id_, type=_I32, operands=tuple(map(self.word, op.operands)))
        if op.op == "select":
            args = (op.operands[0], *map(self.word, op.operands[1:]))
            return replace(op, id=id_, type=_I32, operands=args)
        if op.op == "shl" and isinstance(op.operands[1], Int):
            return replace(
                op, id=id_, type=_I32, operands=(self.word(op.operands[0]), op.operands[1])
            )
        return None

    def placed(self, op: Instr, values: dict[Instr, Value]) -> Iterator[Instr]:
        """The operation, a store with its word, and behind it the word it got."""
        if op in values:
            yield replace(op, type=_I32, operands=(values[op], *op.operands[1:]))
            return
        yield op
        if op.id in self.added:
            yield self.added[op.id]
