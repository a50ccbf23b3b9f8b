"""Float sums with fused products in another order, which rounds otherwise.

A chain of FMAs that an accumulator goes through becomes a sum of the products, to which the
accumulator is added last; a long chain becomes several side by side.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final

from vividc.dfg.ir import DFG, Edge, Node
from vividc.dfg.passes.rewrite import Rewrite, Value, change_operation, value_of
from vividc.machine.opcodes import PRED, Opcode

_ADDENDS: Final[Mapping[Opcode, tuple[int, ...]]] = {
    Opcode.FADD: (0, 1),
    Opcode.FSUB: (0,),
    Opcode.FMA: (2,),
    Opcode.FNMA: (2,),
}
"""Ports whose words are added as they are."""
_FUSED: Final = frozenset({Opcode.FMA, Opcode.FNMA})
_MOST_CHAINS: Final = 8
_MINUS_ZERO: Final = 0x80000000
"""What a sum without terms is: any word plus it is that word."""
_CHAIN: Final = 4
"""Terms of a chain in a loop, where each chain more takes an operation of every iteration (gemver:
12 terms, 76 operations in 80 slots).
"""


@dataclass(frozen=True, slots=True)
class _Term:
    """A word, or a product of two, that is added or subtracted; `ready`: when it is there, in
    operations; `guard`: where that is 0, a product counts as nothing.
    """

    factors: tuple[Value, ...]
    is_negative: bool
    ready: int
    guard: Value | None = None

    @property
    def height(self) -> int:
        """When it is there as a word."""
        return self.ready + len(self.factors) - 1


@dataclass
class _Sum:
    """The operations below `root` that only feed it, and the terms that they add up.

    `levels`: of each node, operations on the longest way to it. `components`: the recurrence that
    each node is in.
    """

    rewrite: Rewrite
    root: Node
    levels: Mapping[int, int]
    components: Mapping[int, int]
    inner: list[int] = field(default_factory=list)
    terms: list[_Term] = field(default_factory=list)
    depths: list[int] = field(default_factory=list)
    carried: list[Value] = field(default_factory=list)
    """Words that the root gave before, where they are added."""
    carried_depth: int = 0
    late: list[tuple[_Term, int]] = field(default_factory=list)
    """Terms that need the root's earlier words, with their depths."""
    is_plain: bool = True
    """The root's earlier words come in nowhere else."""

    def collect(self) -> bool:
        """Whether it is a sum by itself of which some other order may be better."""
        uses = self.rewrite.uses(self.root.id)
        if self._is_switched(self.root) or (len(uses) == 1 and self._joins(self.root, uses[0])):
            return False
        self._descend(self.root, 1)
        return len(self.terms) > 1

    @property
    def is_fused(self) -> bool:
        """It has more than words that are added, which trees are made of outside loops."""
        return any(len(term.factors) > 1 or term.is_negative for term in self.terms)

    @property
    def has_one_accumulator(self) -> bool:
        """Whether earlier words come in at one place at most, and are added there."""
        return self.is_plain and len(self.carried) <= 1

    def rebalance_late(self) -> None:
        """Adds what needs the root's earlier words behind what does not, the latest of these words
        last (`b1 * y[i - 1] + b2 * y[i - 2]` with the first product last), if a recurrence is
        shorter so.
        """
        if any(term.guard is not None for term in self.terms):
            return
        late = sorted(self.late, key=lambda one: -self._distance(one[0]))
        rest = [t for t in self.terms if not any(t is term for term, _ in late)]
        if not _starts(rest):
            return
        before = max(depth / self._distance(term) for term, depth in late)
        depths = range(len(late), 0, -1)
        after = max(d / self._distance(term) for (term, _), d in zip(late, depths, strict=True))
        if after < before:
            writer = _Writer(self.rewrite, self.root, [*reversed(self.inner)])
            writer.chain([*_ordered(rest), *(term for term, _ in late)], last=self.root)

    def _distance(self, term: _Term) -> int:
        """By how many iterations the root's word in a term is earlier, at least."""
        return min(
            value.distance + self._away[value.src]
            for value in term.factors
            if self._is_carried(value)
        )

    @cached_property
    def _away(self) -> Mapping[int, int]:
        """Iterations from the root to what needs its word, of the recurrence (Dijkstra)."""
        found: dict[int, int] = {}
        heap = [(0, self.root.id)]
        while heap:
            iterations, node = heapq.heappop(heap)
            if node in found:
                continue
            found[node] = iterations
            for use in self.rewrite.uses(node):
                if self.components[use.dst] == self.components[self.root.id]:
                    heapq.heappush(heap, (iterations + use.distance, use.dst))
        return found

    def rebalance_carried(self) -> None:
        """Adds what the last iteration left last of all."""
        if len(self.carried) != 1 or self.carried_depth == 1:
            return
        flipped = all(term.is_negative for term in self.terms)
        terms = [replace(term, is_negative=term.is_negative is not flipped) for term in self.terms]
        writer = _Writer(self.rewrite, self.root, [*reversed(self.inner)])
        rest = writer.halves(_dealt(terms, _chains_in_loop(terms)))
        word = writer.emit(Opcode.FADD, rest) if len(rest) > 1 else rest[0]
        op = Opcode.FSUB if flipped else Opcode.FADD
        writer.change(self.root, op, [self.carried[0], word])

    def widen(self, most: int) -> None:
        """Adds up at most so many chains side by side, if that is done sooner."""
        now = max(t.ready + d for t, d in zip(self.terms, self.depths, strict=True))
        counts = range(1, min(_starts(self.terms), most) + 1)
        best = min(counts, key=lambda n: _height(_dealt(self.terms, n)), default=0)
        if self.carried or best <= 1 or _height(_dealt(self.terms, best)) >= now:
            return
        writer = _Writer(self.rewrite, self.root, [*reversed(self.inner)])
        halves = writer.halves(_dealt(self.terms, best))
        writer.change(self.root, Opcode.FADD, halves)

    def _descend(self, node: Node, depth: int) -> None:
        operands = self.rewrite.operands(node)
        addends = _ADDENDS[node.op]
        factors = tuple(v for port, v in enumerate(operands) if port not in addends)
        if factors:
            is_negative = node.op in (Opcode.FSUB, Opcode.FNMA)
            self._add(factors, depth, is_negative, _guard(self.rewrite, node))
        for port in addends:
            value = operands[port]
            source = self.rewrite.nodes[value.src]
            if value.distance == 0 and self._is_inner(source):
                self.inner.append(source.id)
                self._descend(source, depth + 1)
            elif self._is_carried(value):
                self.carried.append(value)
                self.carried_depth = depth
                self.late.append((_Term((value,), False, 0), depth))
            else:
                self._add((value,), depth)

    def _add(
        self,
        factors: tuple[Value, ...],
        depth: int,
        is_negative: bool = False,
        guard: Value | None = None,
    ) -> None:
        read = factors if guard is None else (*factors, guard)
        ready = max((self.levels[v.src] for v in read if v.distance == 0), default=0)
        self.terms.append(_Term(factors, is_negative, ready, guard))
        self.depths.append(depth)
        if any(map(self._is_carried, read)):
            self.is_plain = False
            self.late.append((self.terms[-1], depth))

    def _is_carried(self, value: Value) -> bool:
        return self.components[value.src] == self.components[self.root.id]

    def _is_inner(self, node: Node) -> bool:
        uses = self.rewrite.uses(node.id)
        if node.op not in _ADDENDS or node.control is not None or len(uses) != 1:
            return False
        return self._joins(node, uses[0]) and not self._is_switched(node)

    def _joins(self, node: Node, use: Edge) -> bool:
        """Whether a reader adds the node's word to a sum of its own."""
        reader = self.rewrite.nodes[use.dst]
        adds = use.distance == 0 and use.port in _ADDENDS.get(reader.op, ())
        return adds and node.control is None and not self._is_switched(reader)

    def _is_switched(self, node: Node) -> bool:
        """Whether a predicate decides more than whether a product is added: what a fused operation
        passes on is what it adds to.
        """
        return node.op not in _FUSED and self.rewrite.predicated(node.id)


