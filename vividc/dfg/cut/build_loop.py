"""The DFG of an innermost loop: if-converted body, recurrences, exit predicate, and what it leaves
behind.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from vividc.dfg.builder import GraphBuilder, Operand
from vividc.dfg.cut.address_forms import AddressForms
from vividc.dfg.cut.addresses import Address
from vividc.dfg.cut.build_straight import variable
from vividc.dfg.cut.if_convert import Body, Predicates, merge_phi
from vividc.dfg.cut.memory_order import Access, order_accesses
from vividc.dfg.ir import DFG, Control, Node
from vividc.machine.opcodes import MEMORY, OPCODES, Opcode, Type
from vividc.ssa.analysis.counted import Trip
from vividc.ssa.analysis.induction import initial, is_invariant
from vividc.ssa.analysis.polynomial import ITERATION, LoopPolynomials, symbol
from vividc.ssa.edit import incoming
from vividc.ssa.flow import Loop
from vividc.ssa.ir import (
    Block,
    Const,
    Function,
    Input,
    Instr,
    Named,
    Phi,
    Ref,
    Value,
)
from vividc.ssa.polyhedral.distances.linear import Place
from vividc.ssa.polyhedral.distances.meetings import Meetings


@dataclass(frozen=True)
class LoopParts:
    """A loop with what is known of its trip count and of its addresses."""

    function: Function
    loop: Loop
    trip: Trip | None
    addresses: dict[int, Address]

    @cached_property
    def header(self) -> Block:
        """The header block."""
        return next(b for b in self.function.blocks if b.name == self.loop.header)

    @property
    def exits(self) -> tuple[tuple[str, str], ...]:
        """Exits that a predicate decides: all, or all but the header's of a counted loop."""
        if self.trip is None:
            return self.loop.exits
        return tuple(edge for edge in self.loop.exits if edge[0] != self.loop.header)

    def final_phi(self, phi: Phi) -> Phi | None:
        """The header phi whose value *before* the exiting iteration is what every exit hands to
        `phi`.
        """
        values = {incoming(phi, source) for source, _ in self.loop.exits}
        if len(values) != 1:
            return None
        return self._header_phi(values.pop())

    def initial_exit_value(self, phi: Phi) -> Value | None:
        """What the preheader writes to the exit variable `phi`; None if the last iteration always
        writes it.
        """
        final = self.final_phi(phi)
        if final is not None:
            return initial(final, self.loop.blocks)
        if self.trip is None:
            return None
        value = incoming(phi, self.loop.header)
        carried = self._header_phi(value)
        if carried is not None:
            return initial(carried, self.loop.blocks)
        # A value of the body does not exist when the count ends the loop, and nobody asks for it.
        return value if is_invariant(self.function, self.loop.blocks, value) else Const(0)

    def counted_exit_value(self, phi: Phi) -> Value:
        """What `phi` holds if the loop ended by its count after this iteration."""
        value = incoming(phi, self.loop.header)
        carried = self._header_phi(value)
        return value if carried is None else incoming(carried, self.loop.latches[0])

    def _header_phi(self, value: Value) -> Phi | None:
        return next((phi for phi in self.header.phis if Ref(phi.id) == value), None)


def build_loop(name: str, parts: LoopParts, exit_phis: tuple[Phi, ...]) -> DFG:
    """Emits one iteration of the loop; `exit_phis` are the phis of its exit block, which become
    live-outs.
    """
    emitter = _LoopEmitter(name, parts)
    emitter.emit_body()
    exit_node = emitter.emit_exit()
    for phi in exit_phis:
        emitter.emit_live_out(phi)
    emitter.close(exit_node)
    return emitter.builder.build()


