"""The invariants of `ssa.ir.Function`: what the frontend promises and regions rely on."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from typing import Final

from vividc.machine.opcodes import MEMORY, OPCODES, Opcode, Type
from vividc.machine.words import WORD_BYTES, WORD_MASK
from vividc.ssa.edit import read_values
from vividc.ssa.flow import block_graph, dominators
from vividc.ssa.ir import (
    LLVM_BINARY,
    LLVM_CASTS,
    Block,
    Const,
    Function,
    Input,
    Instr,
    Kind,
    Named,
    Ref,
    Value,
)

_WIDTHS = (1, 2, WORD_BYTES)
_NOT_INSTRUCTIONS = frozenset(
    {Opcode.CONST, Opcode.LIVE_IN, Opcode.LIVE_OUT, Opcode.IV, Opcode.GENERIC}
)


def check_function(fn: Function) -> list[str]:
    """Every broken invariant of a function, one sentence each; empty if it is well formed.

    Blocks and results are unique; branches name blocks, and every block can be reached; operands
    are as many as the operation takes; phis list exactly their block's predecessors; definitions
    dominate uses. Operations, types and constants are all the machine's, or all LLVM's, whose
    inputs are declared.
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
    rule = _llvm_operands if fn.is_llvm else _operands_of
    fits = _llvm_value(fn) if fn.is_llvm else _word_value
    for block in fn.blocks:
        for instr in block.instrs:
            yield from rule(instr, block)
        for item in block.items:
            if isinstance(item.type, Type) is fn.is_llvm:
                yield f"{item.id} in {block.name} has the type {item.type} of the other vocabulary"
        for value in read_values(block):
            problem = fits(value)
            if problem:
                yield f"a value in {block.name} {problem}"


def _word_value(value: Value) -> str:
    if isinstance(value, Const):
        return "" if 0 <= value.word <= WORD_MASK else f"is not a word: {value.word}"
    return "" if isinstance(value, Named) else f"is not a word but a value of LLVM's: {value}"


def _llvm_value(fn: Function) -> Callable[[Value], str]:
    known = {key for key, _ in fn.inputs}

    def problem(value: Value) -> str:
        if isinstance(value, Const):
            return f"is a word among LLVM's: {value}"
        is_known = not isinstance(value, Input) or value.key in known
        return "" if is_known else f"is no input: {value}"

    return problem


def _llvm_operands(instr: Instr, block: Block) -> Iterator[str]:
    place = f"{instr.mnemonic} {instr.id} in {block.name}"
    if isinstance(instr.op, Opcode):
        yield f"{place} is no operation of LLVM's"
        return
    expected = _LLVM_ARITY.get(instr.op)
    if expected is not None and len(instr.operands) != expected:
        yield f"{place} has {len(instr.operands)} operands instead of {expected}"
    if instr.op in _PREDICATES and instr.pred not in _PREDICATES[instr.op]:
        yield f"{place} compares by {instr.pred!r}"
    for kind in _integers_of(instr):
        if not _INTEGER.fullmatch(str(kind)):
            yield f"{place} is of {kind}, which is no type of integers"
    if instr.op == "getelementptr" and not 0 <= len(instr.operands) - len(instr.strides) <= 1:
        yield f"{place} has {len(instr.strides)} strides for {len(instr.operands)} operands"
    if instr.array:
        yield from (f"{place} {problem}" for problem in _width_problems(instr, ("load",)))


def _integers_of(instr: Instr) -> Iterator[Kind]:
    """The types of an instruction that must be of integers."""
    if instr.op in _OF_INTEGERS or (instr.op == "icmp" and instr.type != "ptr"):
        yield instr.type
    if instr.op in ("trunc", "zext", "sext", "sitofp", "uitofp"):
        yield instr.source


_INTEGER: Final = re.compile(r"i[1-9]\d{0,3}")
_OF_INTEGERS: Final = frozenset(
    {*(op for op in LLVM_BINARY if op[0] != "f"), "trunc", "zext", "sext", "fptosi", "fptoui"}
)
_ORDERS: Final = ("eq", "ne", "lt", "le", "gt", "ge")
_PREDICATES: Final[Mapping[str, frozenset[str]]] = {
    "icmp": frozenset({"eq", "ne", *(f"{sign}{way}" for sign in "su" for way in _ORDERS[2:])}),
    "fcmp": frozenset({"ord", "uno", *(f"{kind}{way}" for kind in "ou" for way in _ORDERS)}),
}
_LLVM_ARITY: Final[Mapping[str, int]] = {
    **dict.fromkeys(("load", "freeze", "fneg", "extractvalue", *LLVM_CASTS), 1),
    **dict.fromkeys(("store", "icmp", "fcmp", "insertvalue", *LLVM_BINARY), 2),
    "select": 3,
}


def _operands_of(instr: Instr, block: Block) -> Iterator[str]:
    place = f"{instr.mnemonic} {instr.id} in {block.name}"
    if instr.op in _NOT_INSTRUCTIONS or not isinstance(instr.op, Opcode):
        yield f"{place} is no instruction"
        return
    expected = OPCODES[instr.op].arity + (1 if instr.op in MEMORY else 0)
    predicated = 1 if instr.op in MEMORY else 0
    if not expected <= len(instr.operands) <= expected + predicated:
        yield f"{place} has {len(instr.operands)} operands instead of {expected}"
    if instr.op in MEMORY and not instr.array:
        yield f"{place} names no array"
    yield from (f"{place} {problem}" for problem in _width_problems(instr))


def _width_problems(
    instr: Instr, loads: tuple[Opcode | str, ...] = (Opcode.LOAD,)
) -> Iterator[str]:
    if instr.width not in _WIDTHS or (not instr.array and instr.width != WORD_BYTES):
        yield f"has a width of {instr.width} bytes"
    if instr.signed and (instr.op not in loads or instr.width == WORD_BYTES):
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
            if phi.type is Type.NONE:
                yield f"phi {phi.id} in {block.name} is of what has no value"


def _dominance(fn: Function) -> Iterator[str]:
    dominating = dominators(fn)
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
