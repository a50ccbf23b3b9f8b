"""Threads of a tile: consecutive iterations of a parallel loop run side by side in one.

The copies of an iteration are merged into straight code under predicates, and each loop of theirs
into one loop, which runs until all threads have left theirs; one that has is masked. The loop's
iterations are independent, by contract (`numba.prange`) or as the caller has proved: nothing is
asked of memory here. What all threads have in common is computed once, loads of one address
included. Every word is what it was.

Thread coarsening (Magni, Dubach and O'Boyle 2013) by unroll-and-jam, with the predicated execution
of divergent threads (Lorie and Strong 1984).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import networkx as nx

from vividc.machine.opcodes import MEMORY, Opcode, Type
from vividc.machine.parallel import FIRST, LAST
from vividc.machine.params import TRAP, LocalArray
from vividc.machine.words import signed
from vividc.ssa.analysis.counted import count_loop
from vividc.ssa.analysis.induction import constant_step
from vividc.ssa.analysis.levels import Level, level_of, with_own_latches
from vividc.ssa.analysis.uniform import uniform_values
from vividc.ssa.edit import (
    block_of,
    incoming,
    next_id,
    rename_incoming,
    retarget,
    substitute,
    uses,
    with_blocks,
)
from vividc.ssa.flow import find_loops, preheader_of
from vividc.ssa.ir import Branch, Const, Function, Input, Instr, Phi, Ref, Value
from vividc.ssa.loops.threads.body import Body, Group
from vividc.ssa.loops.threads.chain import Chain
from vividc.ssa.loops.threads.loop import Form, ThreadLoop
from vividc.ssa.rewrite.normalize import canonical_loops
from vividc.ssa.rewrite.refusal import Refusal

MOST_THREADS = 8


@dataclass(frozen=True)
class Threaded:
    """`main` is the header of the loop over groups, `loops` those of its inner loops: each with the
    header of the loop that it was. The threads of those in `free` leave them one by one.
    """

    function: Function
    main: str
    loops: tuple[tuple[str, str], ...]
    free: frozenset[str] = frozenset()


def thread(function: Function, header: str, count: int) -> Threaded | Refusal:
    """Runs `count` iterations of a parallel loop as threads of one.

    The last group may have fewer; its other threads are masked from the start.

    Parameters
    ----------
    header
        Of a loop whose iterations are independent but for variables that they only hand on. It
        counts, and is left at its header.
    count
        2 to 8.
    """
    function = with_own_latches(canonical_loops(function), header)
    refused = _objection(function, header)
    if refused is not None:
        return refused
    level = level_of(function, header)
    for inner in level.all_levels():
        if not nx.is_directed_acyclic_graph(inner.flow.graph):
            return Refusal("its control flow has a loop with two entries")
    preheader = preheader_of(function, level.loop)
    counted, trip = count_loop(function, level.loop, preheader)
    if trip is None:
        return Refusal(
            "its trip count is not known when it starts, as that of a loop over a range is"
        )
    if _has_hidden_base(function, level):
        return Refusal("an address in an array that it makes is computed before it")
    handed = _handed_on(level)
    if isinstance(handed, Refusal):
        return handed
    return _Threads(counted, level, count, trip.value, preheader, handed).run()


def _objection(function: Function, header: str) -> Refusal | None:
    loop = next(loop for loop in find_loops(function) if loop.header == header)
    if {source for source, _ in loop.exits} != {header} or loop.latches == (header,):
        return Refusal("it is left from elsewhere than its start")
    inside = [o for o in find_loops(function) if o.header in loop.blocks]
    if any(o.header in function.sequential for o in inside):
        return Refusal("a loop in it runs block by block")
    if any(not o.exits for o in inside):
        return Refusal("a loop in it never ends")
    return None


@dataclass(frozen=True)
class _HandedOn:
    """Phis of the parallel loop: the steps of its counters, and variables that each iteration hands
    on to the next, with the nodes after the last inner loop, which alone read those.
    """

    steps: dict[int, int]
    variables: tuple[Phi, ...]
    last: tuple[str, ...]


def _handed_on(level: Level) -> _HandedOn | Refusal:
    steps: dict[int, int] = {}
    variables = []
    for phi in level.header.phis:
        step = constant_step(level.function, level.loop, phi)
        if step is not None and phi.id not in level.leaving:
            steps[phi.id] = step
        else:
            variables.append(phi)
    inner = [index for index, node in enumerate(level.flow.order) if node in level.children]
    last = level.flow.order[inner[-1] + 1 :] if inner else level.flow.order
    for ident in level.leaving:
        if not any(phi.id == ident for phi in variables):
            return Refusal("what it computes is used after it, other than what it hands on")
    for phi in variables:
        if _read_before(level, phi.id, last):
            line = "" if phi.loc is None else f" (line {phi.loc.line})"
            return Refusal(f"an iteration needs what the one before computed in its loops{line}")
    return _HandedOn(steps, tuple(variables), tuple(last) if variables else ())


def _read_before(level: Level, ident: int, last: tuple[str, ...]) -> bool:
    """Whether a value is read elsewhere than in the nodes `last`."""
    for name, block in level.blocks.items():
        if name not in last and Ref(ident) in uses(block):
            return True
        for phi in block.phis:
            for source, value in phi.incoming:
                at_home = name in last or name == level.loop.header
                if value == Ref(ident) and not (at_home and source in (*last, level.loop.header)):
                    return True
    return False


@dataclass
class _Threads:
    """Rewrites one loop.

    Attributes
    ----------
    function
        With the loop's iterations, `trips`, computed in `preheader`.
    level
        The loop, of the function before.
    """

    function: Function
    level: Level
    count: int
    trips: Value
    preheader: str
    handed: _HandedOn

    def run(self) -> Threaded:
        """The function whose loop runs groups of threads."""
        self.names = {block.name for block in self.function.blocks}
        self.main = self.fresh(f"{self.level.loop.header}.groups")
        inner = [item for item in self.level.all_levels() if item is not self.level]
        self.headers = {i.loop.header: self.fresh(f"{i.loop.header}.threads") for i in inner}
        self.free: set[str] = set()
        regions = (self.main, *self.headers.values())
        chain = Chain(next_id(self.function), regions)
        private = tuple(self._private_names(t) for t in range(self.count))
        own_loads = self._own_loads()
        uniform = uniform_values(self.level, own_loads)
        values = tuple(dict[int, Value]() for _ in range(self.count))
        spread = is_spread(self.function)
        self.group = Group(self.level.function, uniform, chain, values, private, spread)
        self.chain = chain
        return self._write()

    def fresh(self, stem: str) -> str:
        """A block name that is not in use."""
        name, number = stem, 0
        while name in self.names:
            number += 1
            name = f"{stem}.{number}"
        self.names.add(name)
        return name

    def _write(self) -> Threaded:
        chain, group, level = self.chain, self.group, self.level
        loc = level.header.branch.loc
        enter = self.fresh(f"{self.main}.enter")
        chain.open(enter)
        groups = self._groups()
        starts = {p.id: incoming(p, self.preheader) for p in level.header.phis}
        chain.close(Branch(self.main, loc=loc))
        chain.open(self.main)
        number = chain.phi(Type.I32, (enter, Const(0)), loc=loc)
        phis = {
            p.id: chain.phi(p.type, (enter, starts[p.id]), loc=p.loc) for p in level.header.phis
        }
        test = chain.emit(Opcode.ICMP_SLT, Type.PRED, Ref(number.id), groups)
        first = self.fresh(f"{self.main}.body")
        [behind] = [target for _, target in level.loop.exits]
        chain.close(Branch(first, test, behind, loc=loc))
        chain.open(first)
        active = self._active(number)
        self._number(phis)
        variables = self._body(Body(group, level, active), active)
        self._close(number, phis, variables)
        return self._wired(behind, phis, enter)

    def _groups(self) -> Value:
        """How many groups there are."""
        if isinstance(self.trips, Const):
            return Const(-(-_natural(self.trips) // self.count))
        least = self.chain.emit(Opcode.SMAX, Type.I32, self.trips, Const(0))
        more = self.chain.emit(Opcode.ADD, Type.I32, least, Const(self.count - 1))
        if self.count & (self.count - 1):
            return self.chain.emit(Opcode.UDIV, Type.I32, more, Const(self.count))
        by = Const(self.count.bit_length() - 1)
        return self.chain.emit(Opcode.LSHR, Type.I32, more, by)

    def _active(self, number: Phi) -> list[Value | None]:
        """For each thread whether there is an iteration for it; the first one always has one."""
        if isinstance(self.trips, Const) and _natural(self.trips) % self.count == 0:
            return [None] * self.count
        done = self.chain.emit(Opcode.MUL, Type.I32, Ref(number.id), Const(self.count))
        rest = self.chain.emit(Opcode.SUB, Type.I32, self.trips, done)
        return [None] + [
            self.chain.emit(Opcode.ICMP_SLT, Type.PRED, Const(thread), rest)
            for thread in range(1, self.count)
        ]

    def _number(self, phis: dict[int, Phi]) -> None:
        """The words of the loop's counters in each thread, and of its variables in the first."""
        for phi in self.level.header.phis:
            first = Ref(phis[phi.id].id)
            self.group.values[0][phi.id] = first
            for thread in range(1, self.count):
                step = self.handed.steps.get(phi.id)
                if step is not None:
                    ahead = Const(step * thread & 0xFFFFFFFF)
                    moved = self.chain.emit(Opcode.ADD, Type.I32, first, ahead)
                    self.group.values[thread][phi.id] = moved

    def _body(self, body: Body, active: list[Value | None]) -> dict[int, Value]:
        """One group; the variables' words after it."""
        last = self.handed.last
        self._nodes(body, [node for node in self.level.flow.order if node not in last])
        values = self.group.values
        variables: dict[int, Value] = {}
        for thread in range(self.count if last else 0):
            self._nodes(body, list(last), (thread,))
            for phi in self.handed.variables:
                again = self.group.value(thread, incoming(phi, self.level.latch))
                before = values[thread][phi.id]
                variables[phi.id] = self.chain.select(active[thread], again, before, phi.type)
            if thread + 1 < self.count:
                values[thread + 1].update(variables)
        return variables

    def _nodes(self, body: Body, nodes: list[str], threads: tuple[int, ...] = ()) -> None:
        for node in nodes:
            child = body.level.children.get(node)
            if child is None:
                body.block(body.level.blocks[node], threads or self.group.threads)
                continue
            enters = [body.takes_part(thread, node) for thread in self.group.threads]
            new = self.headers[node]
            loop = ThreadLoop(self.group, child, enters, new, self.fresh, self._rest)
            loop.write()
            if loop.form is Form.FREE:
                self.free.add(new)
            for thread in self.group.threads:
                body.paths[thread].left_by.update(loop.edges[thread])

    def _rest(self, body: Body, written: tuple[str, ...]) -> None:
        self._nodes(body, [node for node in body.level.flow.order if node not in written])

    def _close(self, number: Phi, phis: dict[int, Phi], variables: dict[int, Value]) -> None:
        """The back edge of the loop over groups."""
        ahead = Instr(0, Opcode.ADD, Type.I32, (Ref(number.id), Const(1)), exact=True)
        following: dict[int, Value] = {number.id: self.chain.copy(ahead)}
        for ident, step in self.handed.steps.items():
            by = Const(step * self.count & 0xFFFFFFFF)
            first = Ref(phis[ident].id)
            following[first.id] = self.chain.emit(Opcode.ADD, Type.I32, first, by)
        following |= {phis[ident].id: value for ident, value in variables.items()}
        end = self.chain.close(Branch(self.main, loc=self.level.header.branch.loc))
        for phi in (number, *phis.values()):
            self.chain.extend(phi, end, following[phi.id])

    def _wired(self, behind: str, phis: dict[int, Phi], enter: str) -> Threaded:
        """The function with the new blocks in the place of the loop's."""
        gone = self.level.loop.blocks
        before = block_of(self.function, self.preheader)
        header = self.level.loop.header
        before = replace(before, branch=retarget(before.branch, header, enter))
        target = block_of(self.function, behind)
        moved = tuple(rename_incoming(phi, header, self.main) for phi in target.phis)
        function = with_blocks(self.function, (before, replace(target, phis=moved)))
        kept = tuple(block for block in function.blocks if block.name not in gone)
        at = next(n for n, block in enumerate(kept) if block.name == self.preheader) + 1
        function = replace(function, blocks=kept)
        function = substitute(function, {old: Ref(new.id) for old, new in phis.items()})
        blocks = (*function.blocks[:at], *self.chain.blocks(), *function.blocks[at:])
        own = tuple(self._private_arrays())
        function = replace(function, blocks=blocks, locals=(*function.locals, *own))
        loops = tuple((new, old) for old, new in self.headers.items())
        return Threaded(function, self.main, loops, frozenset(self.free))

    def _own_loads(self) -> frozenset[int]:
        """Loads that are written thread by thread, and perhaps not for all of them."""
        level = self.level
        nodes = [n for n in self.handed.last if not level.flow.always_follows(n, level.loop.header)]
        instrs = (instr for node in nodes for instr in level.blocks[node].instrs)
        return frozenset(instr.id for instr in instrs if instr.op is Opcode.LOAD)

    def _private_names(self, thread: int) -> dict[str, str]:
        if not thread:
            return {}
        return {name: f"{name}.{thread}" for name in private_arrays(self.function, self.level)}

    def _private_arrays(self) -> Iterator[LocalArray]:
        for names in self.group.private:
            for local in self.function.locals:
                if local.name in names:
                    yield replace(local, name=names[local.name])


