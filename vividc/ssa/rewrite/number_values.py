"""Common subexpressions of a function: one instruction per value, in its block or in all blocks
that it dominates; of innermost loops recurrences, too, that begin with the same word and go on
alike.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping
from typing import Final

import networkx as nx

from vividc.machine.opcodes import MEMORY, OPCODES, Opcode
from vividc.ssa.edit import replaced
from vividc.ssa.flow import Loop, block_graph, dominators, pipelined_loops, predecessors
from vividc.ssa.ir import Block, Function, Instr, Kind, Phi, Ref, Value

_ANY: Final = -1
"""Stands for what an earlier iteration left, before it is known what else is equal."""
_Key = tuple[Opcode, Kind, tuple[Value, ...]]


def number_values(function: Function) -> Function:
    """Merges operations, accesses to memory aside, that have equal operands and where one is
    computed on every path to the other.

    Two additions of which one is proved not to wrap count as that one's equal only if the proof
    holds for the one that stays.
    """
    dominating = dominators(function)
    by_name = {block.name: block for block in function.blocks}
    order = nx.dfs_postorder_nodes(block_graph(function), function.blocks[0].name)
    blocks = [by_name[name] for name in reversed(list(order))]
    return _merged(function, blocks, lambda home, name: home in dominating[name])


def merge_equal(function: Function) -> Function:
    """The same within each block: what narrowing wrote twice, and hoisting brought together.

    Operations of different blocks stay apart: a word that lives from block to block costs more than
    an operation.
    """
    return _merged(function, function.blocks, lambda home, name: home == name)


def _merged(
    function: Function, blocks: Iterable[Block], serves: Callable[[str, str], bool]
) -> Function:
    """`serves`: whether an operation of the first block may stand for one of the second."""
    known: dict[int, Value] = {}
    first: dict[_Key, list[tuple[str, Instr]]] = {}
    for block in blocks:
        for instr in block.instrs:
            if instr.op in MEMORY:
                continue
            candidates = first.setdefault(_key(instr, known), [])
            kept = next((i for home, i in candidates if serves(home, block.name)), None)
            if kept is not None and (kept.exact or not instr.exact):
                known[instr.id] = Ref(kept.id)
            else:
                candidates.insert(0, (block.name, instr))
    return replaced(function, known)


def _key(instr: Instr, known: dict[int, Value]) -> _Key:
    operands = [known.get(v.id, v) if isinstance(v, Ref) else v for v in instr.operands]
    if OPCODES[instr.opcode].commutes:
        operands[:2] = sorted(operands[:2], key=_order)
    return instr.opcode, instr.type, tuple(operands)


def _order(value: Value) -> tuple[int, str]:
    """Operands that may be swapped come in this order."""
    return (value.id, "") if isinstance(value, Ref) else (-1, repr(value))


def merge_recurrences(function: Function) -> Function:
    """Merges what innermost loops compute twice, recurrences as wholes: rows of a solver whose
    factors follow from the same start by the same steps need them once.

    Words that iterations leave to the next count as equal until something tells them apart (value
    numbering in reverse postorder: Simpson 1996; the partition is that of Alpern, Wegman and
    Zadeck 1988). Operations of different blocks stay apart, as do accesses to memory.
    """
    known: dict[int, Value] = {}
    for loop in pipelined_loops(function):
        if _may_be_equal(function, loop):
            known |= _equals(function, loop)
    return replaced(function, known)


def _may_be_equal(function: Function, loop: Loop) -> bool:
    """Whether two phis of the header begin with the same word."""
    begins = [_begin(phi, loop) for phi in function.by_name[loop.header].phis]
    return len(set(begins)) < len(begins)


def _begin(phi: Phi, loop: Loop) -> Hashable:
    outside = tuple((name, value) for name, value in phi.incoming if name not in loop.blocks)
    return phi.type, outside


def _equals(function: Function, loop: Loop) -> dict[int, Value]:
    """What stands for phis and operations of the loop that have an equal before them."""
    blocks = [*_in_order(function, loop)]
    before: dict[int, int] = {}
    while True:
        now: dict[int, int] = {}
        first: dict[Hashable, int] = {}
        for block in blocks:
            for item in block.items:
                key = _word(item, block, loop, now, before)
                now[item.id] = item.id if key is None else first.setdefault(key, item.id)
        if now == before:
            return {item: Ref(kept) for item, kept in now.items() if item != kept}
        before = now


def _in_order(function: Function, loop: Loop) -> Iterator[Block]:
    """The loop's blocks, each behind those that lead to it within an iteration."""
    waiting = [loop.header]
    done: set[str] = set()
    while waiting:
        name = waiting.pop(0)
        done.add(name)
        yield function.by_name[name]
        for after in function.by_name[name].branch.successors:
            sources = {one for one in predecessors(function)[after] if one in loop.blocks}
            is_next = after in loop.blocks and after not in done and sources <= done
            if is_next and after not in waiting:
                waiting.append(after)


def _word(
    item: Phi | Instr, block: Block, loop: Loop, now: Mapping[int, int], before: Mapping[int, int]
) -> Hashable | None:
    """What the word depends on; None: it stays apart."""
    if isinstance(item, Phi):
        latches = loop.blocks if block.name == loop.header else ()
        values = (
            (name, _left(value, before) if name in latches else _number(value, now))
            for name, value in item.incoming
        )
        return block.name, item.type, tuple(values)
    if item.op in MEMORY:
        return None
    operands = [_number(value, now) for value in item.operands]
    if OPCODES[item.opcode].commutes:
        operands[:2] = sorted(operands[:2], key=_order)
    return block.name, item.opcode, item.type, item.exact, tuple(operands)


def _left(value: Value, before: Mapping[int, int]) -> Value:
    """What an iteration leaves to the next: before the first round, any word."""
    return _number(value, before) if before else Ref(_ANY)


def _number(value: Value, numbers: Mapping[int, int]) -> Value:
    if isinstance(value, Ref):
        return Ref(numbers.get(value.id, value.id))
    return value
