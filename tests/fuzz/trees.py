"""`python -m tests.fuzz.trees`: random nests in other orders of their iterations, which have to
mean the same for all lengths; exit code 1 on a find.

Nothing is mapped: a nest is written as SSA, legal trees of it are chosen at random (interchanged,
fused, skewed, jammed, masked, in order; of two loops as one), and the words that both leave in
memory are compared.
"""

from __future__ import annotations

import itertools
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from random import Random

import click
import islpy as isl

from tests.ssa.compiled import Outside, Run, compiled
from tests.ssa.polyhedral.nests import settled
from tests.ssa.polyhedral.sums import random_sums
from tests.ssa.polyhedral.wide_nests import MOST, WIDTH, random_wide_nest
from vividc.machine.words import WORD_MASK
from vividc.ssa.analysis.levels import with_own_latches
from vividc.ssa.check import check_function
from vividc.ssa.flow import find_loops
from vividc.ssa.ir import Const, Function
from vividc.ssa.loops.join import Joined, join
from vividc.ssa.polyhedral.generate import generate
from vividc.ssa.polyhedral.loops import loops_of
from vividc.ssa.polyhedral.orders.in_memory import in_memory
from vividc.ssa.polyhedral.orders.joined import divided, together
from vividc.ssa.polyhedral.orders.realigned import other_orders
from vividc.ssa.polyhedral.orders.search import (
    at,
    describe,
    has_masks,
    is_legal,
    loops_in,
    moves,
    put,
    skewed,
    with_factors,
)
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.rows import with_own_rows
from vividc.ssa.polyhedral.scop import Scop, find_scop
from vividc.ssa.polyhedral.trees import Loop, tree_of
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

_WORDS = WIDTH * WIDTH
_SHARED = 0.5
"""Share of trees that load what has several guards once."""
_MOVES = 4
"""So many orders of a part at most, each one step from the one before."""
_TREES = 3
"""Of each order, with random factors."""
_SUMS = 0.3
"""Share of nests of sums in memory, whose loops may be another's outermost."""
_OFTEN = 0.5
"""Share of a third nest's statements that access elements at fixed places."""
_ALIGNED = 2
"""Parts with other loops outermost that are tried of one."""
_KNOWN = 0.2
"""Share of nests for one number only."""
_JUNK = 0xA5A5A5A5
"""What arrays hold that restructuring makes."""
_TOO_LONG = "isl takes too long"
_BLOCKS = 20_000
_LATER = 4
"""What is restructured may run so many times as many blocks."""

_OPERATIONS = 300_000
"""Of isl, for one tree: 0.1 s."""
_STRIKES = 2
"""So often may isl take too long for trees of a part."""

Words = dict[str, list[int]]
Before = tuple[dict[str, int], Words, Words]
"""Lengths, and memory before and after."""


@dataclass
class Search:
    """What was run: programs are triples of a nest, a tree, and lengths with data.

    Attributes
    ----------
    counts
        Of nests, parts, trees, programs, and of what was refused, by reason.
    finds
        Seeds with what differs.
    in_place
        Whether many statements of a third of the nests access elements at fixed places.
    """

    sizes: int = 32
    counts: Counter[str] = field(default_factory=Counter)
    finds: list[str] = field(default_factory=list)
    in_place: bool = True

    def run(self, seed: int) -> None:
        """All programs of one seed."""
        chance = Random(seed)
        often = _OFTEN if self.in_place and seed % 3 == 0 else 0.0
        function = random_sums(seed) if chance.random() < _SUMS else random_wide_nest(seed, often)
        known = None
        if chance.random() < _KNOWN:
            known = chance.randrange(MOST + 1)
            function = settled(function, Const(known))
        function = tidy(function)
        self.counts["nests"] += 1
        parts = list(self._parts(function))
        if not parts:
            return
        before = list(self._before(compiled(function), chance, known))
        for scop in parts:
            self.counts["parts"] += 1
            relations = Relations(scop)
            for tree in self._trees(scop, relations, chance):
                made = _made(scop, relations, tree, shares=chance.random() < _SHARED)
                if isinstance(made, Refusal):
                    self.counts[made.reason] += 1
                else:
                    self._compare(made, before, f"seed {seed}: {describe(tree)}")

    def _parts(self, function: Function) -> Iterator[Scop]:
        every = find_loops(function)
        around = [(a, b) for a in every for b in every if b.header in a.blocks - {a.header}]
        loops = [one for one in every if one not in [inner for _, inner in around]]
        for loop in loops:
            found = find_scop(with_own_latches(function, loop.header), loop.header)
            if isinstance(found, Scop):
                yield found
                yield from _others(found)
            else:
                self.counts[found.reason] += 1
        for first, second in itertools.permutations(loops, 2):
            made = join(function, first, second)
            if isinstance(made, Joined):
                found = find_scop(with_own_latches(made.function, made.header), made.header)
                if isinstance(found, Scop):
                    self.counts["two as one"] += 1
                    yield found

    def _before(self, run: Run, chance: Random, known: int | None) -> Iterator[Before]:
        """What it does; not where it leaves its arrays."""
        pairs = [(n, m) for n in (-1, *range(MOST + 1)) for m in range(MOST + 1)]
        pairs = [(n, m) for n, m in pairs if known in (None, n)]
        data = _data(chance)
        for n, m in chance.sample(pairs, min(self.sizes, len(pairs))):
            words, inputs = _arguments(data, chance.randrange(_WORDS), n, m)
            left = {name: list(array) for name, array in words.items()}
            try:
                if run(left, inputs, _BLOCKS):
                    yield inputs, words, left
            except Outside:
                self.counts["outside"] += 1

    def _trees(self, scop: Scop, relations: Relations, chance: Random) -> Iterator[Loop]:
        """Legal trees of a part, with random factors."""
        tree = tree_of(scop)
        too_long = self.counts[_TOO_LONG]
        with suppress(isl.Error), _bounded():
            joined = (*together(tree, relations), *divided(tree, relations))
            tree = chance.choice([tree, *joined])
        for _ in range(_MOVES):
            if self.counts[_TOO_LONG] >= too_long + _STRIKES:
                return
            tried = (_jammed(tree, relations, chance) for _ in range(_TREES))
            yield from (jammed for jammed in tried if self._is_legal(jammed, relations))
            further = [*moves(tree, scop), *skewed(tree)]
            tree = chance.choice(further) if further else tree
            if not self._is_legal(tree, relations):
                return

    def _is_legal(self, tree: Loop, relations: Relations) -> bool:
        try:
            with _bounded():
                return is_legal(tree, relations)
        except isl.Error:
            self.counts[_TOO_LONG] += 1
            return False

    def _compare(self, made: Function, before: list[Before], what: str) -> None:
        self.counts["trees"] += 1
        if check_function(made):
            self.finds.append(f"{what}: {check_function(made)[0]}")
            return
        run = compiled(made)
        for inputs, words, expected in before:
            mine = {name: list(array) for name, array in words.items()}
            own = {local.name: local.at_launch(inputs).words for local in made.locals}
            more = {f"&{name}": 0 for name in own}
            left = {name: [_JUNK] * count for name, count in own.items()}
            self.counts["programs"] += 1
            try:
                ended = run({**mine, **left}, {**inputs, **more}, _LATER * _BLOCKS)
            except Outside:
                ended = False
            if not ended or mine != expected:
                self.finds.append(f"{what}, {inputs}")
                return