def private_arrays(function: Function, level: Level) -> tuple[str, ...]:
    """The kernel's own arrays that an iteration of the loop makes for itself: made and written in
    it, and not touched anywhere else.
    """
    start = level.header.branch.loc
    inside = [i for block in level.blocks.values() for i in block.instrs if i.op in MEMORY]
    written = {instr.array for instr in inside if instr.op is Opcode.STORE}
    outside = {
        instr.array
        for block in function.blocks
        if block.name not in level.loop.blocks
        for instr in block.instrs
    }
    own = (a.name for a in function.locals if start in a.loops and not a.name.startswith(TRAP))
    return tuple(name for name in own if name in written - outside)


def is_spread(function: Function) -> bool:
    """Whether the function is one whose parallel loop a launch cuts into chunks."""
    for block in function.blocks:
        phis = (value for phi in block.phis for _, value in phi.incoming)
        if any(value in (Input(FIRST), Input(LAST)) for value in (*uses(block), *phis)):
            return True
    return False


def _has_hidden_base(function: Function, level: Level) -> bool:
    """Whether an address in an array of the iteration's own is computed rather than indexed."""
    own = private_arrays(function, level)
    bases = {Input(f"&{name}") for name in own}
    for block in function.blocks:
        for instr in block.instrs:
            own_access = instr.op in MEMORY and instr.array in own
            if own_access and instr.operands[0] != Input(f"&{instr.array}"):
                return True
            if bases & set(instr.operands[1 if own_access else 0 :]):
                return True
        elsewhere = {v for phi in block.phis for _, v in phi.incoming} | set(block.branch.read)
        if bases & elsewhere:
            return True
    return False


def _natural(word: Const) -> int:
    return max(signed(word.word), 0)
