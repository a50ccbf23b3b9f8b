"""Two versions of an innermost loop, and a test before it: where it holds, no load waits for a
store of an earlier iteration that may have met it for all that was known before.

The tests are one comparison each: an inequality of the values that both accesses' subscripts are
made of, which no two iterations that meet satisfy. The branch itself tells the first version's
accesses apart (`distances.Meetings` reads the conditions under which a block runs). The second
version is the loop as it was (Nicolau, "Run-time disambiguation", 1989).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from vividc.machine.opcodes import MEMORY, Opcode, Type
from vividc.ssa.edit import (
    block_of,
    fresh_name,
    next_id,
    rename_incoming,
    retarget,
    with_blocks,
)
from vividc.ssa.flow import Loop, find_loops, preheader_of
from vividc.ssa.ir import Block, Branch, Const, Function, Instr, Phi, Ref, Value, is_dimension
from vividc.ssa.polyhedral.distances.linear import Place
from vividc.ssa.polyhedral.distances.meetings import Meetings, NotMore
from vividc.ssa.rewrite.clone import clone_blocks, extend_phis, repair_uses
from vividc.ssa.rewrite.refusal import Refusal

_MOST_TESTS = 2


@dataclass(frozen=True)
class Versions:
    """The loop at `apart` runs where the test holds, by way of the block `entered`; the one at
    `meeting` where it does not.
    """

    function: Function
    apart: str
    meeting: str
    entered: str


def versions(function: Function, loop: Loop) -> Versions | Refusal:
    """Two versions of an innermost loop with a preheader.

    Refused: no load may meet an earlier store, or no comparison rules that out.
    """
    loops = find_loops(function)
    if any(other.header in loop.blocks and other.header != loop.header for other in loops):
        return Refusal("it contains another loop")
    tests = _tests(function, loop)
    if not tests:
        return Refusal("no test before it proves its accesses apart")
    return _versions(function, loop, tests)


def _tests(function: Function, loop: Loop) -> tuple[NotMore, ...]:
    """Comparisons that rule out what is assumed, of as many pairs of accesses as they can."""
    meetings = Meetings(function, loop)
    found: dict[NotMore, None] = {}
    for store, load in _pairs(function, loop):
        tests = [test for test in meetings.tests_apart(store, load) if not _is_of_sizes(test)]
        tests.sort(key=_rank)
        if tests and not any(test in found for test in tests):
            found[tests[0]] = None
    return tuple(found) if len(found) <= _MOST_TESTS else ()


def _rank(test: NotMore) -> int:
    """Which tests come first: a scalar that is not less than a number is the most likely."""
    return 0 if isinstance(test.less, Const) else 2 if isinstance(test.more, Const) else 1


def _is_of_sizes(test: NotMore) -> bool:
    """Whether it asks how large arrays are, which are seldom so small that nothing meets."""
    sides = (test.less, test.more)
    return all(isinstance(side, Const) or is_dimension(side) for side in sides)


def _pairs(function: Function, loop: Loop) -> list[tuple[Place, Place]]:
    """Stores and the loads of their arrays."""
    places = [
        Place(instr, name)
        for name in loop.blocks
        for instr in block_of(function, name).instrs
        if instr.op in MEMORY
    ]
    places.sort(key=lambda place: place.instr.id)
    stores = [place for place in places if place.instr.op is Opcode.STORE]
    loads = [place for place in places if place.instr.op is Opcode.LOAD]
    return [(s, load) for s in stores for load in loads if s.instr.array == load.instr.array]


def _versions(function: Function, loop: Loop, tests: tuple[NotMore, ...]) -> Versions:
    before = preheader_of(function, loop)
    clone = clone_blocks(function, loop.blocks, stem="meeting")
    function = extend_phis(function, clone)
    entered = fresh_name(function, f"{loop.header}.apart")
    function = with_blocks(function, (Block(entered, (), (), Branch(loop.header)),))
    other = fresh_name(function, f"{loop.header}.other")
    meeting = clone.names[loop.header]
    source = block_of(function, before)
    instrs, cond = _condition(function, tests)
    loc = block_of(function, loop.header).branch.loc
    assert source.branch.cond is None
    changed = (
        replace(
            source,
            instrs=(*source.instrs, *instrs),
            branch=Branch(entered, cond, other, loc=loc),
        ),
        Block(other, (), (), retarget(source.branch, loop.header, meeting)),
        _entered_from(block_of(function, loop.header), before, entered),
        _entered_from(block_of(function, meeting), before, other),
    )
    function = repair_uses(with_blocks(function, changed), loop.blocks, [clone])
    return Versions(function, loop.header, meeting, entered)


def _entered_from(block: Block, old: str, new: str) -> Block:
    phis: tuple[Phi, ...] = tuple(rename_incoming(phi, old, new) for phi in block.phis)
    return replace(block, phis=phis)


def _condition(function: Function, tests: tuple[NotMore, ...]) -> tuple[list[Instr], Value]:
    """Instructions that compute whether all of the tests hold."""
    free = next_id(function)
    instrs: list[Instr] = []
    cond: Value = Const(1)
    for test in tests:
        instrs.append(Instr(free, Opcode.ICMP_SLE, Type.PRED, (test.less, test.more)))
        held: Value = Ref(free)
        if len(instrs) > 1:
            instrs.append(Instr(free + 1, Opcode.AND, Type.PRED, (cond, held)))
            held = Ref(free + 1)
        cond, free = held, free + 2
    return instrs, cond
