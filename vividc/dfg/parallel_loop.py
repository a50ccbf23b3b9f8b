"""Cuts a kernel's data-parallel loop: the function then runs the iterations from the input `FIRST`
to the input `LAST`, and a launch can give each tile its own.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import replace

import networkx as nx

from vividc.dfg.cfg import Block, Const, Function, Input, Instr, Phi, Ref, Value
from vividc.dfg.cfg_edit import definitions, uses, with_blocks
from vividc.dfg.footprint_terms import TermTable
from vividc.dfg.loops import Loop, block_graph, dominators, find_loops
from vividc.dfg.opcodes import Opcode
from vividc.dfg.parallel import (
    ANY,
    COUNTER,
    FIRST,
    INDEX,
    LAST,
    START,
    STEPS,
    UNION,
    WIDE_HIGH,
    WIDE_LOW,
    Access,
    Parallel,
    Reduction,
    Term,
)
from vividc.dfg.reductions import FoundReduction, reduction_of
from vividc.dfg.wide_sums import is_wide_sum
from vividc.errors import KernelError, SourceLoc

_INEXACT = frozenset({ANY, INDEX, COUNTER, STEPS, UNION})
"""Terms with more than one value."""
_HINT = "write `for i in prange(n)`, or with a start, around everything that the kernel does"


def cut_parallel_loop(function: Function, lines: Collection[int]) -> tuple[Function, Parallel]:
    """Find the loop that `prange` marks, and cut it.

    Parameters
    ----------
    lines
        Lines of the function's file in which a loop over `prange` begins; of nested ones the
        outermost is cut.

    Raises
    ------
    KernelError
        The loop does not run upwards by one between bounds known before the kernel starts, there
        are several, or an iteration needs what an earlier one computed, other than by a sum,
        product, minimum or maximum that the kernel returns, or something behind the loop does.

    Notes
    -----
    Each tile runs the whole function, with a part of the iterations. That gives what one tile would
    compute because of what is proved here and, of the arguments' bytes, at launch
    (`sim.accelerator.chunks`): all values that leave the loop are combined, no array of the
    kernel's own carries anything out of it, its bounds are the same each time it is entered, and
    only what the loop writes for certain, where it runs for certain, counts as overwritten.
    """
    loop, header = _marked_loop(function, lines)
    loc = header.branch.loc
    index, first, last = _bounds(function, loop, header)
    found = _reductions(function, loop, header, index)
    result = _result(function, loop, found, loc)
    _refuse_kept_arrays(function, loop, loc)
    starts: dict[int, Value] = {index.id: Input(FIRST)}
    starts |= {item.phi: Input(f"{START}{n}") for n, item in enumerate(found)}
    cut = _with_inputs(function, loop, header, starts)
    table = TermTable(cut, index.id)
    accesses = tuple(_accesses(cut, loop, table))
    bounds = (table.of(first), table.of(last))
    reductions = tuple(_described(item, table) for item in found)
    terms = tuple(table.terms)
    for term in bounds:
        _demand_exact(terms, term, loc)
    for item in reductions:
        if item.start_word is None:
            _demand_exact(terms, item.start, loc)
    tests = (instr for instr in header.instrs if Ref(instr.id) == header.branch.cond)
    is_unsigned = any(test.op is Opcode.ICMP_ULT for test in tests)
    return cut, Parallel(terms, *bounds, accesses, reductions, result, is_unsigned, loc)


def _marked_loop(function: Function, lines: Collection[int]) -> tuple[Loop, Block]:
    blocks = {block.name: block for block in function.blocks}
    marked: list[Loop] = []
    found = [loop for loop in find_loops(function) if _line(function, blocks[loop.header]) in lines]
    for loop in reversed(found):
        line = _line(function, blocks[loop.header])
        # A loop around one over prange may have its test in the same line.
        around = any(
            inner.blocks < loop.blocks and _line(function, blocks[inner.header]) == line
            for inner in found
        )
        if not around and not any(loop.header in outer.blocks for outer in marked):
            marked.append(loop)
    if not marked:
        raise KernelError(
            "the loop over prange is gone: it runs once at most",
            loc=SourceLoc(function.file, min(lines)),
            hint="compile the kernel for one tile",
        )
    if len(marked) > 1:
        raise KernelError(
            "a second loop over prange",
            loc=blocks[marked[0].header].branch.loc,
            hint="make a kernel of each, and run one after the other",
        )
    return marked[0], blocks[marked[0].header]


def _line(function: Function, header: Block) -> int | None:
    loc = header.branch.loc
    return loc.line if loc is not None and loc.file == function.file else None


def _bounds(function: Function, loop: Loop, header: Block) -> tuple[Phi, Value, Value]:
    """The loop's variable, its first value, and the limit."""
    loc = header.branch.loc
    inside = _inside(function, loop)
    instrs = {i.id: i for b in function.blocks for i in b.instrs}
    cond = header.branch.cond
    test = instrs.get(cond.id) if isinstance(cond, Ref) else None
    if len(loop.exits) != 1 or loop.exits[0][0] != header.name:
        raise KernelError("a loop over prange cannot be left early", loc=loc, hint=_HINT)
    tests = (Opcode.ICMP_SLT, Opcode.ICMP_ULT)
    if test is None or test.op not in tests or header.branch.target not in loop.blocks:
        raise KernelError(
            "the loop over prange does not count up to a limit of one word",
            loc=loc,
            hint="give it bounds of 32 bits, as in prange(np.int32(n))",
        )
    counter, limit = test.operands
    for phi in header.phis:
        starts = {value for source, value in phi.incoming if source not in loop.blocks}
        again = {value for source, value in phi.incoming if source in loop.blocks}
        if Ref(phi.id) != counter or len(starts) != 1 or len(again) != 1:
            continue
        (start,), (next_,) = starts, again
        step = instrs.get(next_.id) if isinstance(next_, Ref) else None
        if step is None or step.op is not Opcode.ADD:
            continue
        is_fixed = not (isinstance(limit, Ref) and limit.id in inside)
        if set(step.operands) == {Ref(phi.id), Const(1)} and is_fixed:
            return phi, start, limit
    raise KernelError("the loop over prange does not count up by one", loc=loc, hint=_HINT)


