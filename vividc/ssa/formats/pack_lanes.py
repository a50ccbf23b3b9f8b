"""Operations on float16 and float8 of several threads in the lanes of one, where that is fewer.

A group's operands are packed, and results that something else reads are unpacked: by operations,
which count. A group stays if the function has fewer operations with it, those in loops weighing
more. Every lane computes what its operation did, so every word is what it was.
"""

from __future__ import annotations

import heapq
import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from vividc.formats import Format, join
from vividc.machine.opcodes import MEMORY, Opcode, Type
from vividc.ssa.edit import map_values, next_id
from vividc.ssa.flow import find_loops
from vividc.ssa.formats.pack_groups import Group, find_groups
from vividc.ssa.ir import Block, Const, Function, Instr, Phi, Ref, Value
from vividc.ssa.rewrite.dead import remove_unused
from vividc.ssa.rewrite.hoist import hoist_invariants

_LOOP_WEIGHT: Final = 16
"""Iterations that a loop is taken to have."""
_FEW: Final = 48
"""So many groups are tried one by one, more only with those they read."""
_START, _END = -1.0, math.inf
_PAIR: Final = 2


def pack_lanes(function: Function) -> Function:
    """Pack what pays by count; the same object if nothing does."""
    groups = find_groups(function)
    if not groups:
        return function
    chosen = _profitable(function, _orderly(function, list(groups)))
    best = _packed(function, chosen) if chosen else None
    return function if best is None else best


def _orderly(function: Function, groups: list[Group]) -> list[Group]:
    """Without groups that would wait for themselves."""
    if _packed(function, groups) is not None:
        return groups
    kept: list[Group] = []
    for group in groups:
        if _packed(function, [*kept, group]) is not None:
            kept.append(group)
    return kept


def _profitable(function: Function, groups: list[Group]) -> list[Group]:
    """Drop groups as long as that saves operations; all, if packing saves none."""
    cost = _cost(_packed(function, groups))
    singles = [[group] for group in groups] if len(groups) <= _FEW else []
    for part in [*_components(function, groups), *singles]:
        rest = [group for group in groups if group not in part]
        if len(rest) < len(groups):
            without = _cost(_packed(function, rest))
            if without <= cost:
                groups, cost = rest, without
    return groups if cost < _cost(function) else []


def _components(function: Function, groups: list[Group]) -> list[list[Group]]:
    """Groups that read one another."""
    owner = {member: number for number, group in enumerate(groups) for member in group.members}
    label = list(range(len(groups)))

    def root(number: int) -> int:
        while label[number] != number:
            number = label[number]
        return number

    for block in function.blocks:
        for item in block.items:
            if item.id not in owner:
                continue
            for value in _operands(item):
                if isinstance(value, Ref) and value.id in owner:
                    label[root(owner[value.id])] = root(owner[item.id])
    parts: dict[int, list[Group]] = defaultdict(list)
    for number, group in enumerate(groups):
        parts[root(number)].append(group)
    return list(parts.values())


def _operands(item: Phi | Instr) -> tuple[Value, ...]:
    return tuple(v for _, v in item.incoming) if isinstance(item, Phi) else item.operands


def _cost(function: Function | None) -> float:
    """Operations, weighed by the loops around them."""
    if function is None:
        return math.inf
    depth: dict[str, int] = defaultdict(int)
    for loop in find_loops(function):
        for name in loop.blocks:
            depth[name] += 1
    blocks = function.blocks
    return math.fsum(len(b.instrs) * _LOOP_WEIGHT ** depth[b.name] for b in blocks)


def _packed(function: Function, groups: Sequence[Group]) -> Function | None:
    """The function with these groups; None if a group would have to wait for itself."""
    if not groups:
        return function
    built = _Packer(function, groups).built()
    return None if built is None else remove_unused(hoist_invariants(remove_unused(built)))


