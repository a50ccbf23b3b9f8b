"""What must hold of a loop over `prange` before a launch may spread it over tiles.

Each tile runs the whole kernel with a part of the loop's iterations, on memory of its own. That is
what one tile computes if

- every value that leaves the loop is a reduction, and the kernel returns it however it ends,
- no tile reads what iterations on another wrote to an array of the kernel's own, and
- what iterations write is not taken for all of an array where the loop may not run.

Arrays of arguments are looked at when the launch's sizes are known (`sim/accelerator/chunks`).
What is not proved runs on one tile.
"""

from __future__ import annotations

from collections.abc import Sequence

import networkx as nx

from vividc.errors import KernelError, SourceLoc
from vividc.machine.opcodes import MEMORY, Opcode
from vividc.machine.parallel import ANY, COUNTER, INDEX, STEPS, UNION, WIDE_HIGH, WIDE_LOW
from vividc.machine.params import TRAP, LocalArray, named_array
from vividc.ssa.analysis.counters import defined_in
from vividc.ssa.analysis.reductions import FoundReduction
from vividc.ssa.flow import Loop, block_graph, dominators
from vividc.ssa.ir import Block, Const, Function, Instr, Ref, Value
from vividc.ssa.parallel.terms import TermTable


def runs_for_certain(function: Function, loop: Loop) -> bool:
    """Whether every way through the kernel leads to the loop, or to an error of the simulation,
    after which memory is as it was.
    """
    before = dominators(function)
    ends = [b.name for b in function.blocks if b.branch.target is None and not ends_simulation(b)]
    return all(loop.header in before.get(name, {loop.header}) for name in ends)


def ends_simulation(block: Block) -> bool:
    """Whether a block ends the simulation with an error: it stores to an array of no words."""
    return any(i.op is Opcode.STORE and i.array.startswith(TRAP) for i in block.instrs)


def raises(function: Function, block: Block) -> bool:
    """Whether a block ends the kernel with an exception, so that nobody sees what it returns."""
    error = "" if function.results is None else function.results.error
    return block.branch.target is None and (
        ends_simulation(block) or (error != "" and any(i.array == error for i in block.instrs))
    )


def returned_reduction(
    function: Function, loop: Loop, reductions: Sequence[FoundReduction]
) -> int | None:
    """The reduction that is returned, by number.

    Raises
    ------
    KernelError
        Anything else that the loop computes is used after it, or the kernel may return another
        value.
    """
    return _Leaving(function, loop, reductions).result()


class _Leaving:
    """Follows the values that a loop hands to the blocks after it."""

    def __init__(self, function: Function, loop: Loop, carried: Sequence[FoundReduction]) -> None:
        self._function = function
        self._reductions = carried
        self._own = {item.phi: number for number, item in enumerate(carried)}
        self._inside = defined_in(function, loop)
        self._after = [block for block in function.blocks if block.name not in loop.blocks]
        self._loc = _start(function, loop)
        self._same = self._copies()

    def result(self) -> int | None:
        for block in self._after:
            self._demand_unused(block)
        ends = [
            block
            for block in self._after
            if block.branch.target is None and not raises(self._function, block)
        ]
        results = {self._of_return(block) for block in ends}
        if len(results) > 1:
            raise KernelError(
                "the kernel returns the result of the loop over prange in some cases, and another "
                "value where that loop does not run",
                loc=self._loc,
                hint="let it run in any case, with no iterations, as in prange(n if ok else 0)",
            )
        return results.pop() if results else None

    def _copies(self) -> dict[int, Value]:
        """Phis after the loop that are a value of it, whichever way was taken."""
        same: dict[int, Value] = {}
        changed = True
        while changed:
            changed = False
            for phi in (phi for block in self._after for phi in block.phis):
                values = {self._plain(value, same) for _, value in phi.incoming} - {Ref(phi.id)}
                if phi.id not in same and len(values) == 1:
                    same[phi.id] = values.pop()
                    changed = True
        return same

    @staticmethod
    def _plain(value: Value, same: dict[int, Value]) -> Value:
        while isinstance(value, Ref) and value.id in same:
            value = same[value.id]
        return value

    def _comes_from_loop(self, value: Value) -> bool:
        value = self._plain(value, self._same)
        return isinstance(value, Ref) and value.id in self._inside

    def _demand_unused(self, block: Block) -> None:
        read = [value for instr in block.instrs for value in instr.operands]
        read += [v for phi in block.phis if phi.id not in self._same for _, v in phi.incoming]
        if block.branch.cond is not None:
            read.append(block.branch.cond)
        if any(self._comes_from_loop(value) for value in read):
            raise self._used(block)

    def _of_return(self, block: Block) -> int | None:
        low, high = (
            None if word is None else self._plain(word, self._same)
            for word in (block.branch.value, block.branch.high)
        )
        if not any(word is not None and self._comes_from_loop(word) for word in (low, high)):
            return None
        if not isinstance(low, Ref) or low.id not in self._own or not self._is_whole(low, high):
            raise self._used(block)
        return self._own[low.id]

    def _is_whole(self, low: Ref, high: Value | None) -> bool:
        """Whether a reduction is returned as what it is: one word, or both words of a sum."""
        number = self._own[low.id]
        item = self._reductions[number]
        if item.how.op != WIDE_LOW:
            return high in (None, Const(0)) and item.how.op != WIDE_HIGH
        return high is None or high == Ref(self._reductions[number + 1].phi)

    def _used(self, block: Block) -> KernelError:
        loc = block.branch.loc or _first_loc(block) or self._loc
        return KernelError(
            "what the loop over prange computes is used after it",
            loc=loc,
            hint="return the sum, minimum or maximum as it is, and go on with it on the host",
        )