def _inside(function: Function, loop: Loop) -> frozenset[int]:
    blocks = (block for block in function.blocks if block.name in loop.blocks)
    return frozenset(item.id for block in blocks for item in definitions(block))


def _reductions(
    function: Function, loop: Loop, header: Block, index: Phi
) -> tuple[FoundReduction, ...]:
    found: list[FoundReduction] = []
    for phi in header.phis:
        if phi.id == index.id or any(item.phi == phi.id for item in found):
            continue
        item = reduction_of(function, loop, phi)
        pair = () if item is not None else _wide_sum(function, loop, header, phi)
        if item is None and not pair:
            raise KernelError(
                "an iteration of the loop over prange needs what an earlier one computed",
                loc=phi.loc or header.branch.loc,
                hint="only a sum, product, minimum or maximum in one variable, which nothing else "
                "in the loop reads, can be combined, and but for a sum it has 32 bits: np.int32 "
                "makes such integers",
            )
        found += pair if item is None else (item,)
    return tuple(found)


def _wide_sum(
    function: Function, loop: Loop, header: Block, phi: Phi
) -> tuple[FoundReduction, ...]:
    """The words, low and high, of the sum of 64 bits that a phi is one of; none if it is not."""
    for other in header.phis:
        for low, high in ((phi, other), (other, phi)):
            if low is not high and is_wide_sum(function, loop, low, high):
                return (
                    FoundReduction(low.id, _start(loop, low), Reduction(WIDE_LOW, 0, 0)),
                    FoundReduction(high.id, _start(loop, high), Reduction(WIDE_HIGH, 0, 0)),
                )
    return ()


def _start(loop: Loop, phi: Phi) -> Value:
    return next(value for source, value in phi.incoming if source not in loop.blocks)


def _result(
    function: Function, loop: Loop, found: tuple[FoundReduction, ...], loc: SourceLoc | None
) -> int | None:
    """The reduction that is returned; nothing else may use one after the loop."""
    own = {item.phi: number for number, item in enumerate(found)}
    inside = _inside(function, loop)
    outside = [block for block in function.blocks if block.name not in loop.blocks]
    results = set()
    for block in outside:
        carried = [value for phi in block.phis for _, value in phi.incoming]
        if any(isinstance(value, Ref) and value.id in inside for value in carried):
            raise _used_after(block, loc)
        for value in uses(block):
            if not isinstance(value, Ref) or value.id not in inside:
                continue
            returned = block.branch.target is None and value in (
                block.branch.value,
                block.branch.high,
            )
            if value.id not in own or not returned or not _is_whole(block, found, own):
                raise _used_after(block, loc)
            if block.branch.value == value:
                results.add(own[value.id])
    if not results:
        return None
    returns = {block.branch.value for block in outside if block.branch.target is None}
    if len(returns) > 1:
        raise KernelError(
            "the kernel returns what the loop over prange computes in one place, and something "
            "else in another",
            loc=next((b.branch.loc for b in outside if b.branch.target is None), None),
            hint="return the sum, minimum or maximum in all cases: with no iterations it is its "
            "start",
        )
    return results.pop()


def _used_after(block: Block, loop_loc: SourceLoc | None) -> KernelError:
    return KernelError(
        "what the loop over prange computes is used after it",
        loc=block.branch.loc or _first_loc(block) or loop_loc,
        hint="return the sum, minimum or maximum as it is, and go on with it on the host",
    )


