"""Cuts a kernel's data-parallel loop: the function then runs the iterations from the input `FIRST`
to the input `LAST`, and a launch can give each tile its own.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

from vividc.errors import KernelError, SourceLoc
from vividc.machine.opcodes import Opcode, Type
from vividc.machine.parallel import (
    FIRST,
    INDEX,
    LAST,
    START,
    WIDE_HIGH,
    WIDE_LOW,
    Access,
    Parallel,
    Reduction,
    Term,
)
from vividc.ssa.analysis.counters import bounded
from vividc.ssa.analysis.induction import constant_step, initial
from vividc.ssa.analysis.polynomial import constant
from vividc.ssa.analysis.reductions import FoundReduction, reduction_of
from vividc.ssa.edit import with_blocks
from vividc.ssa.flow import Loop, find_loops
from vividc.ssa.ir import Block, Const, Function, Input, Instr, Phi, Ref, Value, definition_of
from vividc.ssa.parallel.beside import (
    NOTHING_SHARED,
    Beginnings,
    Sharing,
    alike,
    between_inputs,
    own_stored,
    sharing_of,
)
from vividc.ssa.parallel.blocks import Bounds, blocked
from vividc.ssa.parallel.going_on import going_on
from vividc.ssa.parallel.spread_proof import (
    is_exact,
    own_arrays_not_apart,
    raises,
    returned_reduction,
    runs_for_certain,
)
from vividc.ssa.parallel.terms import TermTable
from vividc.ssa.parallel.wide_sums import is_wide_sum
from vividc.ssa.polyhedral.subscripts import Subscripts, subscripts_of

_COMBINED = (
    "only a sum, product, minimum or maximum in one variable, which nothing else in the loop "
    "reads, can be combined, "
)
_INTEGERS = _COMBINED + "and but for a sum it has 32 bits: np.int32 makes such integers"
_FLOATS = _COMBINED + (
    "a minimum or maximum with the variable first, min(s, x[i]): with x[i] first, a NaN takes its "
    "place until the next number"
)
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
        product, minimum or maximum that the kernel returns.
    """
    function = going_on(function)
    loop, header, others = _marked_loop(function, lines)
    index, _, _ = _bounds(function, loop, header)
    unproved = own_arrays_not_apart(function, loop, TermTable(function, index.id))
    refusals = {other.header: _second(function, other) for other in others}
    for other in others:
        unproved |= dict.fromkeys(
            own_stored(function, other) - unproved.keys(), refusals[other.header]
        )
    sharing = sharing_of(function, loop, unproved)
    for one in sharing.companions:
        refusals.pop(one.loop.header, None)
    for refusal in refusals.values():
        raise refusal
    function = between_inputs(function, sharing.companions)
    return _cut(function, loop, function.by_name[header.name], sharing=sharing)


def _second(function: Function, loop: Loop) -> KernelError:
    return KernelError(
        "a second loop over prange",
        loc=function.by_name[loop.header].branch.loc,
        hint="make a kernel of each, and run one after the other",
    )


def cut_nest(
    function: Function, header: str, around: Collection[str] = ()
) -> tuple[Function, Parallel]:
    """Cut the loop at `header`, the outermost of a nest, and block the loops directly inside, if
    they do all that it stores.

    Parameters
    ----------
    around
        Keys of inputs that are counters of loops around it.

    Raises
    ------
    KernelError
        As above, or an iteration hands anything to the next otherwise than in arrays.
    """
    function, bounds = blocked(function, header)
    loop = next(loop for loop in find_loops(function) if loop.header == header)
    cut, parallel = _cut(function, loop, function.by_name[header], bounds)
    if parallel.reductions:
        raise KernelError(
            "an iteration of a loop needs a number that an earlier one computed",
            loc=parallel.loc,
            hint=_HINT,
        )
    return cut, replace(parallel, around=tuple(sorted(around)))


