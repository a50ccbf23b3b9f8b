"""Divisors that several quotients have in common are prepared once: `expand.divide.prepared`.

A divisor that a loop does not change is prepared before it, and each iteration pays for the rest
only; so do divisions by one divisor in an iteration. Others stay
`fdiv`s, whose expansion is shorter in latency from a divisor that is there last.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from typing import Final

import networkx as nx

from vividc.dfg.expand.divide import (
    Divisor,
    SoonDivisor,
    prepared,
    prepared_soon,
    quotient_by,
    quotient_soon_by,
)
from vividc.machine.opcodes import OPCODES, Opcode, Type
from vividc.ssa.edit import FreshIds
from vividc.ssa.flow import find_loops, pipelined_loops
from vividc.ssa.ir import Block, Const, Function, Instr, Phi, Ref, Value
from vividc.ssa.rewrite.hoist import hoist_invariants
from vividc.ssa.rewrite.number_values import number_values

_IN_ITERATION: Final = 2
"""Divisions by one divisor in an iteration that changes it: each saves 35 of 46 operations, the
first costs 24.
"""

_SHORT: Final = 10
"""Instructions of a loop with one division whose 20 operations instead of 11 are free, as 16 PEs
have room for them twice, and more PEs more so, while its first quotient is there 12 cycles sooner.
"""

_AT_ONCE: Final = 4
"""Divisions outside all loops, where their divisors are prepared too: fewer are done as soon one by
one, each by a divisor that may be there last (37 cycles from it instead of 43).
"""

_CROWD: Final = 8
"""Divisions in a straight region, at most, that are worth 20 operations instead of 11 where they
do not wait for each other: more fill the cycles that they save, and take registers (40 at the end
of a tile of covariance).
"""

_HIDING, _BESIDE = 3, 4
"""Of a recurrence that hides another one at least, a division, a phi and an operation (38 cycles),
and of that one at most, two operations of four cycles (38 with 30 of a quotient).
"""


def share_divisors(function: Function) -> Function:
    """Write divisions whose divisor is worth it as its preparation, which leaves all loops that it
    may, and what remains to do for each dividend.

    Bit for bit as `expand.divide.divide`. Divisions on a recurrence that would take longer stay,
    and those by constants.
    """
    sharing = _Sharing(function)
    shared = sharing.shared()
    if not shared:
        return function
    fresh = FreshIds(function)
    blocks = [
        _rewritten(block, shared, sharing, fresh)
        if any(i.id in shared for i in block.instrs)
        else block
        for block in function.blocks
    ]
    return number_values(hoist_invariants(replace(function, blocks=tuple(blocks))))


class _Way(Enum):
    """How a division is written in halves."""

    IN_ITERATION = "both in few operations"
    PREPARED = "the divisor soon, the quotient in few operations"
    SOON = "both soon"


class _Sharing:
    """Which divisions of a function share their divisor with others, and how."""

    def __init__(self, function: Function) -> None:
        self._function = function
        self._loops = {loop.header: loop.blocks for loop in pipelined_loops(function)}
        """Blocks of each modulo-scheduled loop by its header."""
        self._home = {block.name: block.name for block in function.blocks}
        for header, blocks in self._loops.items():
            self._home |= dict.fromkeys(blocks, header)

    def shared(self) -> dict[int, _Way]:
        """Ids of the divisions."""
        divisions = [*self._divisions()]
        together = Counter((home, instr.operands[1]) for home, instr in divisions)
        fixed = {instr.id for home, instr in divisions if self._is_fixed(home, instr)}
        crowds = Counter(home for home, instr in divisions if instr.id in fixed)
        homes = dict.fromkeys(home for home, _ in divisions)
        waiting = {ident for home in homes for ident in self._waiting(home)}
        chained = {ident for home in homes for ident in self._chained(home)}
        shared: dict[int, _Way] = {}
        for home, instr in divisions:
            way = _Way.PREPARED
            if home not in self._loops:
                least = 1 if home in self._around else _AT_ONCE
                pays = instr.id in fixed and crowds[home] >= least
                if crowds[home] <= _CROWD or instr.id in chained:
                    way = _Way.SOON
            elif instr.id in fixed:
                pays = True
                if instr.id in waiting or self._is_short(home):
                    way = _Way.SOON
            else:
                shares = together[home, instr.operands[1]] >= _IN_ITERATION
                pays, way = shares and instr.id not in waiting, _Way.IN_ITERATION
            if pays:
                shared[instr.id] = way
        return shared

    def _is_short(self, header: str) -> bool:
        """Whether a loop has one division, and little else."""
        instrs = [i for name in self._loops[header] for i in self._function.by_name[name].instrs]
        is_one = sum(instr.op is Opcode.FDIV for instr in instrs) == 1
        return is_one and len(instrs) <= _SHORT

    def _chained(self, home: str) -> Iterator[int]:
        """Ids of the divisions of a block whose dividends come of others of it."""
        behind: set[int] = set()
        for instr in self._function.by_name[home].instrs:
            comes_of = any(isinstance(v, Ref) and v.id in behind for v in instr.operands)
            if instr.op is Opcode.FDIV and comes_of:
                yield instr.id
            if instr.op is Opcode.FDIV or comes_of:
                behind.add(instr.id)

    def is_root(self, divisor: Value) -> bool:
        """Whether it is one, which cannot be subnormal."""
        if not isinstance(divisor, Ref):
            return False
        found = self._function.definitions[divisor.id]
        return isinstance(found, Instr) and found.op is Opcode.SQRT

    def _divisions(self) -> Iterator[tuple[str, Instr]]:
        """Those by no constant, each with the region that it is in."""
        for block in self._function.blocks:
            for instr in block.instrs:
                if instr.op is not Opcode.FDIV:
                    continue
                if not isinstance(self._function.settled(instr.operands[1]), Const):
                    yield self._home[block.name], instr

    @cached_property
    def _around(self) -> Mapping[str, frozenset[str]]:
        """Of each block the blocks of the innermost loop that it is in."""
        found: dict[str, frozenset[str]] = {}
        for loop in find_loops(self._function):
            for name in loop.blocks:
                found.setdefault(name, loop.blocks)
        return found

    def _is_fixed(self, home: str, instr: Instr) -> bool:
        """Whether the divisor is the same each time that the innermost loop around comes by."""
        divisor = instr.operands[1]
        if not isinstance(divisor, Ref):
            return True
        within = self._around.get(home, frozenset(self._home))
        return self._function.block_of[divisor.id] not in within

    def _waiting(self, home: str) -> Iterator[int]:
        """Ids of what is on a recurrence of a loop and would make it longer in few operations.

        A recurrence is not made longer than another that finds the divisor by a division of its
        own, which takes 37 cycles, if its one division (30 from the dividend) has few operations
        beside it.
        """
        parts = [part for part in self._recurrences(home) if len(part) > 1]
        divisions = {instr.id: instr.operands[1] for at, instr in self._divisions() if at == home}
        slow = {
            divisor.id
            for part in parts
            if len(part) >= _HIDING
            for division in part & divisions.keys()
            if isinstance(divisor := divisions[division], Ref) and divisor.id in part
        }
        for part in parts:
            inside = part & divisions.keys()
            by = {v.id if isinstance(v := divisions[one], Ref) else None for one in inside}
            is_hidden = len(inside) == 1 and by <= slow - part and len(part) <= _BESIDE
            if not is_hidden:
                yield from part

    def _recurrences(self, home: str) -> Iterator[set[int]]:
        """Ids of what depends on each other, apart from dependences through memory."""
        graph: nx.DiGraph[int] = nx.DiGraph()
        for name in self._loops.get(home, ()):
            for item in self._function.by_name[name].items:
                values = (
                    tuple(value for _, value in item.incoming)
                    if isinstance(item, Phi)
                    else item.operands
                )
                graph.add_edges_from((v.id, item.id) for v in values if isinstance(v, Ref))
        yield from nx.strongly_connected_components(graph)


def _rewritten(
    block: Block, shared: Mapping[int, _Way], sharing: _Sharing, fresh: FreshIds
) -> Block:
    """The block with these divisions in halves; each divisor is prepared where it is first met."""
    known: dict[Value, Divisor[Value]] = {}
    soon: dict[Value, SoonDivisor[Value]] = {}
    instrs: list[Instr] = []
    for instr in block.instrs:
        way = shared.get(instr.id)
        if way is None:
            instrs.append(instr)
            continue
        emit = _Emitter(instr, fresh, instrs)
        dividend, divisor = instr.operands
        normal = sharing.is_root(divisor)
        if way is _Way.SOON:
            if divisor not in soon:
                soon[divisor] = prepared_soon(emit, divisor, normal=normal)
            quotient_soon_by(emit, dividend, soon[divisor])
        else:
            if divisor not in known and way is _Way.PREPARED:
                known[divisor] = prepared_soon(emit, divisor, exact=True, normal=normal)
            elif divisor not in known:
                known[divisor] = prepared(emit, divisor)
            quotient_by(emit, dividend, known[divisor])
        instrs[-1] = replace(instrs[-1], id=instr.id, type=instr.type)
    return replace(block, instrs=tuple(instrs))


@dataclass
class _Emitter:
    """Writes what stands for a division; all of a thread's copy are parts of it."""

    division: Instr
    fresh: FreshIds
    instrs: list[Instr]
    parts: int = 0

    def __call__(self, opcode: Opcode, *operands: Value | int) -> Value:
        """The operation `opcode` on `operands`."""
        result = OPCODES[opcode].result
        lane = self.division.lane
        made = Instr(
            self.fresh(),
            opcode,
            Type.F32 if result is Type.ANY else result,
            tuple(Const(v) if isinstance(v, int) else v for v in operands),
            loc=self.division.loc,
            lane=None if lane is None else replace(lane, part=lane.part + self.parts),
        )
        self.parts += 1
        self.instrs.append(made)
        return Ref(made.id)
