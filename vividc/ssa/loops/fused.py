"""Loops of as many iterations, one right after the other, as one.

Numpy's expressions are a nest each: `alpha * A @ x + beta * B @ x` goes through the rows three
times. Where no iteration of the second loop needs, or overwrites, what a later one of the first
accesses, each iteration of both may run one after the other (Wolfe, "High Performance Compilers for
Parallel Computing", 1996, chapter 9.2): one nest is left, whose sums run side by side, and what the
first leaves for the second in an array is a value of the same iteration.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from vividc.machine.opcodes import MEMORY, Opcode, Type
from vividc.machine.params import TRAP
from vividc.machine.words import WORD_MASK
from vividc.ssa.analysis.counters import Counter, counter_of
from vividc.ssa.analysis.order import Lacking, Order, Sum
from vividc.ssa.analysis.polynomial import Polynomial, Polynomials, constant
from vividc.ssa.edit import defined_types, read_values, rename_incoming, retarget, substitute
from vividc.ssa.flow import Loop, find_loops, predecessors, preheader_of
from vividc.ssa.ir import Block, Const, Function, Instr, Ref, Value, is_dimension
from vividc.ssa.loops.forwarded import is_unconditional
from vividc.ssa.loops.join import between
from vividc.ssa.polyhedral.subscripts import FlatRows, element_bytes, subscripts_of


def fused(function: Function) -> Function:
    """The function with such loops fused, from the outside in, if all loops in them are, or one of
    them has none.
    """
    before = None
    while function is not before:
        before, function = function, _once(function)
    return function


def _once(function: Function) -> Function:
    loops = find_loops(function)
    for first in sorted(loops, key=lambda loop: -len(loop.blocks)):
        second = _next(function, first, loops)
        made = None if second is None else _fused_whole(function, first, second)
        if made is not None:
            return made
    return function


def _fused_whole(function: Function, first: Loop, second: Loop) -> Function | None:
    """The function with two loops fused, and with loops in both, the last of the first with the
    first of the second.
    """
    pair = _Pair.of(function, first, second)
    if pair is None:
        return None
    made, loops = pair.fused(), find_loops(function)
    inner = [one for one in loops if one.header in first.blocks - {first.header}]
    others = {one.header for one in loops if one.header in second.blocks - {second.header}}
    if not inner and not others:
        return made
    if not inner or not others:
        alone = second if inner else first
        is_one = _share(function, first, second) and not _branches(function, alone)
        return made if is_one else None
    loops = find_loops(made)
    for one in loops:
        other = _next(made, one, loops) if one.header in {loop.header for loop in inner} else None
        if other is not None and other.header in others:
            return _fused_whole(made, one, other)
    return None


def _share(function: Function, first: Loop, second: Loop) -> bool:
    """Whether two loops access one array."""
    arrays = [{one.array for one in _accesses(function, loop)} for loop in (first, second)]
    return not arrays[0].isdisjoint(arrays[1])


def _branches(function: Function, loop: Loop) -> bool:
    """Whether a loop without others in it branches: in a nest, that would be no static part."""
    inside = loop.blocks - {loop.header}
    return any(len(function.by_name[name].branch.successors) > 1 for name in inside)


def _next(function: Function, first: Loop, loops: Iterable[Loop]) -> Loop | None:
    """The loop right behind another one, nothing but straight code between them."""
    by_header = {loop.header: loop for loop in loops}
    if len(first.exits) != 1:
        return None
    [(_, name)] = first.exits
    for _ in function.blocks:
        if name in by_header:
            return None if first.header in by_header[name].blocks else by_header[name]
        if len(function.by_name[name].branch.successors) != 1:
            return None
        name = function.by_name[name].branch.successors[0]
    return None


@dataclass(frozen=True)
class _Pair:
    """Two loops that may be fused.

    Attributes
    ----------
    middle
        The blocks between them.
    ahead
        How much more the counter of the second is than that of the first.
    above, below
        What is computed between them, and may be before and behind both.
    """

    function: Function
    first: Loop
    second: Loop
    middle: tuple[str, ...]
    counters: tuple[Counter, Counter]
    ahead: int
    above: tuple[Instr, ...]
    below: tuple[Instr, ...]

    @staticmethod
    def of(function: Function, first: Loop, second: Loop) -> _Pair | None:
        """The loops, if they may be fused."""
        middle = between(function, first, second)
        if not middle or any(function.by_name[name].phis for name in middle):
            return None
        if not all(_is_simple(function, loop) for loop in (first, second)):
            return None
        one, other = (counter_of(function, loop) for loop in (first, second))
        if one is None or other is None or one.step != 1 or other.step != 1:
            return None
        order = Order(function)
        starts = _between(order, one.initial, other.initial)
        if starts.terms or _lacking(order, first, (one, other)) != ():
            return None
        above, below = _sorted_out(function, first, middle)
        counters, ahead = (one, other), starts.constant
        made = _Pair(function, first, second, middle, counters, ahead, above, below)
        return made if made._are_apart() and _Meetings(made, order).are_in_order() else None

    def _are_apart(self) -> bool:
        """Whether the second loop, and what goes before both, reads no value of the first, and what
        is between them may go.
        """
        [(_, after)] = self.second.exits
        own = _made_in(self.function, self.first.blocks)
        below = {one.id for one in self.below}
        seconds = [self.function.by_name[name] for name in (*self.second.blocks, after)]
        read = [value for block in seconds[:-1] for value in read_values(block)]
        read += [value for one in self.above for value in one.operands]
        behind = [value for phi in seconds[-1].phis for _, value in phi.incoming]
        if _reads(read, own | below) or _reads(behind, below):
            return False
        if self.below and predecessors(self.function)[after] != (self.second.header,):
            return False
        accesses = [[*_accesses(self.function, loop)] for loop in (self.first, self.second)]
        moved = [[one for one in part if one.op in MEMORY] for part in (self.above, self.below)]
        return not any(
            _may_meet(one, other)
            for part, others in (
                (moved[0], (*accesses[0], *moved[1])),
                (moved[1], accesses[1]),
            )
            for one in part
            for other in others
        )

    def fused(self) -> Function:
        """The function with one loop in place of the two."""
        by_name, second = self.function.by_name, self.second.header
        before, [end] = preheader_of(self.function, self.first), self.second.latches
        [last], [(_, after)] = self.first.latches, self.second.exits
        head = self.first.header
        body = _inside(by_name[second], self.second)
        blocks: list[Block] = []
        for block in self.function.blocks:
            made = block
            if block.name in (*self.middle, second):
                continue
            if block.name == before:
                made = replace(made, instrs=(*made.instrs, *self.above))
            if block.name == after:
                made = replace(made, instrs=(*self.below, *made.instrs))
            if block.name == head:
                made = self._header(before, last, end, after)
            if block.name == last:
                made = replace(made, branch=retarget(made.branch, head, body))
            if block.name == end:
                made = replace(made, branch=retarget(made.branch, second, head))
            for name, source in ((body, last), (after, head)):
                if block.name == name:
                    phis = tuple(rename_incoming(phi, second, source) for phi in made.phis)
                    made = replace(made, phis=phis)
            blocks.append(made)
        one, other = (counter.phi.id for counter in self.counters)
        values: dict[int, Value] = {} if self.ahead else {other: Ref(one)}
        return substitute(replace(self.function, blocks=tuple(blocks)), values)

    def _header(self, before: str, last: str, end: str, after: str) -> Block:
        """The header of both: of the first, which goes on where the second one ends."""
        by_name = self.function.by_name
        head, other = by_name[self.first.header], by_name[self.second.header]
        mine, counter = (counter.phi.id for counter in self.counters)
        phis = [rename_incoming(phi, last, end) for phi in head.phis]
        kept = (phi for phi in other.phis if phi.id != counter)
        phis += [rename_incoming(phi, self.middle[-1], before) for phi in kept]
        instrs = [*head.instrs]
        if self.ahead:
            operands = (Ref(mine), Const(self.ahead & WORD_MASK))
            instrs.append(Instr(counter, Opcode.ADD, Type.I32, operands, exact=True))
        branch = retarget(head.branch, self.first.exits[0][1], after)
        return Block(head.name, tuple(phis), (*instrs, *other.instrs), branch)


def _between(order: Order, one: Value, other: Value) -> Sum:
    """How much the second value is more than the first."""
    return order.sum_of(other).less(order.sum_of(one))


def _lacking(order: Order, first: Loop, counters: tuple[Counter, Counter]) -> Lacking | None:
    """What would have to hold for two loops to have as many iterations."""
    one, other = counters
    facts = order.facts(preheader_of(order.function, first))
    starts = _between(order, one.initial, other.initial)
    return order.equal(starts, _between(order, one.limit, other.limit), facts)


def lacking_lengths(order: Order) -> Iterator[Lacking]:
    """What would have to hold of scalars for loops, one right after the other, that access one
    array to have as many iterations.
    """
    function = order.function
    loops = find_loops(function)
    for first in loops:
        second = _next(function, first, loops)
        if second is None or not _share(function, first, second):
            continue
        one, other = (counter_of(function, loop) for loop in (first, second))
        if one is not None and other is not None and one.step == other.step == 1:
            lacking = _lacking(order, first, (one, other)) or ()
            if not any(map(_is_about_shapes, lacking)):
                yield lacking


def _is_about_shapes(wanted: Sum) -> bool:
    """Whether a sum compares dimensions: a matrix may have more rows than columns, of which a
    scalar that counts either says nothing.
    """
    return len(wanted.terms) > 1 and all(is_dimension(value) for value, _ in wanted.terms)


def _sorted_out(
    function: Function, first: Loop, middle: tuple[str, ...]
) -> tuple[tuple[Instr, ...], tuple[Instr, ...]]:
    """What is computed behind a loop: what does without its values, and stores nothing, and the
    rest.
    """
    own = _made_in(function, first.blocks)
    above, below = list[Instr](), list[Instr]()
    for one in (one for name in middle for one in function.by_name[name].instrs):
        if one.op is Opcode.STORE or _reads(one.operands, own):
            below.append(one)
            own |= {one.id}
        else:
            above.append(one)
    return tuple(above), tuple(below)


def _made_in(function: Function, blocks: Iterable[str]) -> set[int]:
    """Ids of the values that blocks define."""
    return {ident for name in blocks for ident in defined_types(function.by_name[name])}


def _reads(values: Iterable[Value], ids: set[int]) -> bool:
    return any(isinstance(value, Ref) and value.id in ids for value in values)


def _accesses(function: Function, loop: Loop) -> Iterator[Instr]:
    for block in function.blocks:
        if block.name in loop.blocks:
            yield from (one for one in block.instrs if one.op in MEMORY)


def _may_meet(one: Instr, other: Instr) -> bool:
    """Whether two accesses may have an order, by their arrays."""
    return one.array == other.array and Opcode.STORE in (one.op, other.op)


def _inside(header: Block, loop: Loop) -> str:
    """Where the header of a loop goes on in it."""
    return next(name for name in header.branch.successors if name in loop.blocks)


def _is_simple(function: Function, loop: Loop) -> bool:
    """Whether a loop ends in its header alone, which accesses no memory."""
    header = function.by_name[loop.header]
    has_latch = len(loop.latches) == 1 and loop.latches[0] != loop.header
    is_left = [source for source, _ in loop.exits] == [loop.header]
    return has_latch and is_left and not any(one.op in MEMORY for one in header.instrs)


class _Meetings:
    """Where accesses of two loops meet."""

    def __init__(self, pair: _Pair, order: Order) -> None:
        self._pair, self._order = pair, order
        function = pair.function
        self._rows = FlatRows(function, order)
        self._polynomials = Polynomials(function, pitches=True)
        self._subscripts = subscripts_of(function)
        self._params = {param.name for param in function.params}

    def are_in_order(self) -> bool:
        """Whether no iteration of the second loop accesses what a later one of the first does, with
        a store among the two.
        """
        pair = self._pair
        firsts, seconds = ([*_accesses(pair.function, x)] for x in (pair.first, pair.second))
        between = (one for one in (*pair.above, *pair.below) if one.op in MEMORY)
        every = [*firsts, *seconds, *between]
        if any(one.array.startswith(TRAP) or not is_unconditional(one) for one in every):
            return False
        return all(
            self._is_in_order(one, other)
            for one in firsts
            for other in seconds
            if _may_meet(one, other)
        )

    def _is_in_order(self, one: Instr, other: Instr) -> bool:
        if one.width != other.width:
            return False
        places, block = [*self._places(other)], self._pair.function.block_of[other.id]
        return any(
            self._is_not_before(mine, theirs, one.width)
            or self._is_behind(mine, theirs, one.width, block)
            for kind, mine in self._places(one)
            for other_kind, theirs in places
            if kind == other_kind
        )

    def _places(self, access: Instr) -> Iterator[tuple[object, Polynomial]]:
        """Numbers, in bytes from one element to the next, that are equal of equal elements, each
        with what it is.
        """
        scale = constant(1 << access.shift)
        index = self._polynomials.of(access.operands[1])
        subscripts = self._subscripts.of(access)
        for axis, subscript in enumerate(subscripts or ()):
            is_last = axis == len(subscripts or ()) - 1
            behind = constant(access.offset if is_last else 0)
            yield (len(subscripts or ()), axis), subscript.times(scale).plus(behind)
        yield "index", index.times(scale).plus(constant(access.offset))
        unit = element_bytes(access)
        if access.offset % unit:
            return
        moved = index.plus(constant(access.offset >> access.shift))
        block = self._pair.function.block_of[access.id]
        deep = self._rows.deep(access, moved)
        if all(self._is_in_row(part, length, block) for part, length in deep[1:]):
            for axis, (part, _) in enumerate(deep):
                yield (len(deep), axis), part.times(constant(unit))
        for row, column, length in self._rows.candidates(access, moved):
            if self._is_in_row(column, length, block):
                kind = 2 if access.array in self._params else self._order.sum_of(length)
                yield (kind, 0), row.times(constant(unit))
                yield (kind, 1), column.times(constant(unit))

    def _is_in_row(self, column: Polynomial, length: Value, block: str) -> bool:
        """Whether a subscript proves to be from 0 to below a dimension."""
        if any(len(monomial) > 1 for monomial in column.terms):
            return False
        return self._order.lacks_below(self._order.of_terms(column), length, block) == ()

    def _is_not_before(self, mine: Polynomial, theirs: Polynomial, width: int) -> bool:
        """Whether two numbers are equal in no iteration of the second loop that is before the one
        of the first.
        """
        one, other = self._pair.counters
        first = mine.linear_in(Ref(one.phi.id))
        second = theirs.linear_in(Ref(other.phi.id))
        if first is None or second is None:
            return False
        (slope, rest), (other_slope, other_rest) = first, second
        step, other_step = slope.constant, other_slope.constant
        if step == other_step == 0:  # rows beside the one that the second loop goes along
            away = rest.plus(other_rest, -1).constant
            return away is not None and away != 0 and away % width == 0
        if not step or other_step not in (step, 0) or step % width:
            return False
        by = constant(-step * self._pair.ahead)
        if not other_step:  # they meet in one iteration of the first loop: in the first or before
            by = self._polynomials.of(one.initial).times(constant(step))
            rest, other_rest = other_rest.times(constant(-1)), rest.times(constant(-1))
        away = rest.plus(other_rest, -1).plus(by).constant
        if away is None or away % width:
            return False
        return away % step != 0 or away // step >= 0

    def _is_behind(self, mine: Polynomial, theirs: Polynomial, width: int, block: str) -> bool:
        """Whether the second number, of an access in `block`, proves to be one that the first is in
        an iteration that is not behind: of rows above the one that the second loop has come to.
        """
        one, other = self._pair.counters
        first = mine.linear_in(Ref(one.phi.id))
        step = 0 if first is None else first[0].constant
        if first is None or not step:
            return False
        come_to = Polynomial({(Ref(other.phi.id),): step, (): -step * self._pair.ahead})
        more = come_to.plus(first[1]).plus(theirs, -1).times(constant(1 if step > 0 else -1))
        if any(len(monomial) > 1 or factor % width for monomial, factor in more.terms.items()):
            return False
        return self._order.is_proved(self._order.of_terms(more), self._order.facts(block))