def _cut(
    function: Function,
    loop: Loop,
    header: Block,
    inside: Sequence[Bounds] = (),
    sharing: Sharing = NOTHING_SHARED,
) -> tuple[Function, Parallel]:
    loc = header.branch.loc
    index, first, last = _bounds(function, loop, header)
    carried = _reductions(function, loop, header, index)
    result = returned_reduction(function, loop, carried)
    starts: dict[int, Value] = {index.id: Input(FIRST)}
    starts |= {item.phi: Input(f"{START}{n}") for n, item in enumerate(carried)}
    cut = _with_inputs(function, loop, header, starts)
    table = TermTable(cut, index.id)
    for name, refusal in own_arrays_not_apart(cut, loop, table).items():
        if name not in sharing.sliced:
            raise refusal
    accesses = tuple(_accesses(cut, loop, table, sharing))
    described = tuple(one.described(table) for one in sharing.companions)
    bounds = (table.of(first), table.of(last))
    reductions = tuple(_described(item, table) for item in carried)
    around = table.facts(header.branch.target or "")
    blocks = tuple((table.of(start, around), table.of(end, around)) for start, end in inside)
    terms = tuple(table.terms)
    for term in bounds:
        _demand_exact(table, term, loc)
    for item in reductions:
        if item.start_word is None:
            _demand_exact(table, item.start, loc)
    tests = (instr for instr in header.instrs if Ref(instr.id) == header.branch.cond)
    is_unsigned = any(test.op is Opcode.ICMP_ULT for test in tests)
    made = Parallel(terms, *bounds, accesses, reductions, result, is_unsigned, blocks, loc=loc)
    same = alike(cut, loop, sharing.companions, table)
    return cut, replace(made, beside=described, sliced=tuple(sorted(sharing.sliced)), alike=same)


def _marked_loop(
    function: Function, lines: Collection[int]
) -> tuple[Loop, Block, tuple[Loop, ...]]:
    """The longest loop of those that `prange` marks, its header, and the others."""
    blocks = {block.name: block for block in function.blocks}
    marked: list[Loop] = []
    for loop in reversed(find_loops(function)):
        loc = blocks[loop.header].branch.loc
        own = loc is not None and loc.file == function.file and loc.line in lines
        # A `while` around it whose test is at its end begins with what leads to it, in its line.
        own = own and blocks[loop.header].branch.cond is not None
        if own and not any(loop.header in outer.blocks for outer in marked):
            marked.append(loop)
    if not marked:
        raise KernelError(
            "the loop over prange is gone: it runs once at most",
            loc=SourceLoc(function.file, min(lines)),
            hint="compile the kernel for one tile",
        )
    most = max(marked, key=lambda loop: sum(len(blocks[name].items) for name in loop.blocks))
    others = tuple(loop for loop in marked if loop is not most)
    return most, blocks[most.header], others


def _bounds(function: Function, loop: Loop, header: Block) -> tuple[Phi, Value, Value]:
    """The loop's variable, its first value, and the limit."""
    loc = header.branch.loc
    test = definition_of(function, header.branch.cond)
    if set(_early(function, loop)) or header.name not in {source for source, _ in loop.exits}:
        raise KernelError("a loop over prange cannot be left early", loc=loc, hint=_HINT)
    tests = (Opcode.ICMP_SLT, Opcode.ICMP_ULT)
    steps = {constant_step(function, loop, phi) for phi in header.phis} - {None}
    if steps and 1 not in steps:
        raise KernelError("the loop over prange does not count up by one", loc=loc, hint=_HINT)
    if (
        not isinstance(test, Instr)
        or test.op not in tests
        or header.branch.target not in loop.blocks
    ):
        raise KernelError(
            "the loop over prange does not count up to a limit of one word",
            loc=loc,
            hint="give it bounds of 32 bits, as in prange(np.int32(n))",
        )
    for induction, step, limit in bounded(function, loop, *test.operands):
        if induction.start is not None and step == 1:
            return induction.phi, induction.start, limit
    raise KernelError("the loop over prange does not count up by one", loc=loc, hint=_HINT)


