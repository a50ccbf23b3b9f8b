"""What a nest does between two runs of its innermost loop becomes one region.

A loop around others is tested in a block of its own, runs some code, enters the inner loop, and
runs some more: three or four regions, each with a region switch, and with words that travel through
constant stores. Here the test is copied to where control comes from, the block before the loop and
the one that repeats it (loop inversion: Muchnick 1997, section 18.5), and what leads to the inner
loop is computed there, too, whether the test lets it or not; loads and stores get a predicate. The
end of one run of the inner loop and the start of the next so share their cycles.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace

from vividc.host.once import changed
from vividc.machine.opcodes import ELEMENTARY, MEMORY, Type
from vividc.ssa.edit import (
    FreshIds,
    defined_types,
    incoming,
    map_values,
    read_values,
    with_blocks,
)
from vividc.ssa.flow import (
    Loop,
    blocks_of_pipelined_loops,
    dominators,
    find_loops,
    pipelined_loops,
    predecessors,
)
from vividc.ssa.ir import Block, Branch, Function, Instr, Phi, Ref, Value
from vividc.ssa.rewrite.diamonds import Arms

_MOST_IN_A_TEST = 16
"""Operations of a loop's header: it is there twice afterwards."""


@dataclass(frozen=True)
class Entries:
    """A function whose outer loops are tested at their ends.

    Attributes
    ----------
    function
        Its pipelined loops are as they were, and what they read has the same ids.
    explained
        The same function with preheaders that compute again what their predecessors have computed
        for them: it tells what the phis of `empty` are, by the other values of an iteration.
    empty
        Preheaders that only have phis.
    """

    function: Function
    explained: Function
    empty: frozenset[str] = frozenset()

    def behind(self, name: str) -> str:
        """The block itself, or the loop's header behind an empty preheader."""
        return self.function.by_name[name].branch.successors[0] if name in self.empty else name


def join_entries(function: Function, read: Mapping[str, Collection[Value]]) -> Entries:
    """Tests outer loops where they are entered and repeated, and prepares inner loops there.

    Parameters
    ----------
    function
        Normalised.
    read
        By header of each pipelined loop: values that it reads besides those that its blocks name.
    """
    headers = [loop.header for loop in find_loops(function)]
    reads = _Reads()
    apart = {loop.header for loop in pipelined_loops(function)}
    values: dict[str, tuple[Phi, ...]] = {}
    for header in headers:
        loop = next(item for item in find_loops(function) if item.header == header)
        ends = None if header in apart else _ends(function, loop, read, reads)
        if ends is not None:
            function = _inverted(function, ends, reads)
            if _is_ready(function, ends):
                function, values[ends.first] = _prepared(function, ends, read, reads)
    blocks = ((function.by_name[name], phis) for name, phis in values.items())
    empty = (replace(b, phis=(*b.phis, *phis), instrs=()) for b, phis in blocks)
    return Entries(with_blocks(function, empty), function, frozenset(values))


class _Reads:
    """Ids of the values that a block reads, found out once for each: most blocks of a long kernel
    stay as they are while one loop after the other is inverted.
    """

    def __init__(self) -> None:
        self._of: dict[int, tuple[Block, frozenset[int]]] = {}
        """By the identity of the block, which is kept so that no other one gets it."""

    def of(self, block: Block) -> frozenset[int]:
        """Of one block, its phis and its branch included."""
        known = self._of.get(id(block))
        if known is None:
            ids = frozenset(v.id for v in read_values(block) if isinstance(v, Ref))
            known = self._of[id(block)] = block, ids
        return known[1]


@dataclass(frozen=True, slots=True)
class _Ends:
    """A loop that its header tests: `first` is the block of an iteration behind it, `after` that
    behind the loop; `sources` enter the header, from outside and from the latch.
    """

    header: Block
    sources: tuple[str, ...]
    first: str
    after: str