class _LoopEmitter:
    def __init__(self, name: str, parts: LoopParts) -> None:
        self.parts = parts
        loop = parts.loop
        self.builder = GraphBuilder(name)
        self.forms = AddressForms(parts.function, loop)
        self.body = Body(
            parts.function, loop.blocks, loop.header, loop.latches[0], parts.loop.exits
        )
        self.condition: dict[str, Operand] = {}
        self.predicates = Predicates(self.body, self.builder, self.condition)
        self.values: dict[Value, Operand] = {}
        self.accesses: list[Access] = []
        self.effects: list[tuple[Operand, bool]] = []
        self.taken: dict[str, Operand] = {}
        for phi in parts.header.phis:
            self.values[Ref(phi.id)] = self._phi(phi)

    def value(self, item: Value) -> Operand:
        """The operand of an SSA value; one from outside the loop is a live-in."""
        if item not in self.values:
            settled = self.parts.function.settled(item)
            if isinstance(settled, Const):
                return self.builder.const(settled.word)
            assert isinstance(settled, Named)
            name = settled.key if isinstance(settled, Input) else variable(settled.id)
            self.values[item] = self.builder.live_in(name)
        return self.values[item]

    def emit_body(self) -> None:
        """All blocks in topological order."""
        for name in self.body.flow.order:
            block = self.body.by_name[name]
            if name != self.body.entry:
                for phi in block.phis:
                    known = {value: self.value(value) for _, value in phi.incoming}
                    self.values[Ref(phi.id)] = merge_phi(self.predicates, name, phi, known)
            for instr in block.instrs:
                self.values[Ref(instr.id)] = self._emit(name, instr)
            if block.branch.cond is not None:
                self.condition[name] = self.value(block.branch.cond)
        meetings = Meetings(self.parts.function, self.parts.loop)
        order_accesses(self.builder, self.accesses, meetings, self.body.are_exclusive)

    def emit_exit(self) -> Operand | None:
        """The node that ends the loop, marked for the controller; None for a loop that is only
        counted.
        """
        total: Operand | None = None
        for number, (source, target) in enumerate(self._exits()):
            self.taken[source] = self.predicates.leaving(source, target)
            taken = self.taken[source]
            total = taken if number == 0 else self.predicates.either(total, taken)
        if total is None:
            return None
        loc = self.body.by_name[self._exits()[0][0]].branch.loc
        return self.builder.mark(total, Control.EXIT, loc)

    def emit_live_out(self, phi: Phi) -> None:
        """Writes the exit variable `phi` in every live iteration, so that the last one's word
        stays.
        """
        final = self.parts.final_phi(phi)
        if final is not None:
            carried = incoming(final, self.parts.loop.latches[0])
            self._live_out(phi, self.value(carried), unless_exit=bool(self.taken))
            return
        exits = list(self._exits())
        if self.parts.trip is not None:
            result = self.value(self.parts.counted_exit_value(phi))
        else:
            result = self.value(incoming(phi, exits.pop()[0]))
        for source, _ in reversed(exits):
            other = self.value(incoming(phi, source))
            if other != result:
                operands = [self.taken[source], other, result]
                result = self.builder.add(Opcode.SELECT, operands, phi.loc)
        self._live_out(phi, result, unless_exit=False)

    def close(self, exit_node: Operand | None) -> None:
        """Names the source of each loop-carried value and holds effects back until the exit is
        known.
        """
        for phi in self.parts.header.phis:
            operand = self.values[Ref(phi.id)]
            if operand.is_phi:
                first = self.value(initial(phi, self.parts.loop.blocks))
                carried = self.value(incoming(phi, self.parts.loop.latches[0]))
                self.builder.close_phi(operand, first, carried)
        if exit_node is not None:
            for effect, unless_exit in self.effects:
                self.builder.control(exit_node, effect, 0 if unless_exit else 1)

    def _exits(self) -> list[tuple[str, str]]:
        """Deciding exits, in the order in which an iteration meets them."""
        position = {name: index for index, name in enumerate(self.body.flow.order)}
        return sorted(self.parts.exits, key=lambda edge: position[edge[0]])

    def _phi(self, phi: Phi) -> Operand:
        form = LoopPolynomials(self.parts.function, self.parts.loop).of(Ref(phi.id))
        return self.builder.iv() if form == symbol(ITERATION) else self.builder.open_phi()

    def _live_out(self, phi: Phi, operand: Operand, *, unless_exit: bool) -> None:
        node = self.builder.add_node(
            Node(0, Opcode.LIVE_OUT, name=variable(phi.id), unless_exit=unless_exit, loc=phi.loc),
            [self.builder.operation(operand)],
        )
        self.effects.append((node, unless_exit))

    def _emit(self, block: str, instr: Instr) -> Operand:
        if instr.op not in MEMORY:
            operands = [self.value(item) for item in instr.operands]
            return self.builder.add(instr.opcode, operands, instr.loc, instr.lane)
        is_store = instr.op is Opcode.STORE
        address = self._address(instr)
        pred, unless_exit = self._guard(block) if is_store else self._load_guard(block)
        end = OPCODES[instr.op].arity + 1
        if len(instr.operands) > end:
            pred = self.predicates.both(pred, self.value(instr.operands[end]))
        base, index, shift = self.builder.fixed_base(
            self.value(address.base), self._index(address), address.shift, instr.loc
        )
        node = self.builder.add_node(
            Node(
                0,
                instr.op,
                name=instr.array,
                shift=shift,
                offset=address.offset,
                width=instr.width,
                signed=instr.signed,
                unless_exit=unless_exit,
                loc=instr.loc,
                lane=instr.lane,
                address=self.forms.of(instr),
            ),
            [index, *(self.value(item) for item in instr.operands[2:end])],
            pred,
            base,
        )
        self.accesses.append(Access(node, Place(instr, block)))
        if is_store:
            self.effects.append((node, unless_exit))
        if instr.type is Type.PRED and unless_exit:
            # Where the iteration does not come so far, it is a byte of any array.
            return self.builder.add(Opcode.AND, [node, self.builder.const(1)], instr.loc)
        return node

    def _address(self, instr: Instr) -> Address:
        known = self.parts.addresses.get(instr.id)
        if known is not None:
            return known
        return Address(instr.operands[0], instr.shift, instr.offset, instr.operands[1])

    def _index(self, address: Address) -> Operand:
        return self.builder.iv() if address.index == ITERATION else self.value(address.index)

    def _load_guard(self, block: str) -> tuple[Operand | None, bool]:
        """Predicate of a load in `block`, and whether an exiting iteration may not come so far."""
        sources = (source for source, _ in self.parts.exits)
        after_exit = any(s != block and self.body.flow.reaches(s, block) for s in sources)
        return self.predicates.of(block), after_exit

    def _guard(self, block: str) -> tuple[Operand | None, bool]:
        """Predicate of an effect in `block`, and whether the exiting iteration leaves it out."""
        pred = self.predicates.of(block)
        sources = [source for source, _ in self.parts.exits]
        before = [s for s in sources if s != block and self.body.flow.reaches(s, block)]
        later = [s for s in sources if self.body.flow.reaches(block, s)]
        if not later:
            return pred, bool(before)
        for source in before:
            leaving = self.predicates.leaving(source, self.parts.loop.exits[0][1])
            pred = self.predicates.both(pred, self.predicates.inverted(leaving))
        return pred, False
