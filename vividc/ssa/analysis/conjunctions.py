"""When blocks of a loop's body run, as conjunctions of its branches' tests; which tests others
imply.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from vividc.machine.opcodes import Opcode
from vividc.machine.words import signed
from vividc.ssa.analysis.acyclic import Acyclic, Edge, PathPredicates
from vividc.ssa.analysis.levels import Level
from vividc.ssa.edit import read_values
from vividc.ssa.ir import Const, Function, Input, Instr, Ref, Value, definition_of, is_dimension

Conjunction = frozenset[tuple[Value, bool]]
"""Tests and whether they hold, all at once."""

CONTRARY: Final = (Const(0), True)
"""Is in the conjunction of a block that runs where one or another one holds, which is none."""


@dataclass(frozen=True)
class Conjunctions(PathPredicates[Conjunction]):
    """Of the nodes of a level."""

    level: Level

    @property
    def flow(self) -> Acyclic:
        """The nodes."""
        return self.level.flow

    def node(self, block: str) -> str:
        """The node that a block belongs to."""
        return self.level.node(block)

    def into(self, node: str) -> Sequence[Edge]:
        """The edges that lead to a node."""
        return [edge for edge in self.level.edges if self.node(edge[1]) == node]

    def taken(self, edge: Edge) -> Conjunction | None:
        """The test of a branch inside the loop; exits of inner loops are taken in any case."""
        source, target = edge
        branch = self.level.blocks[source].branch
        leaves = not set(branch.successors) <= self.level.loop.blocks
        if self.node(source) in self.level.children or leaves or len(set(branch.successors)) == 1:
            return None
        assert branch.cond is not None
        return frozenset({(branch.cond, target == branch.successors[0])})

    def both(self, left: Conjunction | None, right: Conjunction | None) -> Conjunction | None:
        """All tests of two."""
        if left is None or right is None:
            return left or right
        return left | right

    def either(self, left: Conjunction | None, right: Conjunction | None) -> Conjunction | None:
        """`CONTRARY`, unless two are one."""
        return left if left == right else frozenset({CONTRARY})


def only_tested(function: Function) -> set[int]:
    """Ids of what nothing but branches reads."""
    read: set[Value] = set()
    for block in function.blocks:
        read.update(read_values(replace(block, branch=replace(block.branch, cond=None))))
    tests = {block.branch.cond for block in function.blocks} - read
    return {value.id for value in tests if isinstance(value, Ref)}


@dataclass(frozen=True, slots=True)
class _Demand:
    """`more` - `less` is at least so much; `is_word`: as a word, in which it may have wrapped."""

    more: Value
    less: Value
    least: int
    is_word: bool


@dataclass(frozen=True, slots=True)
class Implications:
    """Between tests of `function`, and of instructions that it is yet to get, by id."""

    function: Function
    further: Mapping[int, Instr]

    def holds(self, one: Value, other: Value) -> bool:
        """Whether `other` holds wherever `one` does: it is one of the tests whose conjunction `one`
        is, or one of these demands as much or more of the same difference of signed words.

        Nothing is taken for granted that was proved of a sum: that may be true only where its block
        runs, of which `other` may be the condition.
        """
        wanted = self._demand(other)
        return any(
            test == other or (wanted is not None and self._demands(test, wanted))
            for test in self._conjuncts(one)
        )

    def _conjuncts(self, value: Value) -> list[Value]:
        left, seen, found = [value], set[Value](), []
        while left:
            one = left.pop()
            if one in seen:
                continue
            seen.add(one)
            made = self._made(one, Opcode.AND)
            if made is None:
                found.append(one)
            else:
                left += made.operands
        return found

    def _demands(self, test: Value, wanted: _Demand) -> bool:
        own = self._demand(test)
        if own is None or (own.more, own.less) != (wanted.more, wanted.less):
            return False
        return own.least >= wanted.least and (own.is_word or not wanted.is_word)

    def _demand(self, test: Value) -> _Demand | None:
        """Of a comparison of two words, or of a number and a difference: a word of which the first
        is not negative wraps only where it is large, and not where it is too small.
        """
        made = self._made(test, Opcode.ICMP_SLT, Opcode.ICMP_SLE)
        if made is None:
            return None
        less, more = map(self.function.settled, made.operands)
        least = int(made.op is Opcode.ICMP_SLT)
        apart = self._made(more, Opcode.SUB)
        if apart is None or not isinstance(less, Const):
            return _Demand(more, less, least, is_word=False)
        first, second = map(self.function.settled, apart.operands)
        if signed(less.word) < 0 or not _is_natural(first):
            return None
        return _Demand(first, second, signed(less.word) + least, is_word=True)

    def _made(self, value: Value, *ops: Opcode) -> Instr | None:
        """The instruction that makes a value, if it is one of those."""
        further = self.further.get(value.id) if isinstance(value, Ref) else None
        item = further or definition_of(self.function, value)
        return item if isinstance(item, Instr) and item.op in ops else None


def _is_natural(value: Value) -> bool:
    """Whether a word is known not to be negative, wherever it is read."""
    if isinstance(value, Const):
        return signed(value.word) >= 0
    return isinstance(value, Input) and is_dimension(value)
