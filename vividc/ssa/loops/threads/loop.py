"""An inner loop of several threads: one loop, which runs until all of them have left theirs.

Three forms. *In step*: the header's test alone ends the loop, and it is the same for all threads.
*Counted*: so, but threads may leave before; one that has is masked, and what it leaves behind
stays as it was. *Free*: every thread has tests of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from functools import reduce

import networkx as nx

from vividc.machine.opcodes import MEMORY, Opcode, Type
from vividc.ssa.analysis.acyclic import Edge
from vividc.ssa.analysis.levels import Level
from vividc.ssa.edit import incoming
from vividc.ssa.ir import Branch, Const, Instr, Phi, Ref, Undefined, Value
from vividc.ssa.loops.threads.body import Body, Group, can_test_address


class Form(Enum):
    """How the loop of a group ends."""

    IN_STEP = "in step"
    COUNTED = "counted"
    FREE = "free"


Nodes = Callable[[Body, tuple[str, ...]], None]
"""Writes a level but for the nodes that have been written."""

Name = Callable[[str], str]
"""A new block's name, from what it may start with."""

_Next = tuple[Phi, Callable[[], Value]]
"""A phi of the new header, and what gives its next word once the body is written."""


def form_of(group: Group, level: Level) -> Form:
    """The form that a loop gets.

    Counted loops must leave behind only what they carry from iteration to iteration.
    """
    header = level.header
    if level.loop.header in group.uniform.stepping:
        return Form.IN_STEP
    cond = header.branch.cond
    own = {phi.id for phi in header.phis}
    is_counted = (
        any(source == header.name for source, _ in level.loop.exits)
        and level.latch != header.name
        and (not isinstance(cond, Ref) or cond.id in group.uniform.values)
        and not any(instr.op in MEMORY for instr in header.instrs)
        and not needed_edges(level)
        and all(i in own and i not in group.uniform.values for i in level.leaving)
    )
    return Form.COUNTED if is_counted else Form.FREE


def needed_edges(level: Level) -> tuple[Edge, ...]:
    """The exits of a loop if it matters by which one a thread leaves; else none."""
    targets = {target for _, target in level.exits}
    if len(targets) > 1:
        return level.exits
    sources = [source for source, _ in level.exits]
    (target,) = targets
    for block in level.function.blocks:
        if block.name == target:
            for phi in block.phis:
                if len({incoming(phi, source) for source in sources}) > 1:
                    return level.exits
    return ()


