"""Arrays between two nests that hold what the second one may compute itself.

`alpha * A @ x` makes an array of alpha * A first. Where an element of such an array is loaded, what
was stored there is computed again from the same operands, which nothing has changed meanwhile; the
array and the nest that fills it go (forward substitution; Allen and Kennedy, "Optimizing Compilers
for Modern Architectures", 2001). Every bit stays.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

from vividc.machine.opcodes import MEMORY, Opcode
from vividc.machine.words import WORD_BYTES
from vividc.ssa.analysis.counters import counter_of
from vividc.ssa.analysis.order import Order
from vividc.ssa.analysis.polynomial import Polynomial, Polynomials, symbol
from vividc.ssa.edit import FreshIds, replaced, with_blocks
from vividc.ssa.flow import Flow, Loop, find_loops, flow_of
from vividc.ssa.ir import Const, Function, Instr, Phi, Ref, Value, definition_of
from vividc.ssa.loops.forwarded import is_plain, own_arrays, reached
from vividc.ssa.loops.left_out import without_loops
from vividc.ssa.polyhedral.subscripts import FlatRows
from vividc.ssa.rewrite.dead import remove_unused

_CHEAP: Final = frozenset({Opcode.FADD, Opcode.FSUB, Opcode.FMUL, Opcode.FNEG, Opcode.FABS})
_FEW: Final = 2
_MOST: Final = 24
"""Operations that are computed again: in a deeper nest than the one that stored, and in others."""

_MOST_DIMENSIONS: Final = 2


def without_temporaries(function: Function) -> Function:
    """The function without arrays whose elements are computed again where they are loaded."""
    for name in own_arrays(function):
        found = _Temporary.of(function, name)
        function = (found and found.removed()) or function
    return function


@dataclass(frozen=True)
class _Temporary:
    """An array that one nest of counted loops, `loops` from the outside in, stores to once an
    iteration, at the place of their counters, and that others load from behind it.
    """

    function: Function
    store: Instr
    loads: tuple[Instr, ...]
    loops: tuple[Loop, ...]
    counters: tuple[Phi, ...]
    limits: tuple[Value, ...]
    order: Order
    rows: FlatRows
    flow: Flow

    @staticmethod
    def of(function: Function, name: str) -> _Temporary | None:
        """The array of this name, if it is one."""
        accesses = [
            i for b in function.blocks for i in b.instrs if i.op in MEMORY and i.array == name
        ]
        stores = [one for one in accesses if one.op is Opcode.STORE]
        loads = tuple(one for one in accesses if one.op is Opcode.LOAD)
        plain = all(_is_whole(one) for one in accesses)
        if len(stores) != 1 or not loads or not plain:
            return None
        homes = {function.block_of[one.id] for one in loads}
        home = function.block_of[stores[0].id]
        loops = [one for one in find_loops(function) if home in one.blocks]
        loops = [one for one in loops if not homes & one.blocks]
        loops.sort(key=lambda one: -len(one.blocks))
        counters = [counter_of(function, one) for one in loops]
        known = [one for one in counters if one is not None]
        if not loops or len(loops) > _MOST_DIMENSIONS or len(known) < len(loops):
            return None
        if any(one.initial != Const(0) or one.step != 1 for one in known):
            return None
        order = Order(function)
        made = _Temporary(
            function,
            stores[0],
            loads,
            tuple(loops),
            tuple(one.phi for one in known),
            tuple(one.limit for one in known),
            order,
            FlatRows(function, order),
            flow_of(function),
        )
        return made if made._is_filled() else None

    def _is_filled(self) -> bool:
        """Whether each iteration stores, at the place of the counters, before all loads."""
        home = self.function.block_of[self.store.id]
        inner = [*(loop.header for loop in self.loops[1:]), home]
        for loop, block in zip(self.loops, inner, strict=True):
            if len(loop.latches) != 1 or [source for source, _ in loop.exits] != [loop.header]:
                return False
            if not self.flow.dominates(block, loop.latches[0]):
                return False
        first = self.loops[0].header
        behind = (self.function.block_of[one.id] for one in self.loads)
        if not all(self.flow.dominates(first, block) for block in behind):
            return False
        mine = tuple(symbol(Ref(one.id)) for one in self.counters)
        return any(places == mine for places, _ in self._places(self.store))

    def _places(self, access: Instr) -> Iterator[tuple[tuple[Polynomial, ...], Value | None]]:
        """The subscripts of an access, as many as there are loops, and the length of rows; columns
        lie in their rows.
        """
        index = Polynomials(self.function, pitches=True).of(access.operands[1])
        if len(self.loops) == 1:
            if access.shift == self.store.shift and 1 << access.shift >= WORD_BYTES:
                yield (index,), None
            return
        block = self.function.block_of[access.id]
        for row, column, length in self.rows.candidates(access, index):
            if any(len(monomial) > 1 for part in (row, column) for monomial in part.terms):
                continue
            if self.order.lacks_below(self.order.of_terms(column), length, block) == ():
                yield (row, column), length

    def removed(self) -> Function | None:
        """The function without the array."""
        tree = self._tree()
        if tree is None or not self._is_unchanged(tree):
            return None
        lengths = {length for _, length in self._places(self.store)}
        made, ids = self.function, FreshIds(self.function)
        for load in self.loads:
            at = self._at(load, lengths)
            if at is None or not self._is_worth_it(load, tree):
                return None
            instrs, value = self._copied(tree, at, ids)
            made = _computed(made, load, instrs, value)
        made = remove_unused(replaced(made, {self.store.id: Const(0)}))
        left, taken = without_loops(made, {self.loops[0].header})
        stored = any(
            instr.op is Opcode.STORE
            for block in made.blocks
            if block.name in self.loops[0].blocks
            for instr in block.instrs
        )
        return left if taken and not stored else None

    def _tree(self) -> tuple[Instr, ...] | None:
        """What an iteration computes for what it stores, in order; None: it is not from counters
        and values from outside alone.
        """
        inside, found = self.loops[0].blocks, dict[int, Instr]()
        counters = {one.id for one in self.counters}

        def visit(value: Value) -> bool:
            made = definition_of(self.function, value)
            if made is None or made.id in found or made.id in counters:
                return True
            if self.function.block_of[made.id] not in inside:
                return True
            if isinstance(made, Phi) or (made.op in MEMORY and not _is_whole(made)):
                return False
            if len(found) > _MOST or not all(map(visit, made.operands)):
                return False
            found[made.id] = made
            return True

        return tuple(found.values()) if visit(self.store.operands[2]) else None

    def _is_unchanged(self, tree: tuple[Instr, ...]) -> bool:
        """Whether nothing stores to what the nest loads until the loads of the array, by whatever
        way that does not enter the nest again.
        """
        loaded = {one.array for one in tree if one.op is Opcode.LOAD}
        header = self.loops[0].header
        [(_, behind)] = self.loops[0].exits
        homes = {self.function.block_of[one.id] for one in self.loads}
        after = reached(self.flow.successors, {behind}, header)
        before = reached(self.flow.predecessors, homes, header)
        between = (after & before) | self.loops[0].blocks
        return not any(
            instr.op is Opcode.STORE and instr.array in loaded
            for name in between
            for instr in self.function.by_name[name].instrs
        )

    def _at(self, load: Instr, lengths: set[Value | None]) -> tuple[Value, ...] | None:
        """The counters of the iteration that has stored what is loaded."""
        block = self.function.block_of[load.id]
        for places, length in self._places(load):
            values = [_value(place) for place in places]
            known = [value for value in values if value is not None]
            if length not in lengths or len(known) < len(values):
                continue
            pairs = zip(known, self.limits, strict=True)
            if all(self.order.lacks_below(self.order.sum_of(v), n, block) == () for v, n in pairs):
                return tuple(known)
        return None

    def _copied(
        self, tree: tuple[Instr, ...], at: tuple[Value, ...], ids: FreshIds
    ) -> tuple[tuple[Instr, ...], Value]:
        """What an iteration computes with other counters, and the value that it stores."""
        values: dict[Value, Value] = {
            Ref(phi.id): value for phi, value in zip(self.counters, at, strict=True)
        }
        copies = []
        for one in tree:
            operands = tuple(values.get(value, value) for value in one.operands)
            copies.append(replace(one, id=ids(), operands=operands, distinct=""))
            values[Ref(one.id)] = Ref(copies[-1].id)
        stored = self.store.operands[2]
        return tuple(copies), values.get(stored, stored)

    def _is_worth_it(self, load: Instr, tree: tuple[Instr, ...]) -> bool:
        """Whether it takes little to compute again what is loaded."""
        block = self.function.block_of[load.id]
        around = [one for one in find_loops(self.function) if block in one.blocks]
        home = self.function.block_of[self.store.id]
        own = sum(home not in one.blocks for one in around)
        data = [one for one in tree if one.type is self.store_type(tree)]
        loads = sum(one.op is Opcode.LOAD for one in data)
        if own <= len(self.loops) and len(self.loads) == 1:
            return True
        return (
            loads <= 1
            and len(data) - loads <= _FEW
            and all(one.op in _CHEAP or one.op is Opcode.LOAD for one in data)
        )

    def store_type(self, tree: tuple[Instr, ...]) -> object:
        """The type of what is stored."""
        return next((one.type for one in tree if Ref(one.id) == self.store.operands[2]), None)


def _is_whole(access: Instr) -> bool:
    """Whether an access is to a whole word at its index, and no predicate's."""
    return is_plain(access) and not access.offset


def _value(place: Polynomial) -> Value | None:
    """The value that a polynomial is; None: it is a sum."""
    if place.constant is not None:
        return Const(place.constant) if place.constant >= 0 else None
    [(monomial, factor), *more] = place.terms.items()
    return monomial[0] if len(monomial) == 1 and factor == 1 and not more else None


def _computed(function: Function, load: Instr, instrs: tuple[Instr, ...], value: Value) -> Function:
    """The function with a value in place of a load, behind the instructions that compute it."""
    block = function.by_name[function.block_of[load.id]]
    place = next(n for n, one in enumerate(block.instrs) if one.id == load.id)
    made = replace(block, instrs=(*block.instrs[:place], *instrs, *block.instrs[place:]))
    return replaced(with_blocks(function, (made,)), {load.id: value})
