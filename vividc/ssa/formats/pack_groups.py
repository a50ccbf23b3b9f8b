"""Which operations on float16 and float8 can share an issue slot: isomorphic ones, as of threads.

Superword-level parallelism (Larsen and Amarasinghe 2000), with the twins found by their thread
(`Instr.lane`) where they have one, else by the shape of what they compute.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from vividc.formats import FORMATS, Format
from vividc.machine.lanes import Lane
from vividc.machine.opcodes import OPCODES, Opcode, Type
from vividc.ssa.ir import Block, Const, Function, Instr, Phi, Ref, Value

_ROUNDS: Final = 4
"""How far back the shapes of two operations are compared."""
FORMAT_OF: Final = {
    info.opcode: FORMATS[info.result.value]
    for info in OPCODES.values()
    if info.result in (Type.F16, Type.E4M3, Type.E5M2)
}
"""The format of each operation whose result is a number of one."""
_ARITHMETIC: Final = frozenset(
    opcode
    for opcode in FORMAT_OF
    if opcode.value.partition(".")[0]
    in ("fadd", "fsub", "fmul", "fma", "fms", "fnma", "fmin", "fmax")
)
_BITWISE: Final = frozenset({Opcode.XOR, Opcode.AND})
"""With a constant: negation and absolute value, lane by lane."""
_PASSED: Final = {Opcode.XOR: 0, Opcode.AND: 0, Opcode.SELECT: 1}
"""First operand that the result may be a number of the format of."""


@dataclass(frozen=True, slots=True)
class Group:
    """Values that share a word: member j is lane j.

    Attributes
    ----------
    members
        Ids of the instructions or phis, all of `block`.
    opcode
        What the instructions do; None of phis.
    format
        Of the lanes.
    """

    members: tuple[int, ...]
    block: str
    opcode: Opcode | None
    format: Format


def find_groups(function: Function) -> tuple[Group, ...]:
    """Groups that may be made, phis first, then in the order in which they compute."""
    if not any(i.op in _ARITHMETIC for block in function.blocks for i in block.instrs):
        return ()
    return tuple(_Finder(function).groups())


class _Finder:
    def __init__(self, function: Function) -> None:
        self.function = function
        self.definitions: dict[int, Phi | Instr] = {
            item.id: item for block in function.blocks for item in block.items
        }
        self.formats = self._formats()
        self.colours = self._colours()
        self.lane_of: dict[int, tuple[int, int]] = {}
        self.made: list[Group] = []

    def groups(self) -> Iterator[Group]:
        """All groups; members are in the order of their operands' lanes."""
        for block in self.function.blocks:
            phis = [phi for phi in block.phis if phi.id in self.formats]
            self._collect(block, None, phis)
        for block in self.function.blocks:
            levels = _levels(block)
            rows: dict[tuple[int, Opcode], list[Phi | Instr]] = defaultdict(list)
            for instr in block.instrs:
                if self._packs(instr):
                    level = levels[instr.id] if instr.lane is None else 0
                    rows[level, instr.opcode].append(instr)
            for (_, opcode), members in sorted(rows.items(), key=lambda row: row[0][0]):
                self._collect(block, opcode, members)
        yield from self.made

    def _packs(self, instr: Instr) -> bool:
        if instr.op in _ARITHMETIC:
            return True
        if instr.id not in self.formats or instr.op not in _PASSED:
            return False
        return instr.op not in _BITWISE or isinstance(instr.operands[1], Const)

    def _collect(self, block: Block, opcode: Opcode | None, items: Sequence[Phi | Instr]) -> None:
        """Group twins among phis, or among instructions of one opcode."""
        twins: dict[object, list[Phi | Instr]] = defaultdict(list)
        for item in items:
            twins[self._key(item)].append(item)
        for members in twins.values():
            fmt = self.formats[members[0].id]
            ordered = sorted(members, key=self._order)
            for first in range(0, len(ordered), fmt.lanes):
                chunk = tuple(item.id for item in ordered[first : first + fmt.lanes])
                if len(chunk) > 1:
                    self.lane_of |= {m: (len(self.made), lane) for lane, m in enumerate(chunk)}
                    self.made.append(Group(chunk, block.name, opcode, fmt))

    def _key(self, item: Phi | Instr) -> object:
        fmt = self.formats[item.id].name
        lane = self._lane(item)
        return (fmt, self.colours[item.id]) if lane is None else (fmt, lane.origin, lane.part)

    def _order(self, item: Phi | Instr) -> tuple[object, ...]:
        """By thread, or by the lanes of what is read; the sort keeps the program's order else."""
        lane = self._lane(item)
        if lane is not None:
            return (lane.thread,)
        places = (self.lane_of.get(v.id) for v in _read(item) if isinstance(v, Ref))
        return min((place for place in places if place is not None), default=(math.inf, 0))

    def _lane(self, item: Phi | Instr) -> Lane | None:
        if isinstance(item, Instr):
            return item.lane
        seen, waiting = {item.id}, [item]
        while waiting:  # a phi has the lane of what it carries, through other phis too
            for _, value in waiting.pop().incoming:
                definition = self.definitions.get(value.id) if isinstance(value, Ref) else None
                if isinstance(definition, Instr) and definition.lane is not None:
                    return definition.lane
                if isinstance(definition, Phi) and definition.id not in seen:
                    seen.add(definition.id)
                    waiting.append(definition)
        return None

    def _formats(self) -> dict[int, Format]:
        """Formats of the values that are numbers of one, and fit its lanes whatever happens."""
        known = {
            i.id: FORMAT_OF[i.op]
            for i in self.definitions.values()
            if isinstance(i, Instr) and i.op in FORMAT_OF
        }
        changed = True
        while changed:
            changed = False
            for item in self.definitions.values():
                if item.id in known:
                    continue
                near = [known[v.id] for v in _passed(item) if isinstance(v, Ref) and v.id in known]
                if near:
                    known[item.id] = near[0]
                    changed = True
        return self._fitting(known)

    def _fitting(self, known: dict[int, Format]) -> dict[int, Format]:
        """Without values that may have bits above the lane, and what they reach."""
        changed = True
        while changed:
            misfits = [
                ident
                for ident, fmt in known.items()
                if not all(self._fits(value, fmt, known) for value in self._sources(ident))
            ]
            for ident in misfits:
                del known[ident]
            changed = bool(misfits)
        return known

    def _sources(self, ident: int) -> tuple[Value, ...]:
        """Values that the value may be; none of an operation that makes a number."""
        item = self.definitions[ident]
        return () if isinstance(item, Instr) and item.op in FORMAT_OF else _passed(item)

    def _fits(self, value: Value, fmt: Format, known: dict[int, Format]) -> bool:
        if isinstance(value, Const):
            return value.word <= fmt.mask
        if not isinstance(value, Ref):
            return False
        if value.id in known:
            return known[value.id] is fmt
        definition = self.definitions[value.id]
        if not isinstance(definition, Instr):
            return False
        if definition.op is Opcode.LOAD:
            return 8 * definition.width <= fmt.bits and not definition.signed
        masked = definition.op is Opcode.AND and isinstance(definition.operands[1], Const)
        return masked and self._fits(definition.operands[1], fmt, known)

    def _colours(self) -> dict[int, int]:
        """Equal for values computed alike from what is loaded, given and carried."""
        numbers: dict[object, int] = {}

        def number(key: object) -> int:
            return numbers.setdefault(key, len(numbers))

        items = self.definitions.values()
        colours = {item.id: number(_kind(item)) for item in items}
        for _ in range(_ROUNDS):
            before = colours
            colours = {
                item.id: number(
                    (before[item.id], *(_colour(value, before) for value in _read(item)))
                )
                for item in items
            }
        return colours


def _passed(item: Phi | Instr) -> tuple[Value, ...]:
    """Operands of which the result may be one, or have the bits."""
    if isinstance(item, Phi):
        return tuple(value for _, value in item.incoming)
    return item.operands[_PASSED[item.op] :] if item.op in _PASSED else ()


def _read(item: Phi | Instr) -> tuple[Value, ...]:
    if isinstance(item, Phi):
        return tuple(value for _, value in item.incoming)
    return item.operands


def _kind(item: Phi | Instr) -> object:
    if isinstance(item, Phi):
        return ("phi", len(item.incoming))
    return (item.op, item.array, item.shift, item.width)


def _colour(value: Value, colours: dict[int, int]) -> object:
    return colours[value.id] if isinstance(value, Ref) else type(value).__name__


def _levels(block: Block) -> dict[int, int]:
    """Longest way to each instruction within the block."""
    levels: dict[int, int] = {}
    for instr in block.instrs:
        before = [levels[v.id] for v in instr.operands if isinstance(v, Ref) and v.id in levels]
        levels[instr.id] = max(before, default=-1) + 1
    return levels
