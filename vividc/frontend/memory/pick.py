"""Tuples indexed by a variable: a table in memory if their elements are constants, else selects."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vividc.frontend.llvm.calls import PICK
from vividc.frontend.memory.tables import Table
from vividc.ssa.edit import FreshIds
from vividc.ssa.ir import Block, Float, Function, Global, Instr, Int, Kind, Ref, Value

_BYTES = {"i8": 1, "i16": 2, "i32": 4, "float": 4, "i64": 8, "double": 8}
_FEW = 4
_EXACT_WORDS = frozenset({"i8", "i16", "i32", "float"})
_INT_LIMITS = (-(1 << 31), (1 << 31) - 1)


def expand_picks(function: Function, tables: dict[str, Table]) -> tuple[Function, dict[str, Table]]:
    """Replace calls of `PICK`; the tables with those that this adds."""
    tables, ids = dict(tables), FreshIds(function)

    def expanded(block: Block) -> Block:
        return replace(
            block, instrs=tuple(new for op in block.instrs for new in _expand(op, tables, ids))
        )

    return replace(function, blocks=tuple(map(expanded, function.blocks))), tables


def _expand(op: Instr, tables: dict[str, Table], ids: FreshIds) -> list[Instr]:
    if op.op != "call" or not op.pred.startswith(PICK):
        return [op]
    index, *items = op.operands
    if isinstance(index, Int) and 0 <= index.value < len(items):
        items = [items[index.value]]
    values = [item.value for item in items if isinstance(item, Int | Float)]
    if len(items) <= _FEW or len(values) < len(items) or not _fit_words(op.type, values):
        out: list[Instr] = []
        last = _choose(op, items, 0, ids, out)
        if out:
            out[-1] = replace(out[-1], id=op.id)
        else:
            out.append(Instr(op.id, "select", op.type, (Int(1), last, last), loc=op.loc))
        return out
    name = f"{PICK}{op.type} {values}"
    element = str(op.type)
    tables[name] = Table(element, tuple(values))
    at, step = (Global(name), index), (_BYTES[element],)
    address = Instr(ids(), "getelementptr", "ptr", at, strides=step, loc=op.loc)
    return [address, Instr(op.id, "load", op.type, (Ref(address.id),), loc=op.loc)]


def _fit_words(type_: Kind, values: list[int | float]) -> bool:
    """Whether a table of words holds the values exactly."""
    low, high = _INT_LIMITS
    if type_ == "double":
        with np.errstate(over="ignore", under="ignore"):
            return all(float(np.float32(value)) == value for value in values)
    return type_ in _EXACT_WORDS or (type_ == "i64" and all(low <= v <= high for v in values))


def _choose(op: Instr, items: list[Value], first: int, ids: FreshIds, out: list[Instr]) -> Value:
    """Selects as a binary search: as deep as the logarithm of the number of elements."""
    if len(items) == 1:
        return items[0]
    half = len(items) // 2
    low = _choose(op, items[:half], first, ids, out)
    high = _choose(op, items[half:], first + half, ids, out)
    tested = (op.operands[0], Int(first + half))
    below = Instr(ids(), "icmp", "i32", tested, pred="slt", loc=op.loc)
    chosen = Instr(ids(), "select", op.type, (Ref(below.id), low, high), loc=op.loc)
    out += (below, chosen)
    return Ref(chosen.id)