def _refuse_kept_arrays(function: Function, loop: Loop, loc: SourceLoc | None) -> None:
    """An array of the kernel's own is on every tile: none may carry what the loop writes to where
    it is read behind the loop, or when the loop is entered again.
    """
    own = {local.name for local in function.locals if local.contents is None}
    blocks = {block.name: block for block in function.blocks}
    written = own & _accessed((blocks[name] for name in loop.blocks), Opcode.STORE)
    graph = block_graph(function)
    behind = {name for _, target in loop.exits for name in nx.descendants(graph, target) | {target}}
    kept = written & _accessed((blocks[name] for name in behind), Opcode.LOAD)
    if kept:
        again = "when it is entered again" if loop.header in behind else "behind it"
        raise KernelError(
            "the loop over prange writes an array of the kernel's own that is read " + again,
            loc=loc,
            hint="pass the array as an argument, and read it in another kernel",
        )


def _accessed(blocks: Iterable[Block], op: Opcode) -> set[str]:
    return {instr.array for block in blocks for instr in block.instrs if instr.op is op}


def _is_whole(block: Block, found: tuple[FoundReduction, ...], own: dict[int, int]) -> bool:
    """Whether a reduction is returned as what it is: one word, or low and high word of a sum."""
    low, high = block.branch.value, block.branch.high
    if not isinstance(low, Ref) or low.id not in own:
        return False
    item = found[own[low.id]]
    if item.how.op != WIDE_LOW:
        return high in (None, Const(0)) and item.how.op != WIDE_HIGH
    partner = found[own[low.id] + 1]
    return high is None or high == Ref(partner.phi)


def _first_loc(block: Block) -> SourceLoc | None:
    return next((instr.loc for instr in block.instrs if instr.loc is not None), None)


def _with_inputs(
    function: Function, loop: Loop, header: Block, starts: dict[int, Value]
) -> Function:
    """The function whose loop starts and ends at inputs."""

    def started(phi: Phi) -> Phi:
        if phi.id not in starts:
            return phi
        incoming = tuple(
            (source, value if source in loop.blocks else starts[phi.id])
            for source, value in phi.incoming
        )
        return replace(phi, incoming=incoming)

    def limited(instr: Instr) -> Instr:
        if Ref(instr.id) != header.branch.cond:
            return instr
        return replace(instr, op=Opcode.ICMP_SLT, operands=(instr.operands[0], Input(LAST)))

    changed = replace(
        header,
        phis=tuple(map(started, header.phis)),
        instrs=tuple(map(limited, header.instrs)),
    )
    return with_blocks(function, (changed,))


def _accesses(function: Function, loop: Loop, table: TermTable) -> Iterator[Access]:
    """What is read and written of the arguments; the kernel's own arrays stay on the tile."""
    own = {local.name for local in function.locals}
    runs = _runs_for_certain(function, loop)
    for block in function.blocks:
        in_body = block.name in loop.blocks and block.name != loop.header
        for instr in block.instrs:
            if instr.op not in (Opcode.LOAD, Opcode.STORE) or instr.array in own:
                continue
            term = table.of(instr.operands[1], table.facts(block.name))
            if not in_body and _depends_on_index(table.terms, term):
                term = table.anything()
            yield Access(
                array=instr.array,
                is_store=instr.op is Opcode.STORE,
                term=term,
                shift=instr.shift,
                offset=instr.offset,
                width=instr.width,
                counters=table.counters_around(block.name, loop) if in_body and runs else None,
                loc=instr.loc,
            )


def _runs_for_certain(function: Function, loop: Loop) -> bool:
    """Whether the loop is reached, however the kernel ends."""
    before = dominators(block_graph(function), function.blocks[0].name)
    ends = (block.name for block in function.blocks if block.branch.target is None)
    return all(loop.header in before[name] for name in ends if name in before)


def _depends_on_index(terms: list[Term], number: int) -> bool:
    term = terms[number]
    return term.op == INDEX or any(_depends_on_index(terms, arg) for arg in term.args)


def _described(item: FoundReduction, table: TermTable) -> Reduction:
    word = item.start.word if isinstance(item.start, Const) else None
    return replace(item.how, start=table.of(item.start), start_word=word)


def _demand_exact(terms: tuple[Term, ...], number: int, loc: SourceLoc | None) -> None:
    """What the host must know before the kernel starts comes from arguments only."""
    term = terms[number]
    if term.op in _INEXACT:
        raise KernelError(
            "a bound of the loop over prange, or where a reduction starts, is not computed from "
            "the kernel's arguments alone, the same each time",
            loc=loc,
            hint="pass it as an argument, or start from a constant",
        )
    for arg in term.args:
        _demand_exact(terms, arg, loc)