def _early(function: Function, loop: Loop) -> Iterator[str]:
    """Blocks that leave a loop otherwise than by its test or an exception."""
    for source, target in loop.exits:
        if source != loop.header and not raises(function, function.by_name[target]):
            yield source


def _reductions(
    function: Function, loop: Loop, header: Block, index: Phi
) -> tuple[FoundReduction, ...]:
    reductions: list[FoundReduction] = []
    for phi in header.phis:
        if phi.id == index.id or any(item.phi == phi.id for item in reductions):
            continue
        item = reduction_of(function, loop, phi)
        pair = () if item is not None else _wide_sum(function, loop, header, phi)
        if item is None and not pair:
            raise KernelError(
                "an iteration of the loop over prange needs what an earlier one computed",
                loc=phi.loc or header.branch.loc,
                hint=_FLOATS if phi.type is Type.F32 else _INTEGERS,
            )
        reductions += pair if item is None else (item,)
    return tuple(reductions)


def _wide_sum(
    function: Function, loop: Loop, header: Block, phi: Phi
) -> tuple[FoundReduction, ...]:
    """The words, low and high, of the sum of 64 bits that a phi is one of; none if it is not."""
    for other in header.phis:
        for low, high in ((phi, other), (other, phi)):
            if low is not high and is_wide_sum(function, loop, low, high):
                return (
                    FoundReduction(low.id, initial(low, loop.blocks), Reduction(WIDE_LOW, 0, 0)),
                    FoundReduction(high.id, initial(high, loop.blocks), Reduction(WIDE_HIGH, 0, 0)),
                )
    return ()


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


def _accesses(
    function: Function, loop: Loop, table: TermTable, sharing: Sharing
) -> Iterator[Access]:
    """What is read and written of the arguments, and of the kernel's own arrays of which chunks
    have slices; others stay on the tile.
    """
    runs = runs_for_certain(function, loop) and len(loop.exits) == 1
    own = {local.name for local in function.locals} - sharing.sliced
    if function.results is not None:
        own.add(function.results.error)  # each chunk has its own
    beginnings = Beginnings(function, sharing.companions, table)
    places = subscripts_of(function)
    for block in function.blocks:
        in_body = block.name in loop.blocks and block.name != loop.header
        beside = beginnings.of(block.name)
        counters = table.counters_around(block.name, loop) if in_body and runs else None
        if beside is not None:
            counters = beginnings.counters(beside, block.name)
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
                counters=counters,
                subscripts=_subscripts(places, instr, table, block.name) if in_body else (),
                beside=None if beside is None else beside.number,
                leads=beside is not None and beginnings.leads(beside, instr.array),
                loc=instr.loc,
            )


def _subscripts(places: Subscripts, access: Instr, table: TermTable, block: str) -> tuple[int, ...]:
    """Terms of an access's subscripts."""
    parts = places.of(access)
    param = next((p for p in places.function.params if p.name == access.array), None)
    in_step = access.offset % (1 << access.shift) == 0 and access.width == 1 << access.shift
    if parts is None or param is None or len(parts) != param.ndim or not in_step:
        return ()
    more = constant(access.offset >> access.shift)
    facts = table.facts(block)
    return tuple(
        table.sum_of(part.plus(more) if part is parts[-1] else part, facts) for part in parts
    )


def _depends_on_index(terms: list[Term], number: int) -> bool:
    term = terms[number]
    return term.op == INDEX or any(_depends_on_index(terms, arg) for arg in term.args)


def _described(item: FoundReduction, table: TermTable) -> Reduction:
    word = item.start.word if isinstance(item.start, Const) else None
    return replace(item.how, start=table.of(item.start), start_word=word)


def _demand_exact(table: TermTable, number: int, loc: SourceLoc | None) -> None:
    """What the host must know before the kernel starts comes from arguments only."""
    if not is_exact(table, number):
        raise KernelError(
            "a bound of the loop over prange, or where a reduction starts, is not computed from "
            "the kernel's arguments alone",
            loc=loc,
            hint="pass it as an argument, or start from a constant",
        )
