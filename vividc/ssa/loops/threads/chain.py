"""Straight code being written, block after block, for several threads side by side."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

from vividc.errors import SourceLoc
from vividc.machine.compare import INVERSES
from vividc.machine.lanes import Lane
from vividc.machine.opcodes import OPCODES, Opcode, Type
from vividc.ssa.ir import Block, Branch, Const, Instr, Kind, Phi, Ref, Undefined, Value

_Key = tuple[Opcode, tuple[Value, ...]]


@dataclass
class _Open:
    """A block under way; its phis' later inputs come when the loop that it heads is closed."""

    name: str
    phis: list[Phi] = field(default_factory=list)
    instrs: list[Instr] = field(default_factory=list)
    branch: Branch | None = None


class Chain:
    """Blocks, the last of which is open. An operation that is known at a place is not repeated.

    Parameters
    ----------
    first_id
        Of the values that it defines.
    regions
        Headers of the loops written, which the lanes of accesses name.
    """

    def __init__(self, first_id: int, regions: tuple[str, ...]) -> None:
        self._free = first_id
        self._regions = regions
        self._blocks: list[_Open] = []
        self._known: dict[_Key, Value] = {}
        self._made: dict[int, Instr] = {}
        self._lane: Lane | None = None
        self._parts: dict[tuple[int, int], int] = {}
        self._loc: SourceLoc | None = None

    @property
    def block(self) -> str:
        """Name of the open block."""
        return self._blocks[-1].name

    def open(self, name: str) -> None:
        """Start a block."""
        self._blocks.append(_Open(name))

    def close(self, branch: Branch) -> str:
        """End the open block; its name."""
        self._blocks[-1].branch = branch
        return self.block

    def phi(self, kind: Kind, *incoming: tuple[str, Value], loc: SourceLoc | None = None) -> Phi:
        """A phi of the open block; more inputs may be given later."""
        phi = Phi(self.fresh(), kind, incoming, loc)
        self._blocks[-1].phis.append(phi)
        return phi

    def extend(self, phi: Phi, source: str, value: Value) -> None:
        """Give a phi one more input."""
        for block in self._blocks:
            for index, old in enumerate(block.phis):
                if old.id == phi.id:
                    block.phis[index] = replace(old, incoming=(*old.incoming, (source, value)))

    def fresh(self) -> int:
        """An id of its own."""
        self._free += 1
        return self._free - 1

    @contextmanager
    def thread(self, number: int, origin: int, loc: SourceLoc | None = None) -> Iterator[None]:
        """What is written meanwhile is the thread's, for the value of this id."""
        before = self._lane, self._loc
        self._lane, self._loc = Lane(number, origin, 0, self._regions), loc or self._loc
        try:
            yield
        finally:
            self._lane, self._loc = before

    @contextmanager
    def scope(self) -> Iterator[None]:
        """What is written meanwhile may not be known afterwards."""
        before = dict(self._known)
        try:
            yield
        finally:
            self._known = before

    def emit(self, op: Opcode, kind: Kind, *operands: Value) -> Value:
        """One more operation, or the same one of before."""
        return self.copy(Instr(0, op, kind, operands, loc=self._loc))

    def copy(self, instr: Instr) -> Value:
        """`instr` with an id of its own; accesses to memory are always new."""
        key = _key(instr)
        lane = self._next_lane()
        if instr.array or key not in self._known:
            made = replace(instr, id=self.fresh(), lane=lane)
            self._blocks[-1].instrs.append(made)
            self._made[made.id] = made
            if instr.array:
                return Ref(made.id)
            self._known[key] = Ref(made.id)
        return self._known[key]

    def inverted(self, value: Value) -> Value:
        """The predicate that is 1 where `value` is 0."""
        if isinstance(value, Const):
            return Const(1 - value.word)
        made = self._made.get(value.id) if isinstance(value, Ref) else None
        inverse = INVERSES.get(made.opcode) if made is not None else None
        if made is None or inverse is None:
            return self.emit(Opcode.XOR, Type.PRED, value, Const(1))
        left, right = made.operands
        return self.emit(inverse[0], Type.PRED, *((right, left) if inverse[1] else (left, right)))

    def both(self, left: Value | None, right: Value | None) -> Value | None:
        """Conjunction of predicates; None stands for 1."""
        if left is None or right is None:
            return right if left is None else left
        return left if left == right else self.emit(Opcode.AND, Type.PRED, left, right)

    def either(self, left: Value | None, right: Value | None) -> Value | None:
        """Disjunction of predicates; None stands for 1."""
        if left is None or right is None:
            return None
        return left if left == right else self.emit(Opcode.OR, Type.PRED, left, right)

    def unless(self, stop: Value | None, wanted: Value | None) -> Value | None:
        """`wanted` where `stop` is 0; None as `stop` stands for 0."""
        if stop is None or stop == Const(0):
            return wanted
        if wanted is None:
            return self.inverted(stop)
        return self.emit(Opcode.ICMP_ULT, Type.PRED, stop, wanted)

    def select(self, when: Value | None, then: Value, other: Value, kind: Kind) -> Value:
        """`then` where `when` is 1, else `other`."""
        if when is None or then == other or isinstance(other, Undefined):
            return then
        return other if isinstance(then, Undefined) else self._choice(when, then, other, kind)

    def keep_unless(self, stop: Value, value: Value, kept: Value, kind: Kind) -> Value:
        """`kept` where `stop` is 1, else `value`.

        If `value` is itself a choice whose other arm is `kept`, one choice serves both.
        """
        made = self._made.get(value.id) if isinstance(value, Ref) else None
        if made is not None and made.op is Opcode.SELECT and made.operands[2] == kept:
            when = self.unless(stop, made.operands[0])
            return self.select(when, made.operands[1], kept, kind)
        if value == kept:
            return kept
        return self.select(stop, kept, value, kind)

    def blocks(self) -> tuple[Block, ...]:
        """All of them, closed."""
        done = []
        for block in self._blocks:
            assert block.branch is not None
            phis, instrs = tuple(block.phis), tuple(block.instrs)
            done.append(Block(block.name, phis, instrs, block.branch))
        return tuple(done)

    def _next_lane(self) -> Lane | None:
        lane = self._lane
        if lane is None:
            return None
        part = self._parts.setdefault((lane.thread, lane.origin), 0)
        self._parts[lane.thread, lane.origin] += 1
        return replace(lane, part=part)

    def _choice(self, when: Value, then: Value, other: Value, kind: Kind) -> Value:
        return self.emit(Opcode.SELECT, kind, when, then, other)


def _key(instr: Instr) -> _Key:
    operands = instr.operands
    if OPCODES[instr.opcode].commutes:
        operands = (*sorted(operands[:2], key=repr), *operands[2:])
    return instr.opcode, operands
