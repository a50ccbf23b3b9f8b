"""Exceptions that numba's own functions raise: accesses that the simulator reports.

The array has no exceptions. Where `max` of an empty array or slices of different sizes would raise,
the kernel stores to an array of no words, whose name says what happened: no witness runs on. All
such arrays have one address, which takes an entry of a constant store (`params.base_of`). A
division by zero that raises goes on behind the store, so that its loop keeps one way out. What a
user raises is `user_raises`'.
"""

from __future__ import annotations

import re
from dataclasses import replace

from vividc.frontend.llvm.calls import RAISE_PREFIX, TRAP_PREFIX
from vividc.frontend.memory.arrays.local_arrays import OwnArray
from vividc.machine.params import TRAP, LocalArray
from vividc.ssa.ir import Branch, Float, Function, Instr, Int, Value

_TRAPPED = (
    "zero-size",
    "empty sequence",
    "cannot assign slice",
    "unable to broadcast",
    "total size of new array",
    "StopIteration",
    "incompatible",
    "negative dimensions",
    "RuntimeError: unreachable",
)
"""What exceptions of numba's functions say, of conditions that only the launch decides."""
_FAR = 0x7FFFFFFC
"""No array has a byte here."""
_NOTHING: dict[str, Value | None] = {"void": None, "float": Float(0.0), "double": Float(0.0)}
_PATH = re.compile(r"File '.*")
_NAMELESS = re.compile(r"\W+")


def trap_raises(function: Function) -> tuple[Function, dict[str, OwnArray]]:
    """Make stores of the raises, and the arrays by name that they store to."""
    held: dict[str, OwnArray] = {}
    blocks = []
    for block in function.blocks:
        names = {op.pred: _name(op.pred) for op in block.instrs if _is_trap(op)}
        held |= {name: OwnArray(LocalArray(name, 0), "i32") for name in names.values()}
        held |= {TRAP: OwnArray(LocalArray(TRAP, 0), "i32")} if names else {}
        ops = tuple(_store(op, names[op.pred]) if _is_trap(op) else op for op in block.instrs)
        leave = Branch(value=_NOTHING.get(function.result, Int(0)), loc=block.branch.loc)
        leaves = any(_is_raise(op) for op in block.instrs)
        blocks.append(replace(block, instrs=ops, branch=leave if leaves else block.branch))
    if not held:
        return function, held
    return replace(function, blocks=tuple(blocks)), held


def _is_trap(op: Instr) -> bool:
    return _is_raise(op) or (op.op == "call" and op.pred.startswith(TRAP_PREFIX))


def _is_raise(op: Instr) -> bool:
    """A raise that leaves the kernel."""
    return (
        op.op == "call"
        and op.pred.startswith(RAISE_PREFIX)
        and any(text in op.pred for text in _TRAPPED)
    )


def _name(callee: str) -> str:
    kind, _, text = _PATH.sub(
        "", callee.removeprefix(RAISE_PREFIX).removeprefix(TRAP_PREFIX)
    ).partition(":")
    return f"{TRAP}{kind}.{_NAMELESS.sub('_', text).strip('_')}".rstrip(".")


def _store(op: Instr, name: str) -> Instr:
    """Resolved already: no pointer is needed."""
    return Instr(op.id, "store", "i32", (Int(0), Int(_FAR)), array=name, loc=op.loc)