def _ends(
    function: Function, loop: Loop, read: Mapping[str, Collection[Value]], reads: _Reads
) -> _Ends | None:
    """The ends of a loop that can be inverted."""
    header = function.by_name[loop.header]
    targets = header.branch.successors
    inside = [name for name in targets if name in loop.blocks]
    outside = [name for name in targets if name not in loop.blocks]
    if len(inside) != 1 or len(outside) != 1 or not _is_small(header):
        return None
    ends = _Ends(header, predecessors(function)[loop.header], inside[0], outside[0])
    own = (header.name, *ends.sources, ends.first, ends.after)
    if len(set(own)) < len(own) or len(ends.sources) != 2:  # noqa: PLR2004 - outside, latch
        return None
    if not blocks_of_pipelined_loops(function).isdisjoint(own):
        return None
    jumps = all(len(function.by_name[s].branch.successors) == 1 for s in ends.sources)
    alone = all(
        predecessors(function)[name] == (header.name,) and not function.by_name[name].phis
        for name in (ends.first, ends.after)
    )
    return ends if jumps and alone and _splits(function, ends, read, reads) else None


def _is_small(header: Block) -> bool:
    expanded = any(instr.op in ELEMENTARY for instr in header.instrs)
    return len(header.instrs) <= _MOST_IN_A_TEST and not expanded


def _splits(
    function: Function, ends: _Ends, read: Mapping[str, Collection[Value]], reads: _Reads
) -> bool:
    """Whether each use of the header's values is in the loop or behind it, and those behind it are
    in straight code, where they can be renamed.
    """
    own = defined_types(ends.header)
    above = dominators(function)
    pipelined = blocks_of_pipelined_loops(function)
    for _, reader, at in _uses(function, own, reads):
        if at == ends.header.name or ends.first in above[at]:
            continue
        if ends.after not in above[at] or reader in pipelined:
            return False
    behind = (loop for loop in read if ends.after in above[loop])
    return not any(isinstance(v, Ref) and v.id in own for loop in behind for v in read[loop])


def _uses(
    function: Function, own: Collection[int], reads: _Reads
) -> Iterator[tuple[int, str, str]]:
    """The value, the block that reads it, and the same block again, or in a phi the one at whose
    end it is read, of each use of values of one's own.
    """
    for block in (one for one in function.blocks if not reads.of(one).isdisjoint(own)):
        for phi in block.phis:
            for source, value in phi.incoming:
                if isinstance(value, Ref) and value.id in own:
                    yield value.id, block.name, source
        for instr in block.instrs:
            for value in instr.operands:
                if isinstance(value, Ref) and value.id in own:
                    yield value.id, block.name, block.name
        for value in block.branch.read:
            if isinstance(value, Ref) and value.id in own:
                yield value.id, block.name, block.name


def _inverted(function: Function, ends: _Ends, reads: _Reads) -> Function:
    """The header's test at the ends of its predecessors; an iteration computes again what it had
    from the header, so that it is known what that is.
    """
    fresh = FreshIds(function)
    header = ends.header
    copies = {source: _copy(header, source, fresh) for source in ends.sources}
    above = dominators(function)
    types = defined_types(header)
    behind = {ident for ident, _, at in _uses(function, types, reads) if ends.after in above[at]}
    renamed: dict[int, Value] = {i: Ref(fresh("behind", i)) for i in types if i in behind}
    blocks = []
    for block in function.blocks:
        if block.name == header.name:
            continue
        edited = block
        if not reads.of(block).isdisjoint(renamed):
            edited = _with_behind(block, above, ends.after, renamed)
        if block.name in copies:
            branch = copies[block.name].branch
            edited = replace(edited, instrs=(*block.instrs, *copies[block.name].instrs))
            edited = replace(edited, branch=branch)
        elif block.name == ends.first:
            again = tuple(instr for instr in header.instrs if instr.op not in MEMORY)
            made = {instr.id for instr in again}
            own = {i: i for i, kind in types.items() if i not in made and kind is not Type.NONE}
            edited = replace(edited, phis=_phis(types, own, copies))
            edited = replace(edited, instrs=(*again, *block.instrs))
        elif block.name == ends.after:
            new = {i: v.id for i, v in renamed.items() if isinstance(v, Ref)}
            edited = replace(edited, phis=_phis(types, new, copies))
        blocks.append(edited)
    return replace(function, blocks=tuple(blocks))


