"""LLVM IR as plain data: what stages rewrite between the parser and `ssa.ir.Function`.

Types are LLVM's names ("i64", "float", "ptr", ...). Everything is frozen; a stage returns a new
function.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from vividc.errors import SourceLoc
from vividc.host import time_limit


@dataclass(frozen=True, slots=True)
class Local:
    """A parameter or the result of an instruction or phi."""

    name: str


@dataclass(frozen=True, slots=True)
class Int:
    """An integer constant, as LLVM prints it (signed); predicates are 0 and 1."""

    value: int


@dataclass(frozen=True, slots=True, eq=False)
class Float:
    """A floating-point constant, exact. Equal by its bits: -0.0 is not 0.0, and NaN is itself."""

    value: float

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Float) and self._bits() == other._bits()

    def __hash__(self) -> int:
        return hash(self._bits())

    def _bits(self) -> bytes:
        return struct.pack("<d", self.value)


@dataclass(frozen=True, slots=True)
class Global:
    """A global variable or function, or the place `offset` bytes into it."""

    name: str
    offset: int = 0


@dataclass(frozen=True, slots=True)
class Parts:
    """A constant array or structure, member by member; without values: zeros, or undefined."""

    values: tuple[Operand, ...] = ()


Operand = Local | Int | Float | Global | Parts


@dataclass(frozen=True, slots=True)
class Op:
    """One instruction.

    Attributes
    ----------
    name
        Its result, "" if it has none.
    op
        LLVM's opcode; "call" for calls.
    type
        Type of the result; for a store the type stored, for a comparison that of its operands.
    args
        Operands. `load`: index once the address is resolved, pointer before. `store`: value, then
        the same.
    pred
        Predicate of a comparison, or callee of a call.
    source
        Type before a conversion; element type of a `getelementptr`; type of what `extractvalue`
        reads from, and of what `insertvalue` puts in.
    array, shift, offset
        Resolved loads and stores: byte address = base of array + (index << shift) + offset.
    width, signed
        Resolved loads and stores: bytes accessed; whether a load of less than a word sign-extends
        to its type.
    subscript
        Loads and stores of an element of a parameter: the constant subscripts among those that the
        program gives it, None for the others. () if nothing is known.
    strides
        `getelementptr`: bytes per unit of each index; `insertvalue`, `extractvalue`: the indices.
    flags
        What LLVM may assume of it, such as "nsw".
    """

    name: str
    op: str
    type: str
    args: tuple[Operand, ...]
    pred: str = ""
    source: str = ""
    array: str = ""
    shift: int = 0
    offset: int = 0
    width: int = 4
    signed: bool = False
    subscript: tuple[int | None, ...] = ()
    strides: tuple[int, ...] = ()
    flags: frozenset[str] = frozenset()
    loc: SourceLoc | None = None


@dataclass(frozen=True, slots=True)
class WidePhi:
    """A phi: (predecessor, value) pairs."""

    name: str
    type: str
    incoming: tuple[tuple[str, Operand], ...]
    loc: SourceLoc | None = None


@dataclass(frozen=True, slots=True)
class Exit:
    """A terminator. No targets: return of `value`; one: jump; two: taken if `cond` is 1, else the
    second.
    """

    targets: tuple[str, ...] = ()
    cond: Operand | None = None
    value: Operand | None = None
    unreachable: bool = False
    loc: SourceLoc | None = None


@dataclass(frozen=True, slots=True)
class WideBlock:
    """A basic block."""

    name: str
    phis: tuple[WidePhi, ...]
    ops: tuple[Op, ...]
    exit: Exit

    @property
    def items(self) -> tuple[Op | WidePhi, ...]:
        """Phis, then instructions."""
        return (*self.phis, *self.ops)


@dataclass(frozen=True)
class WideFunction:
    """A function; `params` are (name, type) pairs; the first block is the entry."""

    params: tuple[tuple[str, str], ...]
    blocks: tuple[WideBlock, ...]
    returns: str = "void"

    @cached_property
    def by_name(self) -> dict[str, WideBlock]:
        """Block of each name."""
        return {block.name: block for block in self.blocks}

    @cached_property
    def definitions(self) -> dict[str, Op | WidePhi]:
        """Instruction or phi of each result."""
        found: dict[str, Op | WidePhi] = {}
        for block in self.blocks:
            found.update((phi.name, phi) for phi in block.phis)
            found.update((op.name, op) for op in block.ops if op.name)
        return found

    @cached_property
    def block_of(self) -> dict[str, str]:
        """Block that defines each result."""
        found: dict[str, str] = {}
        for block in self.blocks:
            found.update((phi.name, block.name) for phi in block.phis)
            found.update((op.name, block.name) for op in block.ops if op.name)
        return found

    @cached_property
    def successors(self) -> dict[str, tuple[str, ...]]:
        """Blocks that may follow each block."""
        return {block.name: block.exit.targets for block in self.blocks}


def type_of(function: WideFunction, operand: Operand) -> str:
    """LLVM type of a local's value ("" for constants)."""
    if not isinstance(operand, Local):
        return ""
    definition = function.definitions.get(operand.name)
    if definition is None:
        return dict(function.params)[operand.name]
    if isinstance(definition, Op) and definition.op in ("icmp", "fcmp"):
        return "i1"
    return definition.type


