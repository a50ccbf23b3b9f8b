"""Two versions of a kernel, and a test before them: one for sizes of its arguments that agree, of
which nothing is left that asks for them, and the kernel as it is for all others.

Numpy's slices are clamped to the sizes of their arrays, its operations stretch what has one element
to the others' size, and raise what does not fit: of arguments that fit, all that is the same number
each time. What the first version takes for granted is what proofs of that lack (`order`), a few
comparisons of inputs (Bik, "Automatic intra-register vectorization", 2002, tests so before a loop).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

from vividc.machine.opcodes import MEMORY, Opcode, Type
from vividc.machine.words import WORD_MASK
from vividc.ssa.analysis.frequency import chance_of_agreement, raises
from vividc.ssa.analysis.order import Order, Sum
from vividc.ssa.analysis.polynomial import Polynomials
from vividc.ssa.edit import FreshIds, first_free, map_values
from vividc.ssa.flow import find_loops, flow_of
from vividc.ssa.ir import (
    Block,
    Branch,
    Const,
    Function,
    Input,
    Instr,
    Ref,
    Value,
    definition_of,
    is_dimension,
)
from vividc.ssa.loops.forwarded import forwarded, own_arrays
from vividc.ssa.loops.fused import fused, lacking_lengths
from vividc.ssa.loops.overwritten import without_overwritten
from vividc.ssa.loops.sizes.by_counters import by_counters
from vividc.ssa.loops.sizes.decide import decided
from vividc.ssa.loops.temporaries import without_temporaries
from vividc.ssa.polyhedral.subscripts import FlatRows
from vividc.ssa.rewrite.clone import clone_blocks
from vividc.ssa.rewrite.tidy import tidy

_ORDERED: Final = frozenset({Opcode.ICMP_SLT, Opcode.ICMP_SLE, Opcode.ICMP_ULT, Opcode.ICMP_ULE})
_MOST_TESTS: Final = 12
_LIKELY: Final = 0.9
_ROUNDS: Final = 4
"""Times that is asked for sizes: what is decided by the first shows what is asked by the next."""


@dataclass(frozen=True)
class Sized:
    """The block `entered` runs where sizes do not agree; `others`: headers of the loops that run
    then, and the loops that they are copies of.
    """

    function: Function
    entered: str
    others: dict[str, str]


def for_sizes(function: Function) -> Sized | None:
    """A kernel with a version for sizes that agree; None: nothing asks for them, or they cannot be
    tested before it.
    """
    names = [block.name for block in function.blocks]
    entry = function.blocks[0].name
    start, other = first_free(names, "sizes"), first_free(names, f"{entry}.other")
    agreeing, given = function, tuple[Sum, ...]()
    for _ in range(_ROUNDS):
        wanted = _without_implied((*given, *_wanted(agreeing, given)))
        if wanted == given:
            break
        if len([*_comparisons(wanted)]) > _MOST_TESTS:
            return None
        agreeing, given = _agreeing(agreeing, wanted, start, other), wanted
    if not any(len(one.terms) > 1 for one in given):
        return None
    instrs, cond = _tests(FreshIds(agreeing), given)
    leave = Branch(entry, cond, other, loc=function.blocks[0].branch.loc)
    blocks = (Block(start, (), instrs, leave), *agreeing.blocks, Block(other, (), (), Branch()))
    return _joined(_in_registers(replace(agreeing, blocks=blocks)), function, other)


def without_arrays_between(function: Function) -> Function | None:
    """A kernel that asks for no sizes, but makes arrays, as in the version for sizes that agree:
    with elements by row and column, and fewer arrays; None: it is as it was.
    """
    made = _in_registers(function) if _makes_arrays(function) else function
    return None if made == function else made


def _makes_arrays(function: Function) -> bool:
    """Whether a kernel accesses arrays that nobody gives it."""
    own = {*own_arrays(function), *(param.name for param in function.params if param.made)}
    return any(one.array in own for block in function.blocks for one in block.instrs)


def _in_registers(function: Function) -> Function:
    """The function decided, its loops fused, without arrays between them and loops in vain."""
    made = tidy(by_counters(tidy(decided(function))))
    return without_overwritten(_together(without_temporaries(_together(made))))


def _together(function: Function) -> Function:
    """The function with loops fused, and what one leaves for the next one in registers."""
    made = fused(function)
    return function if made is function else tidy(forwarded(tidy(made)))


def _agreeing(function: Function, given: tuple[Sum, ...], start: str, other: str) -> Function:
    """The function without what is decided where these sums are not negative."""
    entry = function.blocks[0].name
    instrs, cond = _tests(FreshIds(function), given)
    named = _with_one_name(function, given)
    blocks = (Block(start, (), instrs, Branch(entry, cond, other)), *named.blocks)
    made = decided(replace(function, blocks=(*blocks, Block(other, (), (), Branch()))))
    kept = tuple(block for block in made.blocks if block.name not in (start, other))
    return replace(made, blocks=kept)


def _without_implied(wanted: tuple[Sum, ...]) -> tuple[Sum, ...]:
    """The sums without those that others imply, which differ from them by a constant."""
    least: dict[tuple[tuple[Value, int], ...], Sum] = {}
    for one in wanted:
        if one.constant <= least.setdefault(one.terms, one).constant:
            least[one.terms] = one
    return tuple(least.values())


def _joined(agreeing: Function, function: Function, other: str) -> Sized:
    """The first version with the kernel as it is in place of the block `other`."""
    both = replace(function, blocks=(*agreeing.blocks, *function.blocks))
    clone = clone_blocks(function, function.by_name.keys(), stem="other", ids=FreshIds(both))
    entry = function.blocks[0].name
    taken = {block.name for block in agreeing.blocks} - {other}
    assert taken.isdisjoint(clone.names.values())
    assert clone.names[entry] == other
    kept = tuple(block for block in agreeing.blocks if block.name != other)
    sequential = function.sequential | {clone.names[name] for name in function.sequential}
    made = replace(agreeing, blocks=(*kept, *clone.blocks), sequential=sequential)
    others = {clone.names[loop.header]: loop.header for loop in find_loops(function)}
    return Sized(made, other, others)


def _with_one_name(function: Function, wanted: tuple[Sum, ...]) -> Function:
    """The function with one of two inputs that are equal for the other, a dimension; pitches
    stay.
    """
    names: dict[Value, Value] = {}
    for one in wanted:
        if Sum(()).less(one) in wanted:
            values = sorted((value for value, _ in one.terms), key=repr)
            values.sort(key=lambda value: not is_dimension(value))
            if is_dimension(values[0]) and not one.constant:
                names[values[1]] = values[0]

    def named(value: Value) -> Value:
        while value in names:
            value = names[value]
        return value

    blocks = tuple(map_values(block, named) for block in function.blocks)
    return replace(function, blocks=blocks)


def _wanted(function: Function, given: tuple[Sum, ...]) -> tuple[Sum, ...]:
    """More sums of inputs that are not negative where sizes agree and those given are not."""
    order = Order(function, list(given), may_lack=True)
    rows = FlatRows(function, order)
    blocks = [function.by_name[name] for name in flow_of(function).order]
    inside = {name for loop in find_loops(function) for name in loop.blocks}
    asks = any(map(raises, blocks))  # before its loops alone a user does
    for block in blocks:
        for lacking in _asked(order, block):
            order.given += [one for one in lacking if one not in order.given]
            asks = asks or (block.name in inside and _is_likely(lacking))
    if _makes_arrays(function):
        for lacking in lacking_lengths(order):
            order.given += [one for one in lacking if one not in order.given]
            asks = asks or bool(lacking)
    if not (asks or given):
        return ()
    for block in blocks if order.given else ():
        for lacking in _in_rows(order, rows, block):
            order.given += [one for one in lacking if one not in order.given]
    return tuple(order.given[len(given) :])


def _is_likely(lacking: tuple[Sum, ...]) -> bool:
    """Whether sizes that lack nothing but these sums mostly agree: one array may well have fewer
    elements than another one, as taps than samples, which `min(len(taps), i + 1)` asks for.
    """
    return any(len(_arrays(one)) <= 1 or Sum(()).less(one) in lacking for one in lacking)


def _arrays(one: Sum) -> set[str]:
    """The arrays of which a sum has dimensions."""
    inputs = [value for value, _ in one.terms if isinstance(value, Input)]
    return {value.key.rsplit(".", 1)[0] for value in inputs if is_dimension(value)}


def _in_rows(order: Order, rows: FlatRows, block: Block) -> Iterator[tuple[Sum, ...]]:
    """What is lacking for elements by flat indices to be known by row and column."""
    polynomials = Polynomials(order.function, pitches=True)
    for access in block.instrs:
        if access.op not in MEMORY:
            continue
        index = polynomials.of(access.operands[1])
        for column, length in rows.deep(access, index)[1:]:
            if all(len(monomial) == 1 for monomial in column.terms if monomial):
                lacking = order.lacks_below(order.of_terms(column), length, block.name)
                yield lacking or ()
        for _, column, length in rows.candidates(access, index):
            if any(len(monomial) > 1 for monomial in column.terms):
                continue
            lacking = order.lacks_below(order.of_terms(column), length, block.name)
            if lacking is not None:
                yield lacking
                break


def _asked(order: Order, block: Block) -> Iterator[tuple[Sum, ...]]:
    function = order.function
    made = {item.id: item for one in function.blocks for item in one.instrs}
    for instr in block.instrs:
        pair = _clamped(function, instr)
        if pair is not None:
            left, right = pair
            ways = [order.at_most(left, right, block.name), order.at_most(right, left, block.name)]
            known = [way for way in ways if way is not None]
            if known:
                yield min(known, key=_rank)
        elif instr.op is Opcode.SELECT:
            lacking = order.lacks(instr.operands[0], False, block.name) if _turns(instr) else None
            if lacking is not None:
                yield lacking
            yield from _agreement(order, instr.operands[0], block.name, made)
    branch = block.branch
    if branch.cond is None:
        return
    for target, truth in ((branch.target, False), (branch.otherwise, True)):
        if target is not None and raises(function.by_name[target]):
            lacking = order.lacks(branch.cond, truth, block.name)
            if lacking is not None:
                yield lacking
            return
    yield from _agreement(order, branch.cond, block.name, made)


def _clamped(function: Function, instr: Instr) -> tuple[Value, ...] | None:
    """The two values of which an instruction gives the smaller or the larger one."""
    if instr.op in (Opcode.SMIN, Opcode.SMAX):
        return instr.operands
    if instr.op is not Opcode.SELECT:
        return None
    test, *sides = definition_of(function, instr.operands[0]), *instr.operands[1:]
    if not isinstance(test, Instr) or test.op not in _ORDERED:
        return None
    return tuple(sides) if set(test.operands) == set(sides) else None


def _turns(choice: Instr) -> bool:
    """Whether a selection gives what is added to an index from the end: a dimension, or 0."""
    _, from_end, otherwise = choice.operands
    return is_dimension(from_end) and otherwise == Const(0)


def _agreement(
    order: Order, condition: Value, block: str, made: dict[int, Instr]
) -> Iterator[tuple[Sum, ...]]:
    """What a test lacks that asks whether sizes agree."""
    chance = chance_of_agreement(condition, made)
    if chance is None or 1.0 - _LIKELY < chance < _LIKELY:
        return
    lacking = order.lacks(condition, chance > _LIKELY, block)
    if lacking is not None:
        yield lacking


def _rank(lacking: tuple[Sum, ...]) -> tuple[int, int]:
    """The fewer sums the better; then those in which a dimension is the larger one."""
    larger = [value for one in lacking for value, times in one.terms if times > 0]
    return len(lacking), sum(not is_dimension(value) for value in larger)


def _tests(ids: FreshIds, wanted: tuple[Sum, ...]) -> tuple[tuple[Instr, ...], Value]:
    """Instructions that compute whether all of the sums are not negative: one input each, or two
    without a constant (`order`).
    """
    instrs: list[Instr] = []

    def made(op: Opcode, *operands: Value) -> Value:
        instrs.append(Instr(ids(), op, Type.PRED, operands))
        return Ref(instrs[-1].id)

    held = [made(op, *sides) for op, *sides in _comparisons(wanted)]
    while len(held) > 1:
        pairs = zip(held[::2], held[1::2], strict=False)
        held = [*(made(Opcode.AND, *pair) for pair in pairs), *held[len(held) // 2 * 2 :]]
    return tuple(instrs), held[0]


def _comparisons(wanted: tuple[Sum, ...]) -> Iterator[tuple[Opcode, Value, Value]]:
    """What is tested: one comparison where a sum, and what is taken from 0 by it, are both not
    negative.
    """
    for place, one in enumerate(wanted):
        other = Sum(()).less(one)
        if other in wanted[:place]:
            continue
        more = next((value for value, times in one.terms if times > 0), None)
        less = next((value for value, times in one.terms if times < 0), None)
        sides = (
            Const(-one.constant & WORD_MASK) if less is None else less,
            Const(one.constant & WORD_MASK) if more is None else more,
        )
        yield (Opcode.ICMP_EQ if other in wanted else Opcode.ICMP_SLE, *sides)
