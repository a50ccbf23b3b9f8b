"""Moves loads that read the same word in every iteration in front of the loop.

Such a load takes a load/store unit once an iteration, and there are few of those. It moves under a
predicate, that the loop runs at all: what it would read otherwise may lie outside its array.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from vividc.machine.opcodes import MEMORY, Opcode, Type
from vividc.ssa.analysis.strides import different_elements
from vividc.ssa.edit import block_of, defined_types, incoming, next_id, with_blocks
from vividc.ssa.flow import Loop, find_loops, pipelined_loops, preheader_of
from vividc.ssa.ir import Block, Const, Function, Instr, Ref, Value
from vividc.ssa.rewrite.hoist import hoist_invariants

_PREDICATE = 2
"""Position of a load's predicate among its operands."""

_WORTH_IT = 3
"""Fewer loads stay: they cost the loop less than what comes before it. One that a divisor is made
of goes all the same: quotients by what the loop does not change cost a quarter.
"""


def hoist_loads(function: Function) -> Function:
    """Moves loads of fixed addresses out of the innermost loops that no other loop contains, and
    what is computed from them; out of other innermost loops those that make a divisor fixed.

    The loops are canonical. A loop inside another one keeps other loads: its preheader runs as
    often as the outer loop, and may cost more than the loop gains.
    """
    every = find_loops(function)
    done = function
    for loop in pipelined_loops(function):
        alone = not any(loop.header in o.blocks and o.header != loop.header for o in every)
        done = _Hoister(done, loop).run(all_loads=alone)
    return done if done is function else hoist_invariants(done)


@dataclass
class Preface:
    """What is to come at the end of a loop's preheader; `blocks` are those of the loop."""

    function: Function
    loop: Loop
    before: list[Instr] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Finds what the loop computes."""
        self.blocks = {b.name: b for b in self.function.blocks if b.name in self.loop.blocks}
        self.inside = {i for block in self.blocks.values() for i in defined_types(block)}
        self.free = next_id(self.function)

    def preheader(self) -> Block:
        """The preheader with it."""
        block = block_of(self.function, preheader_of(self.function, self.loop))
        return replace(block, instrs=(*block.instrs, *self.before))

    def entered(self, header: Block) -> Value | None:
        """The header's test in the first iteration, 1 if it stays; None if it reads memory."""
        assert header.branch.cond is not None
        test = self._first(header, header.branch.cond)
        if test is None or header.branch.target in self.loop.blocks:
            return test
        return self.emit(Instr(0, Opcode.XOR, Type.PRED, (test, Const(1)), loc=header.branch.loc))

    def _first(self, header: Block, value: Value) -> Value | None:
        """A value of the header in the first iteration."""
        if not isinstance(value, Ref) or value.id not in self.inside:
            return value
        preheader = preheader_of(self.function, self.loop)
        for phi in header.phis:
            if phi.id == value.id:
                return incoming(phi, preheader)
        instr = next((i for i in header.instrs if i.id == value.id), None)
        if instr is None or instr.op in MEMORY:
            return None
        operands = [self._first(header, operand) for operand in instr.operands]
        known = tuple(operand for operand in operands if operand is not None)
        return self.emit(replace(instr, operands=known)) if len(known) == len(operands) else None

    def emit(self, instr: Instr) -> Value:
        """The result of an instruction, under a number of its own."""
        self.before.append(replace(instr, id=self.free))
        self.free += 1
        return Ref(self.free - 1)


@dataclass
class _Hoister(Preface):
    def __post_init__(self) -> None:
        super().__post_init__()
        self.stores = [
            instr
            for block in self.blocks.values()
            for instr in block.instrs
            if instr.op is Opcode.STORE
        ]

    def run(self, *, all_loads: bool) -> Function:
        """The function with the loads before the loop, all or those that divisors are made of, or
        as it was.
        """
        inside = frozenset(self.inside)
        loads: set[int] = set()
        for load, guard in self._loads():
            self.before.append(replace(load, operands=self._guarded(load, guard)))
            loads.add(load.id)
        is_worth_it = all_loads and len(loads) >= _WORTH_IT
        moved = loads if is_worth_it else self._of_divisors(inside, loads)
        if not moved:
            return self.function
        self.before = [i for i in self.before if i.id in moved or i.id not in loads]
        changed = [
            replace(block, instrs=tuple(i for i in block.instrs if i.id not in moved))
            for block in self.blocks.values()
        ]
        return with_blocks(self.function, [*changed, self.preheader()])

    def _of_divisors(self, inside: frozenset[int], loads: set[int]) -> set[int]:
        """Those of the loads by which divisors that the loop computes become fixed, with all that
        the addresses of these loads are computed from.
        """
        made = {i.id: i for block in self.blocks.values() for i in block.instrs}
        wanted: set[int] = set()
        for division in made.values():
            if division.op is not Opcode.FDIV:
                continue
            needed: set[int] = set()
            work = [v.id for v in division.operands[1:] if isinstance(v, Ref) and v.id in inside]
            while work:
                ident = work.pop()
                if ident not in needed:
                    needed.add(ident)
                    operands = made[ident].operands if ident in made else ()
                    work += [v.id for v in operands if isinstance(v, Ref) and v.id in inside]
            read = {n for n in needed if n not in made or made[n].op in MEMORY}
            wanted |= read if read <= loads else set()
        return wanted

    def _guarded(self, load: Instr, guard: Value | None) -> tuple[Value, ...]:
        """Operands of a load that runs under `guard` only, and under its own predicate if any."""
        plain, own = load.operands[:_PREDICATE], load.operands[_PREDICATE:]
        if guard is None or not own:
            return load.operands if guard is None else (*plain, guard)
        return (*plain, self.emit(Instr(0, Opcode.AND, Type.PRED, (own[0], guard), loc=load.loc)))

    def _loads(self) -> Iterator[tuple[Instr, Value | None]]:
        """Loads to move, each with the predicate under which the first iteration runs it."""
        for block, guard in self._always_run():
            for instr in block.instrs:
                if instr.op is Opcode.LOAD and self._is_fixed(instr):
                    self.inside.discard(instr.id)
                    yield instr, guard

    def _always_run(self) -> Iterator[tuple[Block, Value | None]]:
        """Blocks that the first iteration runs if the test at the header, where there is one, lets
        it.
        """
        block, guard = self.blocks[self.loop.header], None
        seen: set[str] = set()
        while block.name not in seen:
            seen.add(block.name)
            yield block, guard
            within = [name for name in block.branch.successors if name in self.loop.blocks]
            if len(within) != 1:
                return
            if len(block.branch.successors) > 1:
                if block.name != self.loop.header or within[0] == self.loop.header:
                    return
                guard = self.entered(block)
                if guard is None:
                    return
            block = self.blocks[within[0]]

    def _is_fixed(self, load: Instr) -> bool:
        if any(isinstance(v, Ref) and v.id in self.inside for v in load.operands):
            return False
        return not any(
            store.array == load.array and not different_elements(store.subscript, load.subscript)
            for store in self.stores
        )