def fused_sums(
    dfg: DFG, levels: Mapping[int, int], components: Mapping[int, int], *, in_loop: bool
) -> DFG:
    """Sums with fused products (or differences) in an order that is done sooner; in a loop what the
    last iteration left counts most.
    """
    rewrite = Rewrite(dfg)
    done: set[int] = set()
    for node in dfg.nodes:
        if node.op not in _ADDENDS or node.id in done:
            continue
        found = _Sum(rewrite, node, levels, components)
        if not found.collect() or not (in_loop or found.is_fused):
            continue
        done |= {node.id, *found.inner}
        if not found.has_one_accumulator:
            found.rebalance_late()
        elif found.carried:
            found.rebalance_carried()
        else:
            found.widen(_chains_in_loop(found.terms) if in_loop else _MOST_CHAINS)
    return rewrite.result()


@dataclass
class _Writer:
    """Writes operations, in place of `free` ones as long as there are any."""

    rewrite: Rewrite
    root: Node
    free: list[int]

    def emit(self, op: Opcode, operands: Sequence[Value], guard: Value | None = None) -> Value:
        """An operation."""
        if self.free:
            node = self.rewrite.nodes[self.free.pop(0)]
            self.change(node, op, operands, guard)
            return Value(node.id)
        made = self.rewrite.add_node(op, operands, self.root.loc, self.root.lane)
        if guard is not None:
            self.rewrite.set_operand(made, PRED, guard)
        return Value(made)

    def change(
        self, node: Node, op: Opcode, operands: Sequence[Value], guard: Value | None = None
    ) -> None:
        """Make a node this operation."""
        change_operation(self.rewrite, node, op, operands)
        edge = self.rewrite.edge(node.id, PRED)
        if guard is not None:
            self.rewrite.set_operand(node.id, PRED, guard)
        elif edge is not None:
            self.rewrite.remove_edge(edge)

    def halves(self, chains: Sequence[Sequence[_Term]]) -> list[Value]:
        """Two words whose sum is that of all chains; one, if there is one chain."""
        heap = [(_chain_height(c), number, self.chain(c)) for number, c in enumerate(chains)]
        heapq.heapify(heap)
        while len(heap) > 2:  # noqa: PLR2004 - halves
            (one, number, left), (other, _, right) = heapq.heappop(heap), heapq.heappop(heap)
            made = self.emit(Opcode.FADD, [left, right])
            heapq.heappush(heap, (max(one, other) + 1, number, made))
        return [word for _, _, word in sorted(heap)]

    def chain(self, terms: Sequence[_Term], last: Node | None = None) -> Value:
        """Terms one after another, of which the first is not negative; the last one's operation is
        `last`, if given.
        """
        first, *others = terms
        total = first.factors[0]
        if first.guard is not None:
            nothing = Value(self.rewrite.constant(_MINUS_ZERO))
            total = self.emit(Opcode.FMA, [*first.factors, nothing], first.guard)
        elif len(first.factors) > 1:
            total = self.emit(Opcode.FMUL, first.factors)
        for term in others:
            op = Opcode.FNMA if term.is_negative else Opcode.FMA
            operands = [*term.factors, total]
            if len(term.factors) == 1:
                op = Opcode.FSUB if term.is_negative else Opcode.FADD
                operands = [total, *term.factors]
            if last is not None and term is others[-1]:
                self.change(last, op, operands, term.guard)
                return Value(last.id)
            total = self.emit(op, operands, term.guard)
        return total