@dataclass(frozen=True, slots=True)
class _Copy:
    """A block's instructions at the end of a predecessor, with what stands for its values."""

    instrs: tuple[Instr, ...]
    branch: Branch
    values: Mapping[int, Value]

    def value(self, ident: int) -> Value:
        """What stands for a value of the block."""
        return self.values[ident]


def _copy(block: Block, source: str, fresh: FreshIds) -> _Copy:
    values: dict[int, Value] = {phi.id: incoming(phi, source) for phi in block.phis}
    values |= {instr.id: Ref(fresh(source, instr.id)) for instr in block.instrs}
    given = map_values(replace(block, phis=()), lambda v: _read(v, values))
    instrs = (changed(instr, id=fresh(source, instr.id)) for instr in given.instrs)
    return _Copy(tuple(instrs), given.branch, values)


def _read(value: Value, values: Mapping[int, Value]) -> Value:
    return values.get(value.id, value) if isinstance(value, Ref) else value


def _phis(
    types: Mapping[int, object], names: Mapping[int, int], copies: Mapping[str, _Copy]
) -> tuple[Phi, ...]:
    """Phis of the values `names`, from old to new id, at the ends of the copies."""
    return tuple(
        Phi(new, types[old], tuple((s, copy.value(old)) for s, copy in copies.items()))  # type: ignore[arg-type]
        for old, new in names.items()
    )


def _with_behind(
    block: Block, above: Mapping[str, Collection[str]], after: str, renamed: Mapping[int, Value]
) -> Block:
    """`block` with renamed values where it reads them behind the loop."""
    phis = tuple(
        changed(
            phi,
            incoming=tuple(
                (source, _read(value, renamed) if after in above[source] else value)
                for source, value in phi.incoming
            ),
        )
        if any(after in above[source] for source, _ in phi.incoming)
        else phi
        for phi in block.phis
    )
    if after in above[block.name]:
        block = map_values(changed(block, phis=()), lambda v: _read(v, renamed))
    return changed(block, phis=phis)


def _is_ready(function: Function, ends: _Ends) -> bool:
    """Whether the block before an inner loop can run at the ends of its predecessors."""
    first = function.by_name[ends.first]
    after = first.branch.successors
    expanded = any(instr.op in ELEMENTARY for instr in first.instrs)
    return len(after) == 1 and after[0] in blocks_of_pipelined_loops(function) and not expanded


def _prepared(
    function: Function, ends: _Ends, read: Mapping[str, Collection[Value]], reads: _Reads
) -> tuple[Function, tuple[Phi, ...]]:
    """What the block before an inner loop does, at the ends of its predecessors as well, and the
    phis that stand for its values then.
    """
    fresh = FreshIds(function)
    first = function.by_name[ends.first]
    copies = {source: _copy(first, source, fresh) for source in ends.sources}
    made = {instr.id for instr in first.instrs}
    others = (block for block in function.blocks if block.name != first.name)
    used = frozenset().union(*(reads.of(block).intersection(made) for block in others))
    used |= {v.id for phi in first.phis for _, v in phi.incoming if isinstance(v, Ref)}
    used |= {value.id for values in read.values() for value in values if isinstance(value, Ref)}
    types = {instr.id: instr.type for instr in first.instrs if instr.id in used}
    changed = [_with_arm(function, s, first.name, c, fresh) for s, c in copies.items()]
    phis = _phis(types, {i: i for i in types}, copies)
    return with_blocks(function, changed), phis


def _with_arm(function: Function, name: str, first: str, copy: _Copy, fresh: FreshIds) -> Block:
    """The block of that name with what it does in case that it branches to `first`."""
    block = function.by_name[name]
    assert block.branch.cond is not None
    arms = Arms(function, fresh, [*block.instrs])
    arm = Block(first, (), copy.instrs, copy.branch)
    arms.add(arm, block.branch.cond, taken=block.branch.target == first)
    return replace(block, instrs=tuple(arms.instrs))
