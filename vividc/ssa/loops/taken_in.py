"""First iterations that the source writes before a loop are the loop's again.

`a[0, 0] = sqrt(a[0, 0])`, and then a loop over rows from 1 on that does for each what this did for
the first: as one loop from 0 on it has no code twice, and groups of its iterations begin where
those of the loops inside do.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, replace
from itertools import dropwhile
from typing import Final

from vividc.machine.opcodes import MEMORY, Opcode
from vividc.machine.words import WORD_MASK, signed
from vividc.ssa.analysis.constants import constant_value
from vividc.ssa.analysis.induction import constant_step, initial, is_invariant
from vividc.ssa.analysis.order import Order, Sum
from vividc.ssa.edit import read_values, with_blocks
from vividc.ssa.flow import Loop, find_loops, predecessors
from vividc.ssa.ir import Block, Const, Function, Instr, Phi, Ref, Value, definition_of
from vividc.ssa.rewrite.tidy import tidy

_MOST_BLOCKS: Final = 64
"""That an iteration is followed through."""

_NEUTRAL: Final = {
    Opcode.ADD: Const(0),
    Opcode.SUB: Const(0),
    Opcode.MUL: Const(1),
}
"""What leaves a number on the left as it is."""

_LOADED: Final = "loaded"


def taken_in(function: Function) -> Function:
    """The function with loops that begin with what is written before them, tidied if there are
    some.
    """
    before = function
    for header in [loop.header for loop in find_loops(function)]:
        while (made := _with_one_more(function, header)) is not None:
            function = made
    return function if function is before else tidy(function)


def _with_one_more(function: Function, header: str) -> Function | None:
    """With a loop from one iteration earlier on; None if that is not what is before it."""
    loop = next(one for one in find_loops(function) if one.header == header)
    counted = _counted(function, loop)
    if counted is None:
        return None
    phi, before, first = counted
    entry = Const((first - 1) & WORD_MASK)
    done = _Followed(function, {})
    done.block(before)
    known = {ident: done.from_behind(form) for ident, form in done.known.items()}
    iteration = _Followed(function, {**known, phi.id: entry})
    if not _follows(iteration, loop):
        return None
    again, last = iteration.forms(), done.accessed[-len(iteration.accessed) :]
    stores = [one.id for one in last if one.op is Opcode.STORE]
    if not stores or again != done.forms()[-len(again) :] or _is_read_later(function, before, last):
        return None
    kept = tuple(one for one in before.instrs if one.id not in stores)
    incoming = tuple((at, entry if at == before.name else one) for at, one in phi.incoming)
    head = function.by_name[header]
    changed = (replace(head, phis=(replace(phi, incoming=incoming),)), replace(before, instrs=kept))
    return with_blocks(function, changed)


def _is_read_later(function: Function, before: Block, last: Sequence[Instr]) -> bool:
    """Whether another block reads what follows from loads behind the first of these stores: without
    the stores they load something else.
    """
    behind = {one.id for one in dropwhile(lambda one: one.op is not Opcode.STORE, last)}
    changed: set[Value] = set()
    for one in before.instrs:
        if one.id in behind or not changed.isdisjoint(one.operands):
            changed.add(Ref(one.id))
    others = (block for block in function.blocks if block is not before)
    return any(value in changed for block in others for value in read_values(block))


def _counted(function: Function, loop: Loop) -> tuple[Phi, Block, int] | None:
    """The counter of a loop that carries nothing else, the block before it, and the constant that
    it starts with, where one iteration more proves to run.
    """
    head, names = function.by_name[loop.header], predecessors(function)[loop.header]
    outside = [name for name in names if name not in loop.blocks]
    test = definition_of(function, head.branch.cond)
    if len(head.phis) != 1 or len(outside) != 1 or not isinstance(test, Instr):
        return None
    [phi], before = head.phis, function.by_name[outside[0]]
    if not any(one.op is Opcode.STORE for one in before.instrs):
        return None
    start = initial(phi, loop.blocks)
    is_counter = constant_step(function, loop, phi) == 1 and isinstance(start, Const)
    is_test = test.op is Opcode.ICMP_SLT and test.operands[0] == Ref(phi.id)
    is_test = is_test and head.branch.target in loop.blocks
    if not (is_counter and is_test) or before.branch.successors != (loop.header,):
        return None
    limit = test.operands[1]
    if [at for at, _ in loop.exits] != [loop.header] or not is_invariant(
        function, loop.blocks, limit
    ):
        return None
    assert isinstance(start, Const)
    first, order = signed(start.word), Order(function)
    more = order.sum_of(limit).less(Sum((), first))
    return (phi, before, first) if order.is_proved(more, order.facts(before.name)) else None


def _follows(iteration: _Followed, loop: Loop) -> bool:
    """Follows an iteration from the test that holds on to the end; False: it is not known which way
    it goes.
    """
    function, name, came = iteration.function, loop.header, ""
    for _ in range(_MOST_BLOCKS):
        block = function.by_name[name]
        iteration.block(block, came)
        after = block.branch.target
        if name != loop.header and block.branch.cond is not None:
            truth = iteration.form(block.branch.cond)
            if not isinstance(truth, Const):
                return False
            after = block.branch.target if truth.word else block.branch.otherwise
        if after is None or after == loop.header:
            return after is not None
        name, came = after, name
    return False


@dataclass
class _Followed:
    """What blocks do, one after the other.

    Attributes
    ----------
    known
        Forms of values, by id: constants, or operations on forms.
    accessed
        The accesses to memory so far, each with the forms of its operands.
    """

    function: Function
    known: dict[int, Hashable]
    accessed: list[Instr] = field(default_factory=list)
    _operands: list[tuple[Hashable, ...]] = field(default_factory=list)

    def form(self, value: Value) -> Hashable:
        """A value's form: itself if it is from elsewhere."""
        value = self.function.settled(value)
        return self.known.get(value.id, value) if isinstance(value, Ref) else value

    def block(self, block: Block, came: str = "") -> None:
        """Runs a block that was entered from another one; phis of the first one are known."""
        if came:
            values = {phi.id: self.form(dict(phi.incoming)[came]) for phi in block.phis}
            self.known |= values
        for one in block.instrs:
            operands = tuple(map(self.form, one.operands))
            if one.op in MEMORY:
                self.accessed.append(one)
                self._operands.append(operands)
                self.known[one.id] = _LOADED, len(self.accessed)
            else:
                self.known[one.id] = _form(one, operands)

    def forms(self) -> list[Hashable]:
        """What the accesses are, whatever else there is; loads by how many are behind them."""
        return [
            (_plain(one), tuple(map(self.from_behind, parts)))
            for one, parts in zip(self.accessed, self._operands, strict=True)
        ]

    def from_behind(self, form: Hashable) -> Hashable:
        """A form in which what was loaded has a number of its own: less than 1, as of the last
        access 0.
        """
        if not isinstance(form, tuple):
            return form
        if form[:1] == (_LOADED,):
            return _LOADED, form[1] if form[1] <= 0 else form[1] - len(self.accessed)
        return tuple(map(self.from_behind, form))


def _plain(one: Instr) -> Instr:
    """An instruction without what tells it from others that do the same."""
    return replace(one, id=0, operands=(), loc=None, subscript=(), exact=False)


def _form(one: Instr, operands: tuple[Hashable, ...]) -> Hashable:
    if all(isinstance(part, Const) for part in operands):
        words = tuple(part for part in operands if isinstance(part, Const))
        word = constant_value(replace(one, operands=words), {})
        if word is not None:
            return Const(word)
    if one.op is Opcode.MUL and Const(0) in operands:
        return Const(0)
    if operands and operands[-1] == _NEUTRAL.get(one.opcode):
        return operands[0]
    if one.op in (Opcode.ADD, Opcode.MUL) and operands[0] == _NEUTRAL[one.opcode]:
        return operands[1]
    return _plain(one), operands
