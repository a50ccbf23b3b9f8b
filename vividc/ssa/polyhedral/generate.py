"""From the loops of a schedule back to SSA, with values kept in registers.

What a loop reads and writes at one place in all its iterations is carried by a phi, loaded before
it and stored after; so is what an innermost loop reads at a place of the iteration before, loaded
before it (Callahan, Carr and Kennedy, "Improving register allocation for subscripted variables",
1990), and what it only reads at one place, though it may store there in some (floyd-warshall).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace

from vividc.host.once import changed
from vividc.machine.opcodes import MEMORY, Opcode, Type
from vividc.ssa.edit import (
    FreshIds,
    block_of,
    first_free,
    incoming,
    rename_incoming,
    retarget,
    substitute,
)
from vividc.ssa.ir import Block, Branch, Const, Function, Instr, Phi, Ref, Value
from vividc.ssa.polyhedral.guards import ALWAYS, Accessed, Guard, implies, moved, names_of
from vividc.ssa.polyhedral.loops import Code, For, If, Loops, Run
from vividc.ssa.polyhedral.places import Known, Places, Rotated, Stream
from vividc.ssa.polyhedral.relations import Rows
from vividc.ssa.polyhedral.rows import arrays_of_rows
from vividc.ssa.polyhedral.scop import Scop
from vividc.ssa.polyhedral.subscripts import Place
from vividc.ssa.polyhedral.writing.registers import Registers, Unkept
from vividc.ssa.polyhedral.writing.words import Words
from vividc.ssa.rewrite.refusal import Refusal


@dataclass(frozen=True)
class Made:
    """A generated loop: the header of the loop of the part that it comes from, and its code."""

    origin: str
    code: For


@dataclass(frozen=True)
class Generated:
    """A function with other loops in place of a part; `loops` are the new ones by header, and
    `branches` the names of branches by the block that runs where the test holds. `carries`: it
    would be another function without `carries`.
    """

    function: Function
    loops: Mapping[str, Made]
    branches: Mapping[str, str]
    carries: bool


def generate(
    scop: Scop,
    loops: Loops,
    *,
    masks: bool = False,
    rows: Mapping[str, Rows] | None = None,
    carries: bool = True,
    shares: bool = False,
) -> Generated | Refusal:
    """The function of a part with these loops in its place; `masks`: what a branch runs, and no
    loop, is masked instead; `rows`: what arrays have for iterations of a group; `carries`: what the
    iteration before had is not loaded again; `shares`: what several load under different guards is
    loaded once.

    Refused: a scalar whose next reader is in another loop, where no register keeps it; iterations
    of which it is not known which row is theirs, as of groups that are not full, unless masked.
    """
    try:
        places = Places(scop, loops, masks, rows or {}, carries, shares)
        return _Writer(scop, places).generated()
    except Unkept as reason:
        return Refusal(str(reason))


class _Writer:
    def __init__(self, scop: Scop, places: Places) -> None:
        self.scop = scop
        self.loops = loops = places.loops
        self.places = places
        ids = FreshIds(scop.function)
        self.words = Words(ids, scop.symbols, loops.quotients, scop.rows, scop.lengths)
        self.registers = Registers(scop, places, self.words)
        self.made: dict[str, Made] = {}
        self.branches: dict[str, str] = {}
        self._taken = {block.name for block in scop.function.blocks}
        self._blocks: list[Block] = []
        self._name = ""
        self._phis: tuple[Phi, ...] = ()
        self._certain: list[Accessed] = []

    @property
    def accessed(self) -> Accessed:
        """What the code that is being written accesses, loops and branches in it aside."""
        return self._certain[-1]

    def generated(self) -> Generated:
        """The whole function."""
        scop = self.scop
        if not self.places.are_rows_known():
            raise Unkept("which row of a temporary an iteration uses is not known")
        header = block_of(scop.function, scop.loop.header)
        self.words.loc = header.branch.loc
        first = self._open(self._fresh("part"))
        carried = [phi for phi in header.phis if scop.depth.get(phi.id) == 0]
        for phi in carried:
            self.registers.known[Place(phi.id, ())] = Known(incoming(phi, scop.entry))
        self._all(self.loops.code)
        self.registers.store_all()
        last = self._name
        self._close(Branch(scop.exit, loc=header.branch.loc))
        finals = {phi.id: self.registers.known[Place(phi.id, ())].value for phi in carried}
        function = substitute(self._spliced(first, last), finals)
        return Generated(function, self.made, self.branches, bool(self.places.carried))

    def _spliced(self, first: str, last: str) -> Function:
        scop = self.scop
        blocks: list[Block] = []
        for block in scop.function.blocks:
            if block.name == scop.loop.header:
                blocks += self._blocks
            if block.name in scop.loop.blocks:
                continue
            branch, phis = block.branch, block.phis
            if block.name == scop.entry:
                branch = retarget(branch, scop.loop.header, first)
            if block.name == scop.exit:
                phis = tuple(rename_incoming(phi, scop.loop.header, last) for phi in phis)
            blocks.append(replace(block, branch=branch, phis=phis))
        own = arrays_of_rows(scop.function, self.places.row_names)
        locals_ = (*scop.function.locals, *own)
        return replace(scop.function, blocks=tuple(blocks), locals=locals_)

    # Blocks

    def _fresh(self, stem: str) -> str:
        name = first_free(self._taken, stem)
        self._taken.add(name)
        return name

    def _open(self, name: str, phis: tuple[Phi, ...] = ()) -> str:
        self._name, self._phis = name, phis
        self.words.instrs = []
        return name

    def _close(self, branch: Branch) -> None:
        self._blocks.append(Block(self._name, self._phis, tuple(self.words.instrs), branch))

    # Code

    def _all(self, code: tuple[Code, ...]) -> None:
        self._certain.append(self.places.accessed(c for c in code if self.places.is_masked(c)))
        for item in code:
            if self.places.is_masked(item):
                for run, guard in self.places.runs(item) or ():
                    _Running(self, run, guard).write()
            elif isinstance(item, For):
                self._for(item)
            elif isinstance(item, If):
                self._if(item)
        self._certain.pop()

    def _for(self, loop: For) -> None:
        origin = self.places.origin(loop)
        if origin is None:
            raise Unkept("no statement counts a loop")
        self.words.loc = loc = block_of(self.scop.function, origin).branch.loc
        first = self.words.extreme(loop.first, Opcode.SMAX)
        limit = self.words.extreme(loop.limit, Opcode.SMIN)
        accessed = self.places.accessed_in(loop)
        carried, unsure = self._carried(loop, accessed, first, limit)
        streams = tuple(self.places.streams(loop, accessed))
        moving = (*self.places.rotated(loop, accessed), *(r for s in streams for r in s.rotated()))
        rotated = {one.place: one for one in moving}
        first_of = {p: self._entering(one, loop, first, limit) for p, one in rotated.items()}
        entered = {**carried, **first_of}
        before, header = self._name, self._fresh("part.loop")
        body, after = self._fresh(f"{header}.body"), self._fresh(f"{header}.after")
        self._close(Branch(header, loc=loc))
        self.made[header] = Made(origin, loop)
        counter, phis = self.words.ids(), {place: self.words.ids() for place in entered}
        self._open(header)
        stays = self.words.emit(Opcode.ICMP_SLT, Ref(counter), limit)
        test = tuple(self.words.instrs)
        position = len(self._blocks)
        outside, predicates = dict(self.registers.known), dict(self.registers.predicates)
        for place, ident in phis.items():
            self.registers.known[place] = replace(entered[place], value=Ref(ident))
        self._open(body)
        with self.registers.holding(carried):
            next_counter, lasts = self._body(loop, Ref(counter), carried, rotated, streams)
        latch = self._name
        self._close(Branch(header, loc=loc))
        made = [Phi(counter, Type.I32, ((before, first), (latch, next_counter)), loc)]
        for place, ident in phis.items():
            values = ((before, entered[place].value), (latch, lasts[place]))
            made.append(Phi(ident, self.registers.type_of(place), values, loc))
        head = Block(header, tuple(made), test, Branch(body, stays, after, loc=loc))
        self._blocks.insert(position, head)
        self._open(after)
        self.registers.predicates = predicates
        for place, known in carried.items():
            store = self.registers.known[place].store
            outside[place] = replace(known, value=Ref(phis[place]), store=store, stored=None)
        self._leave(outside, unsure)

    def _entering(self, one: Rotated, loop: For, first: Value, limit: Value) -> Known:
        """What a place of the iteration before is in the first one."""
        at = {loop.name: loop.first[0]} if len(loop.first) == 1 else {}
        place, guard = one.place.at(at), moved(one.guard, at)
        held = ALWAYS if one.streamed else one.guard
        if guard is None:
            return Known(Const(0), guard=held)  # nothing reads it
        known = self.registers.known.get(place)
        if known is not None and implies(guard, known.guard):
            return Known(known.value, guard=held)
        runs = self.words.emit(Opcode.ICMP_SLT, first, limit)
        self.words.names[loop.name] = first
        when = self.registers.predicate(guard)
        both = runs if when is None else self.words.emit(Opcode.AND, runs, when)
        value = self.registers.load(one.load, place, both)
        del self.words.names[loop.name]
        self.words.forget((loop.name,))
        for own in [one for one in self.registers.predicates if loop.name in names_of(one)]:
            del self.registers.predicates[own]
        return Known(value, guard=held)

    def _body(
        self,
        loop: For,
        counter: Ref,
        own: Collection[Place],
        rotated: Mapping[Place, Rotated],
        streams: tuple[Stream, ...],
    ) -> tuple[Value, dict[Place, Value]]:
        """One iteration; the counter of the next, and what places are in it at first."""
        entered = dict(self.registers.known)
        self.words.names[loop.name] = counter
        self.words.order.append(loop.name)
        for place, one in rotated.items():
            self.registers.known[place] = replace(
                self.registers.known[place], when=self.registers.predicate(one.guard)
            )
        for stream in streams:
            place, when = stream.places[0], self.registers.predicate(stream.guards[0])
            self.registers.known[place] = Known(
                self.registers.load(stream.load, place, when), when=when
            )
        self._all(loop.body)
        for place, known in list(self.registers.known.items()):
            if known.store is not None and place not in own and known != entered.get(place):
                self.registers.flush(place)
        lasts = {place: self.registers.known[place].value for place in own}
        for place, one in rotated.items():
            is_known = one.streamed and one.source in self.registers.known
            value = self.registers.known[one.source].value if is_known else None
            lasts[place] = value or self.registers.loaded(one.load, one.source, one.guard)
        self.words.order.pop()
        following = self.words.emit(Opcode.ADD, counter, loop.step, exact=True)
        del self.words.names[loop.name]
        self.words.forget((loop.name,))
        return following, lasts

    def _leave(self, outside: dict[Place, Known], unsure: list[Place]) -> None:
        """After a loop: what it has loaded only if it runs is stored, and then not known."""
        self.registers.known = outside
        for place in unsure:
            if self.registers.known[place].store is not None:
                self.registers.flush(place)
            del self.registers.known[place]

    def _carried(
        self, loop: For, accessed: Accessed, first: Value, limit: Value
    ) -> tuple[dict[Place, Known], list[Place]]:
        """What the loop carries in phis, and what is only known if it runs. Before it, stores are
        made that it may meet, what it may change is forgotten, and elements at fixed places are
        loaded.
        """
        fixed = self._fixed(loop, accessed)
        self._settle(accessed, fixed)
        unsure: list[Place] = []
        runs: Value | None = None
        known = self.registers.known
        for place, guard in fixed.items():
            entered = known.get(place)
            if entered is not None and (place.is_scalar or implies(guard, entered.guard)):
                if entered.store is not None and self._is_changed(place, accessed):
                    self.registers.flush(place)
                continue
            self.registers.drop(place)
            if place not in accessed.loads:
                continue
            when = self.registers.predicate(guard)
            if not any(sure.is_sure(place, guard) for sure in self._certain):
                unsure.append(place)
                runs = runs or self.words.emit(Opcode.ICMP_SLT, first, limit)
                when = runs if when is None else self.words.emit(Opcode.AND, runs, when)
            value = self.registers.load(accessed.loads[place], place, when)
            known[place] = Known(value, None, when, guard)
        carried = {p: known[p] for p in fixed if p in known and self.places.is_met(p, accessed)}
        for place, entered in carried.items():
            if place.is_scalar and accessed.guards[place] != {entered.guard}:
                carried[place] = replace(entered, guard=ALWAYS)
        return carried, unsure

    def _fixed(self, loop: For, accessed: Accessed) -> dict[Place, Guard]:
        """Places that registers can hold throughout a loop, with where they do."""
        fixed = self.places.fixed(loop, accessed).items()
        return {place: guard for place, guard in fixed if self._stays(place, loop.body)}

    def _stays(self, place: Place, code: Iterable[Code]) -> bool:
        """Whether a place that is known before some code is known after it: the loops in it that
        store to it hold it as well.
        """
        for item in code:
            if place.is_scalar or self.places.is_masked(item):
                continue
            if isinstance(item, If):
                if not self._stays(place, (*item.then, *item.otherwise)):
                    return False
            elif isinstance(item, For):
                accessed = self.places.accessed_in(item)
                if self.places.is_met(place, accessed) and place not in self._fixed(item, accessed):
                    return False
        return True

    def _is_changed(self, place: Place, accessed: Accessed) -> bool:
        """Whether only stores to what may be the same element write a place."""
        return not accessed.written[place] and self.places.is_met(place, accessed)

    def _settle(self, accessed: Accessed, fixed: Collection[Place]) -> None:
        for place in [p for p in self.registers.known if not p.is_scalar and p not in fixed]:
            mine = (other for other in accessed.written if other.owner == place.owner)
            meets = [other for other in mine if self.places.may_meet(place, other)]
            if meets and self.registers.known[place].store is not None:
                self.registers.flush(place)
            if any(accessed.written[other] for other in meets):
                self.registers.drop(place)

    def _if(self, item: If) -> None:
        self.registers.store_all()
        loc = self.words.loc
        condition = self.words.test(item.test)
        before, names = dict(self.registers.known), dict(self.words.names)
        predicates = self.registers.predicates
        then, otherwise, join = (self._fresh(f"part.{stem}") for stem in ("then", "else", "join"))
        self._close(Branch(then, condition, otherwise, loc=loc))
        self.branches[then] = item.name
        ends = []
        for name, code in ((then, item.then), (otherwise, item.otherwise)):
            self._open(name)
            self.registers.known, self.words.names = dict(before), dict(names)
            self.registers.predicates = dict(predicates)
            self._all(code)
            self.registers.store_all()
            ends.append((self._name, self.registers.known))
            self._close(Branch(join, loc=loc))
        self.words.names, self.registers.predicates = names, predicates
        self._open(join)
        self._phis = tuple(self._joined(*ends))

    def _joined(
        self, one: tuple[str, dict[Place, Known]], other: tuple[str, dict[Place, Known]]
    ) -> list[Phi]:
        """The phis of what both sides know; what only one knows is forgotten.

        Raises
        ------
        Unkept
            If a loop around carries that.
        """
        phis: list[Phi] = []
        (first, left), (second, right) = one, other
        self.registers.known = {}
        for place in left:
            known, same = left[place], right.get(place)
            if same is None or (known.when, known.guard) != (same.when, same.guard):
                continue
            values = ((first, known.value), (second, same.value))
            self.registers.known[place] = known
            if values[0][1] != values[1][1]:
                phis.append(
                    Phi(self.words.ids(), self.registers.type_of(place), values, self.words.loc)
                )
                self.registers.known[place] = replace(known, value=Ref(phis[-1].id))
        if not self.registers.held <= self.registers.known.keys():
            raise Unkept("a branch changes where an element is known that a loop carries")
        return phis


@dataclass
class _Running:
    """Writes one iteration of a statement."""

    writer: _Writer
    run: Run
    guard: Guard

    def __post_init__(self) -> None:
        self.statement = self.writer.places.statements[self.run.statement]
        self.at = self.writer.places.at(self.run)
        self.own: dict[int, Value] = {}

    def write(self) -> None:
        """All its instructions, then what it leaves behind."""
        words = self.writer.words
        for instr in self.statement.instrs:
            words.loc = instr.loc
            if instr.op in MEMORY:
                self._access(instr)
                continue
            operands = tuple(map(self._operand, instr.operands))
            words.instrs.append(changed(instr, id=words.ids(), operands=operands))
            self.own[instr.id] = Ref(words.instrs[-1].id)
        left = [(ident, self.own[ident]) for ident in self.statement.writes]
        left += [(ident, self._operand(value)) for ident, value in self.statement.copies]
        for ident, value in left:
            self.writer.registers.put(self._scalar(ident), value, self.guard)

    def _scalar(self, ident: int) -> Place:
        return self.writer.places.scalar(ident, self.run)

    def _operand(self, value: Value) -> Value:
        scop = self.writer.scop
        if not isinstance(value, Ref):
            return value
        if value.id in self.own:
            return self.own[value.id]
        if value.id in scop.indices:
            return self.writer.words.of(scop.indices[value.id].substituted(self.at))
        if value.id in scop.depth:
            if self._scalar(value.id) not in self.writer.registers.known:
                raise Unkept("a value would have to wait in memory")
            return self.writer.registers.known[self._scalar(value.id)].value
        if scop.function.block_of[value.id] in scop.loop.blocks:
            raise Unkept("a value is computed from addresses")
        return value

    def _access(self, instr: Instr) -> None:
        access = self.statement.accesses[instr.id]
        place = self.writer.places.element(access, self.run)
        if access.is_store:
            self.writer.registers.store(instr, place, self._operand(instr.operands[2]), self.guard)
            return
        beside = self.writer.accessed
        self.own[instr.id] = self.writer.registers.loaded(instr, place, self.guard, beside)
