"""Tuples indexed by a variable: a table in memory if their elements are constants, else selects."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vividc.frontend.llvm.calls import PICK
from vividc.frontend.llvm.ir import Float, Global, Int, Local, Op, Operand, WideBlock, WideFunction
from vividc.frontend.memory.tables import Table

_BYTES = {"i8": 1, "i16": 2, "i32": 4, "float": 4, "i64": 8, "double": 8}
_FEW = 4
_EXACT_WORDS = frozenset({"i8", "i16", "i32", "float"})
_INT_LIMITS = (-(1 << 31), (1 << 31) - 1)


def expand_picks(
    function: WideFunction, tables: dict[str, Table]
) -> tuple[WideFunction, dict[str, Table]]:
    """Replace calls of `PICK`; the tables with those that this adds."""
    tables = dict(tables)

    def expanded(block: WideBlock) -> WideBlock:
        return replace(block, ops=tuple(new for op in block.ops for new in _expand(op, tables)))

    return replace(function, blocks=tuple(map(expanded, function.blocks))), tables


def _expand(op: Op, tables: dict[str, Table]) -> list[Op]:
    if op.op != "call" or not op.pred.startswith(PICK):
        return [op]
    index, *items = op.args
    values = [item.value for item in items if isinstance(item, Int | Float)]
    if len(items) <= _FEW or len(values) < len(items) or not _fit_words(op.type, values):
        out: list[Op] = []
        last = _choose(op, index, items, 0, out)
        if not out or out[-1].name != op.name:
            out.append(Op(op.name, "select", op.type, (Int(1), last, last), loc=op.loc))
        return out
    name = f"{PICK}{op.type} {values}"
    tables[name] = Table(op.type, tuple(values))
    place = Local(f"{op.name}.place")
    step = (_BYTES[op.type],)
    address = Op(
        place.name, "getelementptr", "ptr", (Global(name), index), strides=step, loc=op.loc
    )
    return [address, Op(op.name, "load", op.type, (place,), loc=op.loc)]


def _fit_words(type_: str, values: list[int | float]) -> bool:
    """Whether a table of words holds the values exactly."""
    low, high = _INT_LIMITS
    if type_ == "double":
        with np.errstate(over="ignore", under="ignore"):
            return all(float(np.float32(value)) == value for value in values)
    return type_ in _EXACT_WORDS or (type_ == "i64" and all(low <= v <= high for v in values))


def _choose(op: Op, index: Operand, items: list[Operand], first: int, out: list[Op]) -> Operand:
    """Selects as a binary search: as deep as the logarithm of the number of elements."""
    if len(items) == 1:
        return items[0]
    half = len(items) // 2
    low = _choose(op, index, items[:half], first, out)
    high = _choose(op, index, items[half:], first + half, out)
    below = Local(f"{op.name}.below{first + half}")
    out.append(Op(below.name, "icmp", "i32", (index, Int(first + half)), pred="slt", loc=op.loc))
    # The outermost select is the result.
    name = op.name if len(items) == len(op.args) - 1 else f"{op.name}.from{first}.{len(items)}"
    out.append(Op(name, "select", op.type, (below, low, high), loc=op.loc))
    return Local(name)
