"""How often each block of a function runs, estimated."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Set
from types import MappingProxyType
from typing import Final

from vividc.host.once import once_each
from vividc.machine.opcodes import Opcode
from vividc.machine.params import TRAP
from vividc.ssa.analysis.constant_trips import constant_trips
from vividc.ssa.analysis.counters import counter_of
from vividc.ssa.flow import Loop, find_loops, preheader_of
from vividc.ssa.ir import Block, Const, Function, Input, Instr, Ref, Value, is_dimension

UNKNOWN_TRIPS = 16.0
"""Iterations assumed of a loop whose count is only known when it starts."""

SINGLE_LOOP_TRIPS = 256.0
"""The same, of a loop that neither contains another nor is contained in one."""

SHORT_TRIPS = 8.0
"""The same of a loop whose bounds are loaded from memory, like the row of a sparse matrix or the
edges of a node.
"""

EQUAL: Final = 0.995
"""How often sizes are equal that are asked for it: no search pays for loops behind the rest, also
where two sizes are compared and the other loops were made three times as fast (`planning.choose`).
"""

_RAISED: Final = 1e-6
"""How often a branch leads to an exception, however often it runs: whoever computes expects none.
"""

RARE: Final = 0.01
"""Of the runs of a function, those that come to what is rare: sizes that do not agree (`EQUAL`),
exceptions.
"""

_COMPUTED: Final = frozenset({Opcode.ADD, Opcode.SUB, Opcode.MUL, Opcode.SMAX, Opcode.SMIN})
_DEEPEST: Final = 8
"""Operations that a size is followed through."""

_MOST_EVALUATED = 64

_ENDLESS: Final = 1e-12
"""A loop that is left less often has no end."""

NO_CHANCES: Final[Mapping[str, float]] = MappingProxyType({})
NO_TRIPS: Final[Mapping[str, float]] = MappingProxyType({})


def expected_trips(function: Function, hints: Mapping[str, float]) -> dict[str, float]:
    """Iterations of each loop, by header: as hinted, as computed if constant, or assumed.

    The loops are canonical (`normalize.canonical_loops`).
    """
    trips: dict[str, float] = {}
    loops = find_loops(function)
    for loop in loops:
        if loop.header in hints:
            trips[loop.header] = hints[loop.header]
            continue
        constant = constant_trips(function, loop, _MOST_EVALUATED)
        assumed = SINGLE_LOOP_TRIPS if _is_single(loop, loops) else _assumed(function, loop)
        trips[loop.header] = assumed if constant is None else float(constant.iterations)
    return trips


def _assumed(function: Function, loop: Loop) -> float:
    """Iterations assumed of a loop of unknown length in a nest."""
    counter = counter_of(function, loop)
    if counter is None:
        return UNKNOWN_TRIPS
    made = {i.id: i.op for block in function.blocks for i in block.instrs}
    bounds = [value for value in (counter.initial, counter.limit) if isinstance(value, Ref)]
    loaded = bool(bounds) and all(made.get(value.id) is Opcode.LOAD for value in bounds)
    return SHORT_TRIPS if loaded else UNKNOWN_TRIPS


def _is_single(loop: Loop, loops: tuple[Loop, ...]) -> bool:
    others = (other for other in loops if other is not loop)
    return not any(o.header in loop.blocks or loop.header in o.blocks for o in others)


def frequencies(
    function: Function, trips: Mapping[str, float], chances: Mapping[str, float] = NO_CHANCES
) -> dict[str, float]:
    """Runs of each block for one run of the function (Wagner et al. 1994).

    A branch that leaves a loop does so once in as many runs as its loop has iterations; other
    branches go to a block as often as `chances` says of it, or as sizes agree (`EQUAL`), or either
    way equally often. Blocks are all 1 if no branch ends some loop.
    """
    return dict(_solved(function, tuple(trips.items()), tuple(chances.items())))


@once_each
def _solved(
    function: Function,
    known_trips: tuple[tuple[str, float], ...],
    known_chances: tuple[tuple[str, float], ...],
) -> Mapping[str, float]:
    """As `frequencies`: whoever maps a stage asks again and again."""
    trips, chances = dict(known_trips), dict(known_chances)
    loops = find_loops(function)
    made = {item.id: item for block in function.blocks for item in block.instrs}
    raising = {block.name for block in function.blocks if raises(block)}
    return runs_of(
        {
            block.name: dict(_edges(block, loops, trips, chances, made, raising))
            for block in function.blocks
        }
    )


def runs_of(shares: Mapping[str, Mapping[str, float]]) -> dict[str, float]:
    """Runs of each block for one of the first, where `shares` says how often one goes to others.

    One block after the other is taken out, the last first, and what goes to it goes on to what is
    behind it. There is little of either: a matrix of all blocks takes far longer to solve.
    """
    after = {name: dict(targets) for name, targets in shares.items()}
    entry, *others = after
    before: dict[str, dict[str, None]] = {name: {} for name in after}
    for name, targets in after.items():
        for target in targets:
            before[target][name] = None
    taken: list[tuple[str, float, list[tuple[str, float]]]] = []
    for name in reversed(others):
        behind = after.pop(name)
        ends = 1.0 - behind.pop(name, 0.0)
        if ends < _ENDLESS:
            return dict.fromkeys((entry, *others), 1.0)
        sources = [(one, after[one].pop(name)) for one in before.pop(name) if one != name]
        for target, share in behind.items():
            del before[target][name]
            before[target] |= dict.fromkeys(one for one, _ in sources)
            for one, chance in sources:
                after[one][target] = after[one].get(target, 0.0) + chance * share / ends
        taken.append((name, ends, sources))
    ends = 1.0 - after[entry].get(entry, 0.0)
    if ends < _ENDLESS:
        return dict.fromkeys((entry, *others), 1.0)
    runs = {entry: 1.0 / ends}
    for name, ends, sources in reversed(taken):
        runs[name] = sum(runs[one] * chance for one, chance in sources) / ends
    return runs


def entries_of(function: Function, runs: Mapping[str, float]) -> dict[str, float]:
    """How often each loop is entered, by header."""
    return {loop.header: runs[preheader_of(function, loop)] for loop in find_loops(function)}


def rare_blocks(function: Function, runs: Mapping[str, float]) -> frozenset[str]:
    """Blocks that hardly any run of the function comes to, by how often they run; all of a nest, if
    hardly any comes to it.
    """
    entries, nests = entries_of(function, runs), dict(runs)
    for loop in find_loops(function):  # the outermost comes last
        nests |= dict.fromkeys(loop.blocks, entries[loop.header])
    return frozenset(name for name, share in nests.items() if min(share, runs[name]) < RARE)


def _edges(
    block: Block,
    loops: tuple[Loop, ...],
    trips: Mapping[str, float],
    chances: Mapping[str, float],
    made: Mapping[int, Instr],
    raising: Set[str],
) -> Iterator[tuple[str, float]]:
    targets = tuple(dict.fromkeys(block.branch.successors))
    if len(targets) == 1:
        yield targets[0], 1.0
    elif targets:
        first = None
        if not raising.isdisjoint(targets):
            first = _RAISED if targets[0] in raising else 1.0 - _RAISED
        if first is None:
            first = _leaving(block, targets, loops, trips)
        if first is None and targets[1] in chances:
            first = 1.0 - chances[targets[1]]
        if first is None:
            first = chances.get(targets[0])
        if first is None:
            first = chance_of_agreement(block.branch.cond, made)
        first = 0.5 if first is None else first
        yield targets[0], first
        yield targets[1], 1.0 - first


def _leaving(
    block: Block, targets: tuple[str, ...], loops: tuple[Loop, ...], trips: Mapping[str, float]
) -> float | None:
    """How often a branch goes to the first target, of one that leaves a loop."""
    for loop in loops:
        if block.name not in loop.blocks:
            continue
        stays = [target in loop.blocks for target in targets]
        if stays[0] != stays[1]:
            runs = trips[loop.header] + (1.0 if block.name == loop.header else 0.0)
            leave = 1.0 / max(runs, 1.0)
            return 1.0 - leave if stays[0] else leave
    return None


def raises(block: Block) -> bool:
    """Whether a block leaves the kernel by what stands for an exception."""
    return not block.branch.successors and any(one.array.startswith(TRAP) for one in block.instrs)


def chance_of_agreement(condition: Value | None, made: Mapping[int, Instr]) -> float | None:
    """How often a condition holds that asks whether sizes are equal that only the launch knows;
    None: it asks something else. What broadcasts, or is refused, is the exception: numba's loops
    over whole arrays ask whether an operand has one element where the others have more, and a
    kernel of a user's whether its arguments fit. `made`: the function's instructions, by number.
    """
    test = made.get(condition.id) if isinstance(condition, Ref) else None
    if test is None:
        return None
    if test.op in (Opcode.AND, Opcode.OR, Opcode.SELECT):
        return _of_several(test, made)
    if test.op not in (Opcode.ICMP_EQ, Opcode.ICMP_NE):
        return None
    if not all(_is_size(operand, made, _DEEPEST) for operand in test.operands):
        return None
    return EQUAL if test.op is Opcode.ICMP_EQ else 1.0 - EQUAL


def _of_several(test: Instr, made: Mapping[int, Instr]) -> float | None:
    chances = [chance_of_agreement(operand, made) for operand in test.operands]
    if all(chance is None for chance in chances):
        return None
    known = [
        float(operand.word) if isinstance(operand, Const) else 0.5 if chance is None else chance
        for operand, chance in zip(test.operands, chances, strict=True)
    ]
    if test.op is Opcode.SELECT:
        which, one, other = known
        return which * one + (1.0 - which) * other
    if test.op is Opcode.AND:
        return math.prod(known)
    return 1.0 - math.prod(1.0 - chance for chance in known)


def _is_size(value: Value, made: Mapping[int, Instr], depth: int) -> bool:
    """Whether a value is a dimension, or computed from one and constants."""
    if is_dimension(value):
        return True
    op = made.get(value.id) if isinstance(value, Ref) else None
    if op is None or op.op not in _COMPUTED or not depth:
        return False
    parts = [one for one in op.operands if isinstance(one, Ref | Input)]
    return bool(parts) and all(_is_size(one, made, depth - 1) for one in parts)