class _Packer:
    def __init__(self, function: Function, groups: Sequence[Group]) -> None:
        self.function, self.groups = function, groups
        self.definitions: dict[int, Phi | Instr] = {}
        self.home: dict[int, str] = {}
        self.place: dict[int, float] = {}
        for block in function.blocks:
            for item in block.items:
                self.definitions[item.id] = item
                self.home[item.id] = block.name
            self.place |= {instr.id: float(n) for n, instr in enumerate(block.instrs)}
        self.lane_of = {
            member: (number, lane)
            for number, group in enumerate(groups)
            for lane, member in enumerate(group.members)
        }
        first = next_id(function)
        self.vector = [first + number for number in range(len(groups))]
        self.next = first + len(groups)
        self.made: dict[str, list[tuple[float, Instr]]] = defaultdict(list)
        self.cache: dict[object, Value] = {}

    def built(self) -> Function | None:
        """The function, operations in an order in which each comes after what it reads."""
        phis = {block.name: self._phis(block) for block in self.function.blocks}
        for number, group in enumerate(self.groups):
            if group.opcode is not None:
                self._pack(number, group)
        blocks = []
        for block in self.function.blocks:
            instrs = [
                (self.place[instr.id], self._scalar(instr, block.name))
                for instr in block.instrs
                if instr.id not in self.lane_of
            ]
            branch = self._branch(block)
            ordered = _in_order([*instrs, *self.made[block.name]])
            if ordered is None:
                return None
            blocks.append(replace(branch, phis=phis[block.name], instrs=ordered))
        return replace(self.function, blocks=tuple(blocks))

    def _phis(self, block: Block) -> tuple[Phi, ...]:
        kept = []
        for phi in block.phis:
            if phi.id not in self.lane_of:
                incoming = ((p, self._read(v, p, _END)) for p, v in phi.incoming)
                kept.append(replace(phi, incoming=tuple(incoming)))
        for number, group in enumerate(self.groups):
            if group.opcode is None and group.block == block.name:
                kept.append(self._phi(number, group))
        return tuple(kept)

    def _phi(self, number: int, group: Group) -> Phi:
        members = [item for item in map(self.definitions.get, group.members)]
        rows = [dict(item.incoming) for item in members if isinstance(item, Phi)]
        incoming = tuple(
            (pred, self._word([row[pred] for row in rows], group.format, pred, _END))
            for pred in rows[0]
        )
        loc = next(item.loc for item in members if item is not None)
        return Phi(self.vector[number], Type.I32, incoming, loc)

    def _pack(self, number: int, group: Group) -> None:
        """The operation of a group, and what its operands take."""
        members = [self.definitions[member] for member in group.members]
        instrs = [item for item in members if isinstance(item, Instr)]
        place = max(self.place[instr.id] for instr in instrs)
        columns = list(zip(*(instr.operands for instr in instrs), strict=True))
        opcode, operands = instrs[0].op, []
        if opcode is Opcode.SELECT:
            chosen = columns.pop(0)
            if len(set(chosen)) == 1:
                operands.append(self._read(chosen[0], group.block, place))
            else:
                opcode = Opcode(f"select.x{group.format.lanes}")
                operands.append(self._word(chosen, group.format, group.block, place))
        operands += [self._word(column, group.format, group.block, place) for column in columns]
        packed = replace(
            instrs[0], id=self.vector[number], op=opcode, operands=tuple(operands), lane=None
        )
        self.made[group.block].append((place, packed))

    def _scalar(self, instr: Instr, block: str) -> Instr:
        """An instruction that stays by itself, with the lanes it reads unpacked."""
        first = instr.operands[0] if instr.operands else None
        if isinstance(first, Ref) and first.id in self.lane_of:
            number, lane = self.lane_of[first.id]
            fmt = self.groups[number].format
            if instr.op is Opcode(f"fpext.{fmt.name}"):
                unpack = Opcode(f"unpack.{fmt.name}x{fmt.lanes}")
                operands = (Ref(self.vector[number]), Const(lane))
                return replace(instr, op=unpack, operands=operands)
        place = self.place[instr.id]
        return replace(
            instr, operands=tuple(self._read(value, block, place) for value in instr.operands)
        )

    def _branch(self, block: Block) -> Block:
        """The block without instructions, its branch reading what was unpacked."""
        bare = replace(block, phis=(), instrs=())
        return map_values(bare, lambda value: self._read(value, block.name, _END))

    def _read(self, value: Value, block: str, place: float) -> Value:
        """A value by itself, in a block: the number of a group's lane is extracted there once."""
        if not isinstance(value, Ref) or value.id not in self.lane_of:
            return value
        number, lane = self.lane_of[value.id]
        group = self.groups[number]
        if block == group.block:
            members = (self.place.get(member, _START) for member in group.members)
            place = max(members)
        else:
            place = _START
        opcode = Opcode(f"extract.x{group.format.lanes}")
        return self._made(block, place, opcode, (Ref(self.vector[number]), Const(lane)))

    def _word(self, values: Sequence[Value], fmt: Format, block: str, place: float) -> Value:
        """The word whose lanes are these values."""
        lanes = [self.lane_of.get(v.id) if isinstance(v, Ref) else None for v in values]
        if lanes[0] is not None and lanes == [(lanes[0][0], n) for n in range(len(lanes))]:
            return Ref(self.vector[lanes[0][0]])
        words = [value.word for value in values if isinstance(value, Const)]
        if len(words) == len(values):
            return Const(join(fmt, words))
        sources = [self._rounded(value, fmt) for value in values]
        numbers = [source for source in sources if source is not None]
        if len(numbers) == len(values):
            return self._packed_numbers(numbers, fmt, block, place)
        return self._merged([self._read(v, block, place) for v in values], fmt, block, place)

    def _rounded(self, value: Value, fmt: Format) -> Value | None:
        """The float32 number that a value is rounded from."""
        item = self.definitions.get(value.id) if isinstance(value, Ref) else None
        if isinstance(item, Instr) and item.op is Opcode(f"fptrunc.{fmt.name}"):
            return item.operands[0]
        return None

    def _packed_numbers(
        self, numbers: Sequence[Value], fmt: Format, block: str, place: float
    ) -> Value:
        numbers = [*numbers, *[Const(0)] * (len(numbers) % _PAIR)]
        kind = f"{fmt.name}x{fmt.lanes}"
        word = self._made(block, place, Opcode(f"pack.{kind}"), tuple(numbers[:_PAIR]))
        if len(numbers) == _PAIR:
            return word
        return self._made(block, place, Opcode(f"pack_high.{kind}"), (*numbers[_PAIR:], word))

    def _merged(self, values: list[Value], fmt: Format, block: str, place: float) -> Value:
        """Neighbours first, then pairs of them."""
        values = values + [Const(0)] * (len(values) % _PAIR)
        lanes = fmt.lanes
        while len(values) > 1:
            opcode = Opcode(f"merge.x{lanes}")
            pairs = zip(values[::_PAIR], values[1::_PAIR], strict=True)
            values = [self._made(block, place, opcode, pair) for pair in pairs]
            lanes //= _PAIR
        return values[0]

    def _made(self, block: str, place: float, opcode: Opcode, operands: tuple[Value, ...]) -> Value:
        """A new operation, or the same one made in this block before."""
        key = (block, opcode, operands)
        if key not in self.cache:
            kind = Type.F32 if opcode.value.startswith("unpack.") else Type.I32
            instr = Instr(self.next, opcode, kind, operands)
            self.cache[key] = Ref(self.next)
            self.next += 1
            self.made[block].append((place, instr))
        return self.cache[key]


