"""What trees of loops make of a part: each is tried once, here or in a copy of this process."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

from vividc.compiler.planning.estimate import Estimator, Room
from vividc.compiler.planning.nests.parts import Apart, Regenerated, Restructured, with_loops
from vividc.compiler.planning.state import State
from vividc.host import time_limit
from vividc.host.processes.ahead import Ahead, ahead
from vividc.machine.opcodes import MEMORY
from vividc.ssa.polyhedral.loops import Loops, fors_in, loops_of, runs_in
from vividc.ssa.polyhedral.orders.search import describe, has_masks, is_legal
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.rows import rows_of
from vividc.ssa.polyhedral.scop import Scop
from vividc.ssa.polyhedral.trees import Loop
from vividc.ssa.rewrite.refusal import Refusal

_MOST_TRIES = 40
"""Trees of one part; each takes 0.1 to 1 s."""

_OF_GROUP = 8
"""Trees for the factors of each group of loops that may be tried in any case: of a part of four
nests (fdtd_2d) the orders alone are 30, and the last groups had no factors.
"""

_LARGER = 3
"""Symbols may be so many times as large as they are expected, less one: factors divide most lengths
that are expected, and few others.
"""

STORED = 0.6
"""Of the entries of constant stores beside load/store units, which nests share: what accesses of a
nest's loops take at most. Other operands and straight regions need the rest (adi: 8 rows of four
loops take 0.51 and are mapped, 10 take 0.64 and are not).
"""


@dataclass(frozen=True)
class Attempt:
    """A tree of one of a part's orders, and `stored`: how much of the entries it may take."""

    order: int
    tree: Loop
    stored: float

    @property
    def name(self) -> tuple[int, str, float]:
        """What makes another one another."""
        return self.order, describe(self.tree), self.stored


@dataclass
class Trees:
    """Trees of a part in one of its orders.

    Attributes
    ----------
    stored
        So large a part of the entries may be taken now: as many groups of loops have no factors
        yet, as many parts are left to them.
    most
        So many trees are tried.
    tried
        By their descriptions, in the order in which they were tried; None: nothing was made.
    """

    state: State
    order: int
    scop: Scop
    estimator: Estimator
    symbols: Mapping[str, float]
    most_operations: int
    stored: float = STORED
    most: int = _MOST_TRIES
    tried: dict[str, Restructured | None] = field(default_factory=dict)
    ahead: Ahead[Attempt, Restructured | None] | None = None
    _loops: dict[str, Loops | Refusal] = field(default_factory=dict)
    _last: tuple[str, bool, Regenerated | Refusal] | None = None
    """The tree that was written last, whether it carries, and its code."""

    def __post_init__(self) -> None:
        self.relations = Relations(self.scop)
        self.contexts = self.estimator.fabric.controller.contexts
        self.larger = {name: _LARGER * length - 1 for name, length in self.symbols.items()}
        inside = {dim.header for one in self.scop.statements for dim in one.dims}
        function, hints = self.state.function, self.state.hints
        self.apart = Apart.of(self.estimator, function, hints, inside)

    @property
    def all_made(self) -> list[Restructured]:
        """All that was made."""
        return [one for one in self.tried.values() if one is not None]

    def own_contexts(self, made: Restructured) -> int:
        """The fewest contexts that this nest takes, without the other ones."""
        return made.estimate.contexts - self.apart.contexts

    def cycles(self, tree: Loop) -> float:
        """Of a tree; infinite if nothing is made of it."""
        made = self.attempt(tree)
        return math.inf if made is None else made.cycles

    def attempt(self, tree: Loop) -> Restructured | None:
        """What is made of a tree, if it is legal and there is room for it: while not too many were
        tried.
        """
        name = describe(tree)
        if name not in self.tried and len(self.tried) < self.most:
            time_limit.step("loops were restructured")
            self.tried[name] = self.outcome(tree)
        return self.tried.get(name)

    def allow(self, groups: int) -> None:
        """Has enough trees tried for the factors of so many groups of loops."""
        self.most = max(self.most, len(self.tried) + _OF_GROUP * groups)

    def outcome(self, tree: Loop) -> Restructured | None:
        """As `attempt`, of any number of trees."""
        one = Attempt(self.order, tree, self.stored)
        done = None if self.ahead is None else self.ahead.result(one.name)
        return done[0] if done else self.of(one)

    def of(self, one: Attempt) -> Restructured | None:
        """What comes of an attempt."""
        is_possible = is_legal(one.tree, self.relations)
        return self.made(one.tree, stored=one.stored) if is_possible else None

    def expect(self, trees: Iterable[Loop], *, perhaps: bool = False) -> None:
        """Has trees made ahead that will be tried; or may be, when nothing else is to be done."""
        if self.ahead is not None:
            new = (tree for tree in trees if describe(tree) not in self.tried)
            attempts = [Attempt(self.order, tree, self.stored) for tree in new]
            self.ahead.begin({one.name: one for one in attempts}, perhaps=perhaps)

    def made(
        self,
        tree: Loop,
        *,
        carries: bool = True,
        most_contexts: float | None = None,
        stored: float | None = None,
    ) -> Restructured | None:
        """What is made of a legal tree, if there is room for it.

        Parameters
        ----------
        carries
            Whether registers carry elements from one iteration to the next.
        most_contexts
            As many as a fabric has, if None.
        stored
            As `stored` of these trees, if None.
        """
        name = describe(tree)
        if name not in self._loops:
            self._loops[name] = loops_of(tree, self.relations)
        loops = self._loops[name]
        if isinstance(loops, Refusal) or self._is_too_large(loops):
            return None
        made = self._written(name, tree, loops, carries=carries)
        if isinstance(made, Refusal):
            return None
        hints = made.state.hints
        larger = {**hints, **made.hints(loops, self.larger)}
        room = Room(self.most_operations, most_contexts or self.contexts)
        estimate, large = self.apart.estimate(made.state.function, hints, larger, room=room)
        if self.estimator.largest_loop(estimate) > self.most_operations:
            return None
        mean = math.sqrt(estimate.cycles * large.cycles)
        if self.apart.entries(estimate) > (stored or self.stored) * self.estimator.entries:
            return None
        order, factor, carries = self.order, made.factor, made.carries
        return Restructured(made.state, estimate, order, tree, factor, mean, carries)

    def _written(
        self, name: str, tree: Loop, loops: Loops, *, carries: bool
    ) -> Regenerated | Refusal:
        """The state with the loops of a tree: the same one if it is asked for twice in a row."""
        if self._last is None or self._last[:2] != (name, carries):
            given = self.state, self.scop, loops, self.symbols
            masks, rows = has_masks(tree), rows_of(tree)
            made = with_loops(*given, masks=masks, rows=rows, carries=carries)
            self._last = name, carries, made
        return self._last[2]

    def _is_too_large(self, loops: Loops) -> bool:
        """Whether an innermost loop is sure to have too many operations, even if two instructions
        become one each time and its accesses are saved.
        """
        work = {
            statement.name: sum(instr.op not in MEMORY for instr in statement.instrs)
            for statement in self.scop.statements
        }
        return any(
            sum(work[run.statement] for run in runs_in(loop.body)) > 2 * self.most_operations
            for loop in fors_in(loops.code)
            if not any(fors_in(loop.body))
        )


@contextmanager
def side_by_side(orders: list[Trees]) -> Iterator[None]:
    """Inside, trees of a part's orders are made on another core, too."""

    def outcome(one: Attempt) -> Restructured | None:
        return orders[one.order].of(one)

    with ahead(outcome) as helper:
        for trees in orders:
            trees.ahead = helper
        yield
