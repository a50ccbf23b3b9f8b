"""What the threads of a group do in one iteration of a loop: copies of its blocks side by side.

There are no branches: a block runs for a thread under a predicate, and phis become choices. What is
uniform is computed once for all threads; a load of theirs, if one of them needs it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import reduce

from vividc.machine.opcodes import MEMORY, Opcode, Type
from vividc.ssa.analysis.acyclic import Edge
from vividc.ssa.analysis.levels import Level
from vividc.ssa.analysis.uniform import Uniform
from vividc.ssa.ir import Block, Const, Function, Input, Instr, Ref, Value
from vividc.ssa.loops.threads.chain import Chain
from vividc.ssa.loops.threads.paths import Paths


@dataclass(frozen=True)
class Group:
    """What is fixed while a loop is rewritten for a group of threads.

    Attributes
    ----------
    values
        For each thread what stands for the ids of `function`.
    private
        Arrays of which every thread has its own, by thread: the names.
    is_spread
        A tile may hold slices of arrays.
    """

    function: Function
    uniform: Uniform
    chain: Chain
    values: tuple[dict[int, Value], ...]
    private: tuple[dict[str, str], ...]
    is_spread: bool = False

    @property
    def threads(self) -> range:
        """Numbers of the threads."""
        return range(len(self.values))

    def value(self, thread: int, value: Value) -> Value:
        """`value` as the thread knows it."""
        if isinstance(value, Ref):
            return self.values[thread].get(value.id, value)
        if isinstance(value, Input) and value.key[1:] in self.private[thread]:
            return Input(f"&{self.private[thread][value.key[1:]]}")
        return value


class Body:
    """One iteration of a level for all threads.

    Parameters
    ----------
    active
        For each thread whether it takes part at all; None: it does.
    done
        For each thread whether it has left the loop before; None if all leave together.
    ahead
        Ids of loads that may run before it is known whether their thread is done.
    entered
        For each thread whether it came to the loop, where `active` does not say so.
    """

    def __init__(
        self,
        group: Group,
        level: Level,
        active: list[Value | None],
        done: list[Value] | None = None,
        ahead: frozenset[int] = frozenset(),
        entered: list[Value | None] | None = None,
    ) -> None:
        self.group, self.level = group, level
        self.chain = group.chain
        self.active, self.done, self.ahead = active, done, ahead
        self.entered = active if entered is None else entered
        self.paths = [Paths(level, group.chain) for _ in group.threads]
        self.exits = level.exits
        own = {phi.id for phi in level.header.phis}
        self.carried = tuple(
            frozenset(v for i in own if isinstance(v := values.get(i), Ref))
            for values in group.values
        )

    def block(self, block: Block, threads: Iterable[int]) -> None:
        """Write a block of the level's own for these threads."""
        threads = tuple(threads)
        if block.name != self.level.loop.header:
            for phi in block.phis:
                for thread in threads:
                    self._phi(thread, block.name, phi.id)
        for instr in block.instrs:
            if instr.id not in self.group.uniform.values:
                for thread in threads:
                    self._own(thread, block.name, instr)
            elif instr.id not in self.group.values[0]:
                self._shared(block.name, instr)
        if block.branch.cond is not None:
            for thread in threads:
                cond = self.group.value(thread, block.branch.cond)
                self.paths[thread].conditions[block.name] = cond

    def takes_part(self, thread: int, block: str) -> Value | None:
        """Whether a thread runs a block in this iteration; None: it does."""
        with self.chain.thread(thread, self._decision(block)):
            path = self.paths[thread].of(self.level.node(block))
            if self.done is None:
                return self.chain.both(self.active[thread], path)
            return self.chain.unless(self.done_before(thread, block), path)

    def done_before(self, thread: int, block: str) -> Value:
        """Whether a thread has left the loop before it comes to a block."""
        before = [edge for edge in self.level.exits_before(block) if edge in self.exits]
        return self._done(thread, before)

    def done_after(self, thread: int) -> Value:
        """Whether a thread has left the loop with this iteration or before."""
        return self._done(thread, self.exits)

    def left(self, thread: int, edge: Edge) -> Value:
        """Whether a thread, if it was in the loop, leaves along this edge and no earlier one."""
        with self.chain.thread(thread, self._decision(edge[0])):
            earlier = self.exits[: self.exits.index(edge)]
            taken = self.paths[thread].leaving(edge)
            stops = [self.paths[thread].leaving(other) for other in earlier]
            for stop in stops:
                taken = self.chain.unless(stop, taken) or taken
            return taken

    def _done(self, thread: int, exits: Iterable[Edge]) -> Value:
        assert self.done is not None
        total = self.done[thread]
        for edge in exits:
            with self.chain.thread(thread, self._decision(edge[0])):
                taken = self.paths[thread].leaving(edge)
                either = taken if total == Const(0) else self.chain.either(total, taken)
                assert either is not None
                total = either
        return total

    def _decision(self, block: str) -> int:
        """What stands for the origin of operations that decide whether a block runs."""
        return -1 - list(self.level.blocks).index(block)

    def _phi(self, thread: int, block: str, ident: int) -> None:
        phi = next(phi for phi in self.level.blocks[block].phis if phi.id == ident)
        with self.chain.thread(thread, ident, phi.loc):
            given = {name: self.group.value(thread, value) for name, value in phi.incoming}
            paths = self.paths[thread]
            merged = paths.merged(block, phi, given, self.carried[thread])
            self.group.values[thread][ident] = merged

    def _own(self, thread: int, block: str, instr: Instr) -> None:
        """A thread's copy of an instruction."""
        when: Value | None = None
        if instr.op in MEMORY:
            when = None if self.runs_ahead(instr) else self.takes_part(thread, block)
        with self.chain.thread(thread, instr.id, instr.loc):
            operands = [self.group.value(thread, value) for value in instr.operands]
            if instr.op in MEMORY and self.runs_ahead(instr):
                inside = inside_array(self.group, instr, operands)
                when = self.chain.both(inside, self._inside_slice([thread], block))
            array = self.group.private[thread].get(instr.array, instr.array)
            self.group.values[thread][instr.id] = self._copy(instr, operands, when, array)

    def _shared(self, block: str, instr: Instr) -> None:
        """An instruction for all threads."""
        operands = [self.group.value(0, value) for value in instr.operands]
        when: Value | None = None
        if instr.op in MEMORY:
            when = self._anyone(block)
            if when is not None and self.runs_ahead(instr):
                inside = inside_array(self.group, instr, operands)
                when = self.chain.both(inside, self._inside_slice(self.group.threads, block))
        done = self._copy(instr, operands, when, instr.array, exact=instr.exact)
        for values in self.group.values:
            values[instr.id] = done

    def _inside_slice(self, threads: Iterable[int], block: str) -> Value | None:
        """When a load that runs ahead reads what a tile has of the array; None: it has all of it.

        A slice holds what iterations of the tile's own may read where the conditions around the
        load hold, whether or not they have left the loop before.
        """
        if not self.group.is_spread:
            return None
        predicates: list[Value | None] = []
        for thread in threads:
            with self.chain.thread(thread, self._decision(block)):
                path = self.paths[thread].of(self.level.node(block))
                before = [edge for edge in self.level.exits_before(block) if edge in self.exits]
                for edge in before:
                    path = self.chain.unless(self.paths[thread].leaving(edge), path)
                predicates.append(self.chain.both(self.entered[thread], path))
        return reduce(self.chain.either, predicates)

    def _anyone(self, block: str) -> Value | None:
        """Whether some thread runs a block, given that one is in the loop; None: it does."""
        node = self.level.node(block)
        paths = [self._path(thread, node) for thread in self.group.threads]
        if len(set(paths)) == 1 and not set(self.level.exits_before(block)) & set(self.exits):
            return paths[0]
        each = [self.takes_part(thread, block) for thread in self.group.threads]
        return reduce(self.chain.either, each)

    def _path(self, thread: int, node: str) -> Value | None:
        with self.chain.thread(thread, self._decision(node)):
            return self.paths[thread].of(node)

    def _copy(
        self,
        instr: Instr,
        operands: list[Value],
        when: Value | None,
        array: str,
        *,
        exact: bool = False,
    ) -> Value:
        if instr.op in MEMORY and when is not None:
            operands = [*operands, *self._guard(instr, operands, when)]
        made = replace(
            instr, operands=tuple(operands), array=array, distinct="", exact=exact, lane=None
        )
        return self.chain.copy(made)

    def _guard(self, instr: Instr, operands: list[Value], when: Value) -> list[Value]:
        """The predicate of an access, with the one that it has."""
        count = len(operands)
        plain = 2 if instr.op is Opcode.LOAD else 3
        if count == plain:
            return [when]
        both = self.chain.both(operands.pop(), when)
        assert both is not None
        return [both]

    def runs_ahead(self, instr: Instr) -> bool:
        """Whether a load does not wait for the threads' ends, but tests its address."""
        return instr.id in self.ahead