def _in_order(items: list[tuple[float, Instr]]) -> tuple[Instr, ...] | None:
    """Instructions, each after what it reads, else by place; accesses to memory keep their order.

    None: some wait for one another.
    """
    by_id = {instr.id: (place, number, instr) for number, (place, instr) in enumerate(items)}
    waits: dict[int, set[int]] = {}
    last: int | None = None
    for _, _, instr in sorted(by_id.values(), key=lambda entry: entry[:2]):
        reads = {v.id for v in instr.operands if isinstance(v, Ref) and v.id in by_id}
        if instr.op in MEMORY:
            reads |= set() if last is None else {last}
            last = instr.id
        waits[instr.id] = reads
    readers: dict[int, list[int]] = defaultdict(list)
    for ident, reads in waits.items():
        for read in reads:
            readers[read].append(ident)
    ready = [(by_id[i][0], by_id[i][1], i) for i, reads in waits.items() if not reads]
    heapq.heapify(ready)
    done: list[Instr] = []
    while ready:
        ident = heapq.heappop(ready)[2]
        done.append(by_id[ident][2])
        for reader in readers[ident]:
            waits[reader].discard(ident)
            if not waits[reader]:
                heapq.heappush(ready, (by_id[reader][0], by_id[reader][1], reader))
    return tuple(done) if len(done) == len(by_id) else None