def _others(scop: Scop) -> Iterator[Scop]:
    """The part with its sums in memory, and in orders with other loops outermost."""
    moved = in_memory(scop)
    if moved is not scop:
        yield moved
    yield from itertools.islice(other_orders(Relations(scop)), _ALIGNED)


@contextmanager
def _bounded() -> Iterator[None]:
    context = isl.DEFAULT_CONTEXT
    context.reset_operations()
    context.set_max_operations(_OPERATIONS)
    try:
        yield
    finally:
        context.set_max_operations(0)


def _data(chance: Random) -> Words:
    """Arrays with small integers, and floats with all of their bits; twice as long as needed."""
    small = [number & WORD_MASK for number in range(-50, 50)]
    floats = [0x3F000000 + chance.getrandbits(24) for _ in range(2 * _WORDS)]
    return {
        "a": chance.choices(small, k=2 * _WORDS),
        "b": chance.choices(small, k=2 * _WORDS),
        "f": floats,
        "t": chance.choices(small, k=2 * _WORDS),
    }


def _arguments(data: Words, start: int, n: int, m: int) -> tuple[Words, dict[str, int]]:
    words = {name: array[start : start + _WORDS] for name, array in data.items()}
    words["t"] = words["t"][:WIDTH]
    inputs = {f"&{name}": 0 for name in words}
    inputs |= {
        "n": n & WORD_MASK,
        "g.shape0": m,
        "b.pitch1": WIDTH,
        "b.shape1": WIDTH,
        "t.shape0": WIDTH,
    }
    return words, inputs


def _jammed(tree: Loop, relations: Relations, chance: Random) -> Loop:
    """The tree with random factors of one or two loops, perhaps with rows of temporaries."""
    paths = [path for path, _ in loops_in(tree)]
    some = chance.sample(paths, min(len(paths), chance.randint(1, 2)))
    factors = {path: chance.choice([2, 3, 4, 8]) for path in some}
    made = with_own_rows(at(tree, some[0]), relations) if chance.random() < 0.3 else None
    tree = tree if made is None else put(tree, some[0], made)
    jammed = with_factors(tree, factors, masked=chance.random() < 0.5)
    if chance.random() < 0.4:
        path = chance.choice(paths)
        jammed = put(jammed, path, replace(at(jammed, path), in_order=True))
    return jammed


def _made(scop: Scop, relations: Relations, tree: Loop, *, shares: bool) -> Function | Refusal:
    try:
        with _bounded():
            loops = loops_of(tree, relations)
    except isl.Error:
        return Refusal(_TOO_LONG)
    if isinstance(loops, Refusal):
        return loops
    made = generate(scop, loops, masks=has_masks(tree), shares=shares)
    return made if isinstance(made, Refusal) else tidy(made.function)


@click.command()
@click.option("--seed", default=1, show_default=True, help="Of the first nest.")
@click.option("--count", default=1000, show_default=True, help="Nests.")
@click.option("--sizes", default=32, show_default=True, help="Lengths and data for each tree.")
def main(seed: int, count: int, sizes: int) -> None:
    """Run random nests in other orders; exit code 1 on a find."""
    search = Search(sizes)
    started = time.process_time()
    for one in range(seed, seed + count):
        known = len(search.finds)
        search.run(one)
        for find in search.finds[known:]:
            click.echo(f"FIND {find}")
        if one % 50 == 49 or one == seed + count - 1:
            found = ", ".join(f"{n} {what}" for what, n in search.counts.most_common())
            click.echo(f"seed {one}, {time.process_time() - started:.0f} s: {found}")
    sys.exit(1 if search.finds else 0)


if __name__ == "__main__":
    main()
