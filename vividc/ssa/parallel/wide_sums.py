"""Sums of 64 bits in two words that the iterations of a loop only add to."""

from __future__ import annotations

from vividc.machine.opcodes import Opcode
from vividc.ssa.flow import Loop
from vividc.ssa.ir import Function, Instr, Phi, Ref, Value

_Pair = tuple[Value, Value]
_Leaf = tuple[int, Value]
"""A term of a sum, and its sign."""


def is_wide_sum(function: Function, loop: Loop, low: Phi, high: Phi) -> bool:
    """Whether two phis of the loop's header are the words of a sum: what an iteration adds to them
    as one number depends on neither, and nothing else in the loop reads them.

    An addition of (a, b) to (low, high) is low' = low + a and high' = high + b + carry, where the
    carry is low' < low or low' < a, unsigned; a subtraction takes a borrow, low < a.
    """
    return _Check(function, loop, low, high).holds()


class _Check:
    def __init__(self, function: Function, loop: Loop, low: Phi, high: Phi) -> None:
        self._loop = loop
        self._phis = (low, high)
        self._blocks = [block for block in function.blocks if block.name in loop.blocks]
        self._values = {item.id: item for block in self._blocks for item in block.items}
        self._home = {item.id: block.name for block in self._blocks for item in block.items}
        self._users = self._all_users()
        self._told: set[int] = {low.id, high.id}
        self._known: set[_Pair] = {(Ref(low.id), Ref(high.id))}

    def holds(self) -> bool:
        if any(self._is_used(value) for block in self._blocks for value in block.branch.read):
            return False
        low, high = (self._again(phi) for phi in self._phis)
        if low is None or high is None or not self._is_pair(low, high):
            return False
        return self._users <= self._told

    def _again(self, phi: Phi) -> Value | None:
        values = {value for source, value in phi.incoming if source in self._loop.blocks}
        return values.pop() if len(values) == 1 else None

    def _all_users(self) -> set[int]:
        """All that is computed from the phis, they included."""
        made = {phi.id for phi in self._phis}
        before = 0
        while len(made) > before:
            before = len(made)
            for item in self._values.values():
                operands = (
                    [value for _, value in item.incoming]
                    if isinstance(item, Phi)
                    else list(item.operands)
                )
                if any(isinstance(v, Ref) and v.id in made for v in operands):
                    made.add(item.id)
        return made

    def _is_used(self, value: Value) -> bool:
        return isinstance(value, Ref) and value.id in self._users

    def _is_pair(self, low: Value, high: Value) -> bool:
        """Whether two values are the words of the sum at one place; assumed while it is proved."""
        if (low, high) in self._known:
            return True
        if not isinstance(low, Ref) or not isinstance(high, Ref):
            return False
        if not {low.id, high.id} <= self._users:
            return False
        one, other = self._values[low.id], self._values[high.id]
        self._known.add((low, high))
        self._told |= {low.id, high.id}
        if isinstance(one, Phi) or isinstance(other, Phi):
            both = isinstance(one, Phi) and isinstance(other, Phi)
            return both and self._are_phis(one, other)
        if other.op not in (Opcode.ADD, Opcode.SUB):
            return self._is_choice(one, other)
        return self._is_addition(one, other)

    def _are_phis(self, one: Phi | Instr, other: Phi | Instr) -> bool:
        assert isinstance(one, Phi)
        assert isinstance(other, Phi)
        if self._home[one.id] != self._home[other.id]:
            return False
        highs = dict(other.incoming)
        return all(self._is_pair(value, highs[source]) for source, value in one.incoming)

    def _is_choice(self, one: Instr, other: Instr) -> bool:
        if one.op is not Opcode.SELECT or other.op is not Opcode.SELECT:
            return False
        if one.operands[0] != other.operands[0] or self._is_used(one.operands[0]):
            return False
        return all(
            self._is_pair(*pair) for pair in zip(one.operands[1:], other.operands[1:], strict=True)
        )

    def _is_addition(self, one: Instr, other: Instr) -> bool:
        """A chain of additions to the low word, and a sum that has the carry of each."""
        steps, low = self._chain(one)
        leaves = self._leaves(other, 1)
        for step in steps:
            carries = [leaf for leaf in leaves if self._is_carry(leaf, step)]
            if len(carries) != 1:
                return False
            leaves.remove(carries[0])
            self._told |= {step.id, *(v.id for _, v in carries if isinstance(v, Ref))}
        rest = [leaf for leaf in leaves if self._is_used(leaf[1])]
        if not steps or len(rest) != 1:
            return False
        sign, high = rest[0]
        return sign > 0 and self._is_pair(low, high)

    def _chain(self, item: Instr) -> tuple[list[Instr], Value]:
        """Additions and subtractions of what does not depend on the sum, and where they start."""
        steps: list[Instr] = []
        value: Value = Ref(item.id)
        while isinstance(value, Ref):
            step = self._values.get(value.id)
            if not isinstance(step, Instr) or step.op not in (Opcode.ADD, Opcode.SUB):
                break
            own = [port for port, operand in enumerate(step.operands) if self._is_used(operand)]
            if len(own) != 1 or (step.op is Opcode.SUB and own != [0]):
                break
            steps.append(step)
            value = step.operands[own[0]]
        return steps, value

    def _leaves(self, item: Instr, sign: int) -> list[_Leaf]:
        """The terms of a sum of words."""
        self._told.add(item.id)
        leaves: list[_Leaf] = []
        signs = (sign, -sign if item.op is Opcode.SUB else sign)
        for way, operand in zip(signs, item.operands, strict=True):
            inner = self._values.get(operand.id) if isinstance(operand, Ref) else None
            is_sum = isinstance(inner, Instr) and inner.op in (Opcode.ADD, Opcode.SUB)
            if is_sum and isinstance(inner, Instr) and self._is_used(operand):
                leaves += self._leaves(inner, way)
            else:
                leaves.append((way, operand))
        return leaves

    def _is_carry(self, leaf: _Leaf, low: Instr) -> bool:
        """The carry of an addition is added, the borrow of a subtraction subtracted."""
        sign, value = leaf
        item = self._values.get(value.id) if isinstance(value, Ref) else None
        if not isinstance(item, Instr) or item.op is not Opcode.ICMP_ULT:
            return False
        if low.op is Opcode.SUB:
            return sign < 0 and item.operands == low.operands
        return sign > 0 and item.operands[0] == Ref(low.id) and item.operands[1] in low.operands