def uses(block: WideBlock) -> Iterator[Operand]:
    """Operands of all phis, instructions and of the terminator."""
    for phi in block.phis:
        for _, value in phi.incoming:
            yield value
    for op in block.ops:
        yield from op.args
    yield from exit_uses(block.exit)


def exit_uses(leave: Exit) -> tuple[Operand, ...]:
    """Operands of a terminator."""
    return tuple(value for value in (leave.cond, leave.value) if value is not None)


def substitute(function: WideFunction, known: Mapping[str, Operand]) -> WideFunction:
    """Replace locals by other operands; chains of replacements are followed."""
    if not known:
        return function

    def final(operand: Operand) -> Operand:
        while isinstance(operand, Local) and operand.name in known:
            operand = known[operand.name]
        return operand

    return replace(function, blocks=tuple(map_operands(block, final) for block in function.blocks))


def map_operands(block: WideBlock, change: Callable[[Operand], Operand]) -> WideBlock:
    """The block with `change` applied to every operand."""
    time_limit.step("it was lowered")
    leave = block.exit
    return WideBlock(
        block.name,
        tuple(
            replace(phi, incoming=tuple((pred, change(value)) for pred, value in phi.incoming))
            for phi in block.phis
        ),
        tuple(replace(op, args=tuple(change(arg) for arg in op.args)) for op in block.ops),
        replace(
            leave,
            cond=None if leave.cond is None else change(leave.cond),
            value=None if leave.value is None else change(leave.value),
        ),
    )


def remove_unreachable(function: WideFunction) -> WideFunction:
    """Drop blocks that no path from the entry reaches, and their entries in phis."""
    reached: set[str] = set()
    pending = [function.blocks[0].name]
    while pending:
        name = pending.pop()
        if name not in reached:
            reached.add(name)
            pending.extend(function.successors[name])
    edges = {(b.name, t) for b in function.blocks if b.name in reached for t in b.exit.targets}
    blocks = tuple(
        replace(
            block,
            phis=tuple(
                replace(phi, incoming=tuple(x for x in phi.incoming if (x[0], block.name) in edges))
                for phi in block.phis
            ),
        )
        for block in function.blocks
        if block.name in reached
    )
    return replace(function, blocks=blocks)


def remove_dead(function: WideFunction) -> WideFunction:
    """Drop phis and instructions whose results reach no store, branch, call or return."""
    time_limit.step("it was lowered")
    live: set[str] = set()
    pending: list[Operand] = []
    for block in function.blocks:
        pending.extend(exit_uses(block.exit))
        for op in block.ops:
            if has_effect(op):
                pending.extend(op.args)
    while pending:
        operand = pending.pop()
        if not isinstance(operand, Local) or operand.name in live:
            continue
        live.add(operand.name)
        definition = function.definitions.get(operand.name)
        if isinstance(definition, WidePhi):
            pending.extend(value for _, value in definition.incoming)
        elif definition is not None:
            pending.extend(definition.args)
    blocks = tuple(
        replace(
            block,
            phis=tuple(phi for phi in block.phis if phi.name in live),
            ops=tuple(op for op in block.ops if op.name in live or has_effect(op)),
        )
        for block in function.blocks
    )
    return replace(function, blocks=blocks)