def _first_loc(block: Block) -> SourceLoc | None:
    return next((instr.loc for instr in block.instrs if instr.loc is not None), None)


def own_arrays_not_apart(
    function: Function, loop: Loop, table: TermTable
) -> dict[str, KernelError]:
    """The kernel's own arrays of which a tile may read what an iteration on another wrote, if each
    tile has one of its own; with what to tell of them.

    An array that an iteration makes is its own; one made before the loop may be written by
    iterations if nothing reads it after them, and in the loop each reads the one element that it
    writes.
    """
    after = _reached_from(function, loop)
    found: dict[str, KernelError] = {}
    for local in function.locals:
        if local.contents is not None or local.name.startswith(TRAP):
            continue
        accesses = [
            (block, instr)
            for block in function.blocks
            for instr in block.instrs
            if instr.op in MEMORY and instr.array == local.name
        ]
        outside = [instr for block, instr in accesses if block.name not in loop.blocks]
        within = [(block, instr) for block, instr in accesses if block.name in loop.blocks]
        stored = next((i for _, i in within if i.op is Opcode.STORE), None)
        if stored is None or (is_made_in(function, loop, local) and not outside):
            continue
        read = [
            (block, instr)
            for block, instr in accesses
            if instr.op is Opcode.LOAD and block.name in after
        ]
        late = [instr for block, instr in read if block.name not in loop.blocks]
        if late or (read and not _each_its_own(within, table)):
            found[local.name] = _shared(local, stored, late or [instr for _, instr in read])
    return found


def is_made_in(function: Function, loop: Loop, local: LocalArray) -> bool:
    """Whether each iteration of a loop makes an array anew."""
    return _start(function, loop) in local.loops


def _shared(local: LocalArray, stored: Instr, read: list[Instr]) -> KernelError:
    lines = sorted({instr.loc.line for instr in read if instr.loc is not None})
    where = f" and reads it in line {', '.join(map(str, lines))}" if lines else " and reads it"
    return KernelError(
        f"iterations of the loop over prange write {named_array(local.name)}, of which each tile "
        f"has one of its own,{where}",
        loc=stored.loc,
        hint="make the array in the loop, or pass it as an argument",
    )


def _start(function: Function, loop: Loop) -> SourceLoc | None:
    return next(b for b in function.blocks if b.name == loop.header).branch.loc


def _reached_from(function: Function, loop: Loop) -> set[str]:
    """Blocks that run in the loop or after it."""
    graph = block_graph(function)
    behind: set[str] = nx.descendants(graph, loop.header)
    return behind | {loop.header}


def _each_its_own(accesses: list[tuple[Block, Instr]], table: TermTable) -> bool:
    """Whether an iteration touches one element only, and no other iteration that one."""
    places = {
        (table.of(instr.operands[1]), instr.operands[0], instr.shift, instr.offset, instr.width)
        for _, instr in accesses
    }
    if len(places) != 1:
        return False
    number, _, shift, _, width = places.pop()
    return width <= 1 << shift and _is_injective(table, number)


def _is_injective(table: TermTable, number: int) -> bool:
    """Whether a term is the loop's variable, and what every tile adds to it alike."""
    term = table.terms[number]
    if term.op == INDEX:
        return True
    if term.op not in (Opcode.ADD.value, Opcode.SUB.value):
        return False
    left, right = term.args
    if term.op == Opcode.ADD.value and is_exact(table, left):
        left, right = right, left
    return is_exact(table, right) and _is_injective(table, left)


def is_exact(table: TermTable, number: int) -> bool:
    """Whether the host knows a term's value before the kernel starts."""
    term = table.terms[number]
    if term.op in (ANY, INDEX, COUNTER, STEPS, UNION):
        return False
    return all(is_exact(table, arg) for arg in term.args)
