"""Loops that fill an array of the kernel's own before others store to all that they have stored to.

`np.zeros` makes an array of zeros, `np.eye` another one. Where all of its elements are given values
before any is loaded, nobody sees what was there before, and the loop that put it there goes (dead
stores of arrays: Feautrier, "Dataflow analysis of array and scalar references", 1991).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from vividc.machine.opcodes import MEMORY, Opcode
from vividc.machine.words import WORD_BYTES
from vividc.ssa.analysis.counters import counter_of
from vividc.ssa.analysis.levels import with_own_latches
from vividc.ssa.analysis.order import Order
from vividc.ssa.analysis.polynomial import Polynomial, Polynomials, constant, symbol
from vividc.ssa.flow import Loop, find_loops
from vividc.ssa.ir import Const, Function, Input, Instr, Ref, Value
from vividc.ssa.loops.forwarded import own_arrays
from vividc.ssa.loops.left_out import without_loops
from vividc.ssa.polyhedral.relations import Rectangle, overwrite
from vividc.ssa.polyhedral.scop import Scop, find_scop
from vividc.ssa.polyhedral.subscripts import element_bytes


def without_overwritten(function: Function) -> Function:
    """The function without loops that do nothing but store what is overwritten before it is read,
    in arrays that it makes.
    """
    own = {*own_arrays(function), *(param.name for param in function.params if param.made)}
    for header in [loop.header for loop in reversed(find_loops(function))]:
        loop = next((one for one in find_loops(function) if one.header == header), None)
        fill = None if loop is None else _Fill.of(function, loop)  # it went with one around it
        if fill is not None and fill.array in own and fill.is_overwritten():
            function, _ = without_loops(function, {header})
    return function


@dataclass(frozen=True)
class _Fill:
    """A loop whose stores are all to one array, whole words at one distance everywhere."""

    function: Function
    loop: Loop
    array: str

    @staticmethod
    def of(function: Function, loop: Loop) -> _Fill | None:
        """The loop, if it is one."""
        stored = {one.array for one in _accesses(function, loop.blocks) if one.op is Opcode.STORE}
        if len(stored) != 1:
            return None
        [array] = stored
        every = _accesses(function, function.by_name)
        stores = [one for one in every if one.array == array and one.op is Opcode.STORE]
        kinds = {(element_bytes(one), one.width, one.offset) for one in stores}
        return _Fill(function, loop, array) if kinds == {(WORD_BYTES, WORD_BYTES, 0)} else None

    def is_overwritten(self) -> bool:
        """Whether loops behind it store to all that it stores to, before anything is loaded."""
        behind = [loop for loop in self._behind() if self._is_accessed(loop.blocks, Opcode.STORE)]
        first = _part(self.function, self.loop) if behind else None
        parts = [] if first is None else [_part(self.function, loop) for loop in behind]
        known = [one for one in parts if one is not None]
        return first is not None and any(
            overwrite(self.array, known[: place + 1], wanted)
            for place, last in enumerate(known)
            for wanted in self._wanted(first, last)
        )

    def _behind(self) -> Iterator[Loop]:
        """Loops that run whenever this one has run, in order, before anything else is loaded from
        the array.
        """
        loops = {one.header: one for one in reversed(find_loops(self.function))}
        targets, met = {target for _, target in self.loop.exits}, set[str]()
        while len(targets) == 1:
            [name] = targets
            loop = loops.get(name)
            if name in met or (loop is not None and self.loop.header in loop.blocks):
                return
            met.add(name)
            if self._is_accessed({name} if loop is None else loop.blocks, Opcode.LOAD):
                return
            if loop is None:
                targets = {*self.function.by_name[name].branch.successors}
                continue
            yield loop
            targets = {target for _, target in loop.exits}

    def _is_accessed(self, blocks: Iterable[str], op: Opcode) -> bool:
        """Whether blocks load from the array, or store to it."""
        found = _accesses(self.function, blocks)
        return any(one.array == self.array and one.op is op for one in found)

    def _wanted(self, first: Scop, last: Scop) -> Iterator[Scop | Rectangle]:
        """What has to be overwritten, by subscripts as the last of the parts has them."""
        rows = last.rows.get(self.array)
        if first.rows.get(self.array) == rows:
            yield first
        elif rows is not None:
            found = self._rows(rows)
            if found is not None:
                yield Rectangle(found, rows)

    def _rows(self, columns: Input) -> Polynomial | None:
        """How many rows the loop fills, if it goes through the array word by word, and rows are as
        long as an input says.
        """
        counter = counter_of(self.function, self.loop)
        [store, *others] = (
            one for one in _accesses(self.function, self.loop.blocks) if one.op is Opcode.STORE
        )
        if counter is None or others or counter.initial != Const(0) or counter.step != 1:
            return None
        polynomials, header = Polynomials(self.function), self.loop.header
        place = polynomials.of(store.operands[1]).times(constant(1 << store.shift))
        if place != symbol(Ref(counter.phi.id)).times(constant(WORD_BYTES)):
            return None
        rows = dict[tuple[Value, ...], int]()
        for monomial, factor in polynomials.of(counter.limit).terms.items():
            if columns not in monomial:
                return None
            rest = list(monomial)
            rest.remove(columns)
            rows[tuple(rest)] = factor
        order = Order(self.function)
        found = Polynomial(rows)
        is_sum = all(len(monomial) <= 1 for monomial in rows)
        if not is_sum or not order.is_natural(columns, header):
            return None
        return found if order.is_proved(order.of_terms(found), order.facts(header)) else None


def _part(function: Function, loop: Loop) -> Scop | None:
    """A loop as a static-control part."""
    made = find_scop(with_own_latches(function, loop.header), loop.header)
    return made if isinstance(made, Scop) else None


def _accesses(function: Function, blocks: Iterable[str]) -> Iterator[Instr]:
    for name in blocks:
        yield from (one for one in function.by_name[name].instrs if one.op in MEMORY)