def has_effect(op: Op) -> bool:
    """Whether the instruction must stay even if nothing reads its result."""
    pure = op.pred.startswith(_HINTS) or (op.pred.startswith("llvm.") and op.type != "void")
    return op.op == "store" or (op.op == "call" and not pure)


_HINTS = tuple(
    f"llvm.{name}"
    for name in ("assume", "dbg.", "lifetime.", "donothing", "prefetch", "experimental.noalias.")
)
"""Functions of LLVM that return nothing and do nothing."""


@dataclass(frozen=True)
class Flow:
    """Dominators of a control-flow graph (Cooper, Harvey and Kennedy 2001)."""

    entry: str
    successors: Mapping[str, tuple[str, ...]]
    order: tuple[str, ...] = field(init=False)
    predecessors: dict[str, tuple[str, ...]] = field(init=False)
    idom: dict[str, str] = field(init=False)

    def __post_init__(self) -> None:
        order = _reverse_postorder(self.entry, self.successors)
        preds: dict[str, list[str]] = {name: [] for name in order}
        for name in order:
            for target in dict.fromkeys(self.successors[name]):
                preds[target].append(name)
        object.__setattr__(self, "order", tuple(order))
        object.__setattr__(self, "predecessors", {k: tuple(v) for k, v in preds.items()})
        object.__setattr__(self, "idom", _immediate_dominators(order, self.predecessors))

    def dominates(self, a: str, b: str) -> bool:
        """Whether every path from the entry to `b` passes `a` (a block dominates itself)."""
        while b not in (a, self.entry):
            b = self.idom[b]
        return a == b

    def dominators(self, name: str) -> Iterator[str]:
        """`name`, its immediate dominator, and so on up to the entry."""
        yield name
        while name != self.entry:
            name = self.idom[name]
            yield name

    @cached_property
    def loops(self) -> dict[str, frozenset[str]]:
        """Blocks of the natural loop of each header, in reverse postorder of the headers."""
        found: dict[str, frozenset[str]] = {}
        for header in self.order:
            latches = [p for p in self.predecessors[header] if self.dominates(header, p)]
            if latches:
                found[header] = self._natural_loop(header, latches)
        return found

    def _natural_loop(self, header: str, latches: list[str]) -> frozenset[str]:
        body = {header}
        pending = list(latches)
        while pending:
            name = pending.pop()
            if name not in body:
                body.add(name)
                pending.extend(self.predecessors[name])
        return frozenset(body)


def flow_of(function: WideFunction) -> Flow:
    """Dominators and loops of a function without unreachable blocks."""
    return Flow(function.blocks[0].name, function.successors)


def _reverse_postorder(entry: str, successors: Mapping[str, tuple[str, ...]]) -> list[str]:
    order: list[str] = []
    seen = {entry}
    stack = [(entry, iter(successors[entry]))]
    while stack:
        name, targets = stack[-1]
        target = next((t for t in targets if t not in seen), None)
        if target is None:
            order.append(name)
            stack.pop()
        else:
            seen.add(target)
            stack.append((target, iter(successors[target])))
    return order[::-1]


def _immediate_dominators(
    order: list[str], predecessors: Mapping[str, tuple[str, ...]]
) -> dict[str, str]:
    rank = {name: index for index, name in enumerate(order)}
    idom = {order[0]: order[0]}

    def meet(a: str, b: str) -> str:
        while a != b:
            if rank[a] > rank[b]:
                a = idom[a]
            else:
                b = idom[b]
        return a

    changed = True
    while changed:
        changed = False
        for name in order[1:]:
            known = [p for p in predecessors[name] if p in idom]
            best = known[0]
            for other in known[1:]:
                best = meet(best, other)
            if idom.get(name) != best:
                idom[name] = best
                changed = True
    return idom