class ThreadLoop:
    """Writes one inner loop for all threads.

    Parameters
    ----------
    enters
        For each thread when it comes to the loop; None: always.
    header
        Name of the new loop's header.
    name, nodes
        Name a block, and write what is in a loop.

    Attributes
    ----------
    edges
        After `write`, for each thread: whether it left by an exit, where that matters.
    """

    def __init__(
        self,
        group: Group,
        level: Level,
        enters: list[Value | None],
        header: str,
        name: Name,
        nodes: Nodes,
    ) -> None:
        self.group, self.level, self.enters = group, level, enters
        self.chain, self.name, self.nodes = group.chain, name, nodes
        self.form = form_of(group, level)
        self.loc = level.header.branch.loc
        self.header, self.after = header, name(f"{level.loop.header}.left")
        self.edges: list[dict[Edge, Value]] = [{} for _ in group.threads]
        self.left: list[dict[int, Value]] = [{} for _ in group.threads]
        self.last: list[dict[int, Value]] = [{} for _ in group.threads]
        self.following: list[_Next] = []
        self.deciding = frozenset[int]() if level.children else _deciding(level)
        """Values by which a thread leaves. What they need does not wait for whether it has left: it
        may run on, and a copy keeps the last word for after the loop.
        """

    def write(self) -> None:
        """The loop, after the open block, and an open one behind it, as which the threads' values
        then are.
        """
        initial = self._initially_done()
        skip = self._skip()
        with self.chain.scope():
            before = self.chain.close(Branch(self.header, loc=self.loc))
            self.chain.open(self.header)
            self._header_phis(before)
            done = [self.chain.phi(Type.PRED, (before, stop)) for stop in initial]
            body = self._body([Ref(phi.id) for phi in done])
            kept = self._kept(body, before)
            if self.form is Form.FREE:
                self.nodes(body, ())
            else:
                self._test(body)
                self.nodes(body, (self.level.loop.header,))
            end = self._end(body, done, kept)
        self.chain.open(self.after)
        if self.form is Form.COUNTED:
            self._merge(self.header, end)
        if skip is not None:
            self._join(*skip)
        for thread in self.group.threads:
            self.group.values[thread].update(self.left[thread])

    def _initially_done(self) -> list[Value]:
        """For each thread whether it does not come to the loop; none if all leave together."""
        if self.form is Form.IN_STEP:
            return []
        return [Const(0) if enter is None else self.chain.inverted(enter) for enter in self.enters]

    def _skip(self) -> tuple[str, str] | None:
        """Goes around the loop where no thread comes to it: by which block, and where to."""
        if any(enter is None for enter in self.enters):
            return None
        someone = reduce(self.chain.either, self.enters)
        stem = self.level.loop.header
        into, around = self.name(f"{stem}.into"), self.name(f"{stem}.around")
        behind = self.name(f"{stem}.behind")
        self.chain.close(Branch(into, someone, around, loc=self.loc))
        self.chain.open(around)
        self.chain.close(Branch(behind, loc=self.loc))
        self.chain.open(into)
        return around, behind

    def _header_phis(self, before: str) -> None:
        """The phis of the loop: one for all threads where they agree, else one for each."""
        starts = [
            {
                phi.id: self.group.value(thread, _start(self.level, phi))
                for phi in self.level.header.phis
            }
            for thread in self.group.threads
        ]
        for phi in self.level.header.phis:
            shared = phi.id in self.group.uniform.values
            for thread in self.group.threads:
                if thread and shared:
                    self.group.values[thread][phi.id] = self.group.values[0][phi.id]
                    continue
                start = (before, starts[thread][phi.id])
                new = self.chain.phi(phi.type, start, loc=phi.loc)
                self.group.values[thread][phi.id] = self.last[thread][phi.id] = Ref(new.id)
                if not self._is_frozen(phi.id):
                    self.following.append((new, self._next(thread, phi)))
                    continue
                frozen = new
                if phi.id in self.deciding:
                    self.following.append((new, self._next(thread, phi)))
                    frozen = self.chain.phi(phi.type, start, loc=phi.loc)
                    self.last[thread][phi.id] = Ref(frozen.id)
                self.following.append((frozen, self._freeze(thread, phi, frozen)))

    def _next(self, thread: int, phi: Phi) -> Callable[[], Value]:
        """What gives the next word of a phi, whether the thread is done or not."""
        return lambda: self.group.value(thread, incoming(phi, self.level.latch))

    def _freeze(self, thread: int, phi: Phi, frozen: Phi) -> Callable[[], Value]:
        """What gives the next word of a phi that is read after the loop: it stays as it is in a
        thread that is done.
        """
        following = self._next(thread, phi)

        def kept() -> Value:
            with self.chain.thread(thread, phi.id, phi.loc):
                stop = self.stops[thread]
                value = self.chain.keep_unless(stop, following(), Ref(frozen.id), phi.type)
            self.left[thread][phi.id] = value
            return value

        return kept

    def _is_frozen(self, ident: int) -> bool:
        is_own = ident not in self.group.uniform.values
        return is_own and self.form is not Form.IN_STEP and ident in self.level.leaving

    def _body(self, done: list[Value]) -> Body:
        if self.form is Form.IN_STEP:
            return Body(self.group, self.level, self.enters)
        everyone: list[Value | None] = [None for _ in self.enters]
        ahead = _loads_ahead(self.level, self.deciding)
        return Body(self.group, self.level, everyone, done, ahead, self.enters)

    def _kept(self, body: Body, before: str) -> list[_Next]:
        """Phis for what a thread leaves behind that is no phi of its own, of a free loop."""
        if self.form is not Form.FREE:
            return []
        header = {phi.id for phi in self.level.header.phis}
        phis: list[_Next] = []
        for thread in self.group.threads:
            for ident in self.level.leaving:
                if not (ident in header and self._is_frozen(ident)):
                    phi = self.chain.phi(self.level.types[ident], (before, Undefined()))
                    phis.append((phi, self._keep(body, thread, ident, phi)))
            for edge in needed_edges(self.level):
                phi = self.chain.phi(Type.PRED, (before, Undefined()))
                phis.append((phi, self._keep_edge(body, thread, edge, phi)))
        return phis

    def _keep(self, body: Body, thread: int, ident: int, phi: Phi) -> Callable[[], Value]:
        def following() -> Value:
            with self.chain.thread(thread, ident):
                value = self.group.value(thread, Ref(ident))
                kept = self._unless_done(body, thread, value, phi)
            self.left[thread][ident] = kept
            return kept

        return following

    def _keep_edge(self, body: Body, thread: int, edge: Edge, phi: Phi) -> Callable[[], Value]:
        def following() -> Value:
            taken = body.left(thread, edge)
            with self.chain.thread(thread, self.level.header.phis[0].id):
                self.edges[thread][edge] = self._unless_done(body, thread, taken, phi)
            return self.edges[thread][edge]

        return following

    def _unless_done(self, body: Body, thread: int, value: Value, phi: Phi) -> Value:
        """`value` of a thread's last iteration."""
        assert body.done is not None
        return self.chain.select(body.done[thread], Ref(phi.id), value, phi.type)

    def _test(self, body: Body) -> None:
        """The header, whose test is the same for all threads, as a block of its own."""
        header = self.level.header
        body.exits = tuple(edge for edge in body.exits if edge[0] != header.name)
        body.block(header, self.group.threads)
        inside = self.name(f"{header.name}.body")
        assert header.branch.cond is not None
        cond = self.group.value(0, header.branch.cond)
        stays = header.branch.target in self.level.loop.blocks
        then, other = (inside, self.after) if stays else (self.after, inside)
        self.chain.close(Branch(then, cond, other, loc=self.loc))
        self.chain.open(inside)

    def _end(self, body: Body, done: list[Phi], kept: list[_Next]) -> str:
        """The end of an iteration: the name of its block."""
        self.stops = [body.done_after(thread) for thread, _ in enumerate(done)]
        values = [(phi, following()) for phi, following in (*kept, *self.following)]
        values += zip(done, self.stops, strict=True)
        end = self.chain.block
        for phi, value in values:
            self.chain.extend(phi, end, value)
        if not done:
            return self.chain.close(Branch(self.header, loc=self.loc))
        every = self.stops[0]
        for other in self.stops[1:]:
            every = self.chain.emit(Opcode.AND, Type.PRED, every, other)
        return self.chain.close(Branch(self.after, every, self.header, loc=self.loc))

    def _merge(self, header: str, end: str) -> None:
        """What counted threads leave behind, if the count or the last of them ended the loop."""
        for thread in self.group.threads:
            for ident, last in self.left[thread].items():
                carried, kind = self.last[thread][ident], self.level.types[ident]
                phi = self.chain.phi(kind, (header, carried), (end, last))
                self.left[thread][ident] = Ref(phi.id)

    def _join(self, around: str, behind: str) -> None:
        """The block behind a loop that may have been gone around."""
        last = self.chain.close(Branch(behind, loc=self.loc))
        self.chain.open(behind)
        for thread in self.group.threads:
            for ident in self.level.leaving:
                value = self.left[thread].get(ident, self.group.values[thread][ident])
                phi = self.chain.phi(self.level.types[ident], (last, value), (around, Undefined()))
                self.left[thread][ident] = Ref(phi.id)
            for edge, taken in self.edges[thread].items():
                phi = self.chain.phi(Type.PRED, (last, taken), (around, Undefined()))
                self.edges[thread][edge] = Ref(phi.id)


