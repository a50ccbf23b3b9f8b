"""The invariants of `ssa.ir.Function`: what the frontend promises and regions rely on."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from vividc.machine.opcodes import MEMORY, OPCODES, Opcode
from vividc.ssa.flow import block_graph, dominators
from vividc.ssa.ir import Block, Const, Function, Instr, Phi, Ref, Value

_WORD_LIMIT = 1 << 32
_WORD_BYTES = 4
_WIDTHS = (1, 2, _WORD_BYTES)
_NOT_INSTRUCTIONS = frozenset(
    {Opcode.CONST, Opcode.LIVE_IN, Opcode.LIVE_OUT, Opcode.IV, Opcode.GENERIC}
)


def check_function(fn: Function) -> list[str]:
    """Every broken invariant of a function, one sentence each; empty if it is well formed.

    Blocks and results are unique; branches name blocks, and every block can be reached; operands
    are as many as the opcode takes and constants are words; phis list exactly their block's
    predecessors; definitions dominate uses.
    """
    structure = [*_unique(fn), *_targets(fn)]
    if structure:  # the other rules look blocks up by name
        return structure
    return [*_operands(fn), *_phis(fn), *_dominance(fn)]


def _unique(fn: Function) -> Iterator[str]:
    if not fn.blocks:
        yield "there is no block"
    for name, count in Counter(block.name for block in fn.blocks).items():
        if count > 1:
            yield f"{count} blocks are named {name}"
    ids = Counter(id_ for block in fn.blocks for id_ in _defined(block))
    for id_, count in ids.items():
        if count > 1:
            yield f"{count} definitions have id {id_}"


def _defined(block: Block) -> list[int]:
    return [phi.id for phi in block.phis] + [instr.id for instr in block.instrs]


def _targets(fn: Function) -> Iterator[str]:
    names = {block.name for block in fn.blocks}
    for block in fn.blocks:
        branch = block.branch
        yield from (
            f"{block.name} branches to {t}, which is no block"
            for t in branch.successors
            if t not in names
        )
        if branch.cond is not None and (branch.target is None or branch.otherwise is None):
            yield f"{block.name} branches on a condition to fewer than two blocks"
        if branch.value is not None and branch.target is not None:
            yield f"{block.name} jumps and returns a value"


def _operands(fn: Function) -> Iterator[str]:
    for block in fn.blocks:
        for instr in block.instrs:
            yield from _operands_of(instr, block)
        for value in _read(block):
            if isinstance(value, Const) and not 0 <= value.word < _WORD_LIMIT:
                yield f"a constant in {block.name} is no word: {value.word}"


def _operands_of(instr: Instr, block: Block) -> Iterator[str]:
    place = f"{instr.mnemonic} {instr.id} in {block.name}"
    if instr.op in _NOT_INSTRUCTIONS:
        yield f"{place} is no instruction"
        return
    expected = OPCODES[instr.opcode].arity + (1 if instr.op in MEMORY else 0)
    predicated = 1 if instr.op in MEMORY else 0
    if not expected <= len(instr.operands) <= expected + predicated:
        yield f"{place} has {len(instr.operands)} operands instead of {expected}"
    if instr.op in MEMORY and not instr.array:
        yield f"{place} names no array"
    yield from (f"{place} {problem}" for problem in _width_problems(instr))


def _width_problems(instr: Instr) -> Iterator[str]:
    if instr.width not in _WIDTHS or (instr.op not in MEMORY and instr.width != _WORD_BYTES):
        yield f"has a width of {instr.width} bytes"
    if instr.signed and (instr.op is not Opcode.LOAD or instr.width == _WORD_BYTES):
        yield "is signed and no load of less than a word"


def _phis(fn: Function) -> Iterator[str]:
    graph = block_graph(fn)
    for block in fn.blocks:
        if block.name not in graph:
            yield f"{block.name} cannot be reached"
            continue
        predecessors = sorted(graph.predecessors(block.name))
        if block is fn.blocks[0] and predecessors:
            yield f"the entry {block.name} has predecessors"
        for phi in block.phis:
            if sorted(name for name, _ in phi.incoming) != predecessors:
                yield f"phi {phi.id} in {block.name} does not list the predecessors {predecessors}"


def _dominance(fn: Function) -> Iterator[str]:
    dominating = dominators(block_graph(fn), fn.blocks[0].name)
    home = {id_: block.name for block in fn.blocks for id_ in _defined(block)}
    for block in fn.blocks:
        if block.name not in dominating:
            continue
        for phi in block.phis:
            for pred, value in phi.incoming:
                if pred in dominating and not _available(value, home, dominating[pred]):
                    place = f"phi {phi.id} in {block.name}"
                    yield f"{place} reads {value} from {pred}, where it is not defined"
        yield from _order(block, home, dominating[block.name])


def _order(block: Block, home: dict[int, str], dominating: frozenset[str]) -> Iterator[str]:
    """Uses within a block come after the definitions."""
    later = {instr.id for instr in block.instrs}
    for instr in block.instrs:
        for value in instr.operands:
            if _is_in(value, later) or not _available(value, home, dominating):
                place = f"{instr.mnemonic} {instr.id} in {block.name}"
                yield f"{place} reads {value} before its definition"
        later.discard(instr.id)
    for read in block.branch.read:
        if not _available(read, home, dominating):
            yield f"the branch of {block.name} reads {read}, which is not defined there"


def _is_in(value: Value, ids: set[int]) -> bool:
    return isinstance(value, Ref) and value.id in ids


def _available(value: Value, home: dict[int, str], dominating: frozenset[str]) -> bool:
    return not isinstance(value, Ref) or home.get(value.id) in dominating


def _read(block: Block) -> Iterator[Value]:
    yield from (value for phi in block.phis for value in _values(phi))
    yield from (value for instr in block.instrs for value in instr.operands)
    yield from block.branch.read


def _values(phi: Phi) -> tuple[Value, ...]:
    return tuple(value for _, value in phi.incoming)