def _guard(rewrite: Rewrite, node: Node) -> Value | None:
    edge = rewrite.edge(node.id, PRED)
    return None if edge is None else value_of(edge)


def _starts(terms: Sequence[_Term]) -> int:
    """Chains that may begin: with a term that is not negative each."""
    return sum(not term.is_negative for term in terms)


def _chains_in_loop(terms: Sequence[_Term]) -> int:
    """Side by side, in a loop, where each takes an operation, and the iteration's length counts at
    its ends only.
    """
    return max(1, min(_starts(terms), 4, len(terms) // _CHAIN))


def _ordered(terms: Sequence[_Term]) -> list[_Term]:
    """Words before products, what is ready before what is not; what is negative is not first."""
    order = sorted(terms, key=lambda term: (term.height, len(term.factors)))
    first = next(term for term in order if not term.is_negative)
    return [first, *(term for term in order if term is not first)]


def _dealt(terms: Sequence[_Term], count: int) -> list[list[_Term]]:
    """Terms in so many chains; each begins with one that is not negative."""
    order = sorted(terms, key=lambda term: (term.height, len(term.factors)))
    firsts = [term for term in order if not term.is_negative][:count]
    chains = [[term] for term in firsts]
    rest: Iterator[_Term] = (term for term in order if not any(term is f for f in firsts))
    for number, term in enumerate(rest):
        chains[number % count].append(term)
    return chains


def _chain_height(chain: Sequence[_Term]) -> int:
    height = chain[0].height
    for term in chain[1:]:
        height = max(height, term.ready) + 1
    return height


def _height(chains: Sequence[Sequence[_Term]]) -> int:
    heights = sorted(map(_chain_height, chains))
    while len(heights) > 1:
        _, other, *rest = heights
        heights = sorted((*rest, other + 1))
    return heights[0]