def _start(level: Level, phi: Phi) -> Value:
    return next(value for name, value in phi.incoming if name != level.latch)


def _deciding(level: Level) -> frozenset[int]:
    """Ids of what the exits of a loop without inner ones depend on, in any iteration."""
    deciding = {level.node(source) for source, _ in level.exits}
    deciding |= {node for exit_ in set(deciding) for node in nx.ancestors(level.flow.graph, exit_)}
    items = _items(level)
    work = [cond for name in deciding if (cond := level.blocks[name].branch.cond) is not None]
    deciders: set[int] = set()
    while work:
        value = work.pop()
        if isinstance(value, Ref) and value.id in items and value.id not in deciders:
            deciders.add(value.id)
            item = items[value.id]
            work += [v for _, v in item.incoming] if isinstance(item, Phi) else item.operands
    return frozenset(deciders)


def _items(level: Level) -> dict[int, Phi | Instr]:
    return {i.id: i for block in level.blocks.values() for i in block.items}


def _loads_ahead(level: Level, deciding: frozenset[int]) -> frozenset[int]:
    """Loads that decide when a thread leaves, and that a comparison can keep in their arrays.

    If they waited for the exits of the iteration before, the loop would be no faster than the whole
    way from a load to the exit. A load that finds nothing gives 0, which nobody uses.
    """
    items = _items(level)
    loads = (items[ident] for ident in deciding)
    return frozenset(
        load.id
        for load in loads
        if isinstance(load, Instr) and load.op is Opcode.LOAD
        if can_test_address(level.function, load)
    )
