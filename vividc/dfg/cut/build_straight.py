"""The DFG of a straight region: one basic block, its branch, and the variables it writes."""

from __future__ import annotations

from vividc.dfg.builder import GraphBuilder, Operand
from vividc.dfg.cut.address_forms import AddressForms
from vividc.dfg.cut.memory_order import Access, order_accesses
from vividc.dfg.ir import DFG, AddressForm, Control, Node
from vividc.dfg.regions import RETURN_HIGH, RETURN_VARIABLE
from vividc.machine.opcodes import MEMORY, OPCODES, Opcode
from vividc.ssa.ir import Block, Const, Input, Ref, Value
from vividc.ssa.polyhedral.distances.linear import Place
from vividc.ssa.polyhedral.distances.meetings import Meetings


def variable(ident: int) -> str:
    """The variable that carries an SSA value between regions."""
    return f"%{ident}"


def build_straight(
    name: str,
    block: Block,
    writes: list[tuple[int, Value]],
    trip: Value | None,
    meetings: Meetings,
) -> DFG:
    """Emits `block` in program order; `writes` are (variable's id, value), `trip` the next loop's
    trip count.
    """
    builder = GraphBuilder(name)
    forms = AddressForms(meetings.function)
    own: dict[int, Operand] = {}

    def value(item: Value) -> Operand:
        item = meetings.function.settled(item)
        if isinstance(item, Const):
            return builder.const(item.word)
        if isinstance(item, Input):
            return builder.live_in(item.key)
        assert isinstance(item, Ref)
        return own[item.id] if item.id in own else builder.live_in(variable(item.id))

    accesses: list[Access] = []
    for instr in block.instrs:
        operands = [value(item) for item in instr.operands]
        address = forms.of(instr) if instr.op in MEMORY else None
        own[instr.id] = _emit(builder, Place(instr, block.name), operands, address, accesses)
    order_accesses(builder, accesses, meetings)
    branch = block.branch
    if branch.cond is not None:
        builder.mark(value(branch.cond), Control.BRANCH, branch.loc)
    if trip is not None:
        builder.mark(value(trip), Control.TRIP, branch.loc)
    for ident, item in writes:
        _write(builder, variable(ident), value(item))
    if branch.target is None and branch.value is not None:
        _write(builder, RETURN_VARIABLE, value(branch.value))
        if branch.high is not None:
            _write(builder, RETURN_HIGH, value(branch.high))
    return builder.build()


def _write(builder: GraphBuilder, name: str, operand: Operand) -> None:
    source = builder.operation(operand)
    node = builder.node(source)
    loc = None if node is None else node.loc
    builder.add_node(Node(0, Opcode.LIVE_OUT, name=name, loc=loc), [source])


def _emit(
    builder: GraphBuilder,
    place: Place,
    operands: list[Operand],
    address: AddressForm | None,
    accesses: list[Access],
) -> Operand:
    instr = place.instr
    if instr.op not in MEMORY:
        return builder.add(instr.opcode, operands, instr.loc, instr.lane)
    base, index, *rest = operands
    values = OPCODES[instr.op].arity - 1
    pred = rest.pop() if len(rest) > values else None
    if isinstance(instr.operands[0], Ref):
        # A variable is delivered to where operations read it, but not to load/store units.
        base = builder.operation(base, instr.loc)
    base, index, shift = builder.fixed_base(base, index, instr.shift, instr.loc)
    node = builder.add_node(
        Node(
            0,
            instr.op,
            name=instr.array,
            shift=shift,
            offset=instr.offset,
            width=instr.width,
            signed=instr.signed,
            loc=instr.loc,
            lane=instr.lane,
            address=address,
        ),
        [index, *rest],
        pred,
        base,
    )
    accesses.append(Access(node, place))
    return node