def inside_array(group: Group, instr: Instr, operands: list[Value]) -> Value:
    """Whether the address of a load lies in its array; see `can_test_address`."""
    index, size = operands[1], _elements(group, instr)
    assert size is not None
    element = 1 << instr.shift
    if instr.offset:
        ahead = Const((instr.offset // element) & 0xFFFFFFFF)
        index = group.chain.emit(Opcode.ADD, Type.I32, index, ahead)
    return group.chain.emit(Opcode.ICMP_ULT, Type.PRED, index, size)


def can_test_address(function: Function, instr: Instr) -> bool:
    """Whether one comparison tells that the address of a load lies in its array: the index counts
    elements of an array of known size from its start.
    """
    element = 1 << instr.shift
    plain = instr.width == element and instr.offset % element == 0 and len(instr.operands) == 2  # noqa: PLR2004
    if not plain or instr.operands[0] != Input(f"&{instr.array}"):
        return False
    param = next((p for p in function.params if p.name == instr.array and not p.flat), None)
    local = next((a for a in function.locals if a.name == instr.array), None)
    return param is not None or (local is not None and local.words > 0)


def _elements(group: Group, instr: Instr) -> Value | None:
    for local in group.function.locals:
        if local.name == instr.array:
            return Const(4 * local.words // instr.width)
    for param in group.function.params:
        if param.name == instr.array:
            shape: list[Value] = [Input(f"{param.name}.shape{n}") for n in range(param.ndim)]
            return reduce(lambda a, b: group.chain.emit(Opcode.MUL, Type.I32, a, b), shape)
    return None
