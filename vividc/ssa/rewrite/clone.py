"""Copies of groups of blocks, with fresh ids and names, wired into the function around them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace

from vividc.ssa.edit import FreshIds, defined_types, map_values
from vividc.ssa.ir import Block, Branch, Function, Phi, Ref, Value
from vividc.ssa.rewrite.repair import repair


@dataclass(frozen=True)
class Clone:
    """A copy of some blocks.

    Attributes
    ----------
    blocks
        The copies, in the order of the originals.
    names
        Name of each original's copy.
    values
        What stands in the copy for each id that the originals define; ids given by the caller
        included.
    """

    blocks: tuple[Block, ...]
    names: Mapping[str, str]
    values: Mapping[int, Value]

    def value(self, value: Value) -> Value:
        """`value` as the copy sees it."""
        return self.values.get(value.id, value) if isinstance(value, Ref) else value


def clone_blocks(
    function: Function,
    names: Collection[str],
    *,
    given: Mapping[int, Value] | None = None,
    stem: str = "copy",
    ids: Callable[[], int] | None = None,
) -> Clone:
    """Copies blocks; `function` itself is not changed.

    Edges between the blocks lead between the copies; edges out of them keep their targets, whose
    phis the caller extends (`extend_phis`). Inputs of phis from outside keep their blocks.

    Parameters
    ----------
    names
        The blocks to copy.
    given
        Values that stand for ids in the copy. A phi with a value here is left out of the copy, so
        that a loop's header phis can be replaced by the values of one iteration.
    stem
        The copy of block b is called b.stem, with a number if need be.
    ids
        Gives ids that nothing has; None: the function has all that are in use.
    """
    given = dict(given or {})
    originals = [block for block in function.blocks if block.name in names]
    renamed = _fresh_names(function, originals, stem)
    values: dict[int, Value] = dict(given)
    fresh = FreshIds(function) if ids is None else ids
    for block in originals:
        for ident in defined_types(block):
            if ident not in given:
                values[ident] = Ref(fresh())
    blocks = tuple(_copy(block, renamed, values, given) for block in originals)
    return Clone(blocks, renamed, values)


def extend_phis(function: Function, clone: Clone) -> Function:
    """`function` with the copies appended, and an input for each edge from a copy in the phis of
    the blocks around.

    A copy hands on what its original hands to the same target.
    """
    original = {new: old for old, new in clone.names.items()}
    sources = {
        target: [original[b.name] for b in clone.blocks if target in b.branch.successors]
        for target in _targets_outside(clone)
    }
    blocks = tuple(
        replace(block, phis=tuple(_extended(phi, sources[block.name], clone) for phi in block.phis))
        if block.name in sources
        else block
        for block in function.blocks
    )
    return replace(function, blocks=(*blocks, *clone.blocks))


def repair_uses(function: Function, names: Collection[str], clones: Collection[Clone]) -> Function:
    """Restores SSA after the blocks `names` were copied and control may come from any copy.

    A use elsewhere of a value that the originals define reads whichever of the original and its
    copies ran last; phis are placed where several may have.
    """
    inside = set(names)
    for clone in clones:
        inside.update(clone.names.values())
    used = _used_elsewhere(function, inside)
    for block in function.blocks:
        if block.name not in names:
            continue
        for ident, type_ in defined_types(block).items():
            if ident in used:
                definitions = _definitions(ident, block.name, clones)
                function = repair(function, ident, type_, definitions)
    return function


def redirected(branch: Branch, names: Mapping[str, str]) -> Branch:
    """`branch` with its targets renamed."""
    target, otherwise = branch.target, branch.otherwise
    return replace(
        branch,
        target=None if target is None else names.get(target, target),
        otherwise=None if otherwise is None else names.get(otherwise, otherwise),
    )


def _fresh_names(function: Function, originals: list[Block], stem: str) -> dict[str, str]:
    taken = {block.name for block in function.blocks}
    renamed: dict[str, str] = {}
    for block in originals:
        candidate, number = f"{block.name}.{stem}", 0
        while candidate in taken:
            number += 1
            candidate = f"{block.name}.{stem}{number}"
        taken.add(candidate)
        renamed[block.name] = candidate
    return renamed


def _copy(
    block: Block,
    renamed: Mapping[str, str],
    values: Mapping[int, Value],
    given: Mapping[int, Value],
) -> Block:
    def change(value: Value) -> Value:
        return values.get(value.id, value) if isinstance(value, Ref) else value

    kept = replace(
        block,
        phis=tuple(phi for phi in block.phis if phi.id not in given),
        instrs=tuple(instr for instr in block.instrs if instr.id not in given),
    )
    mapped = map_values(kept, change)
    phis = tuple(
        replace(
            phi,
            id=_new_id(values, phi.id),
            incoming=tuple((renamed.get(name, name), value) for name, value in phi.incoming),
        )
        for phi in mapped.phis
    )
    instrs = tuple(replace(instr, id=_new_id(values, instr.id)) for instr in mapped.instrs)
    return Block(renamed[block.name], phis, instrs, redirected(mapped.branch, renamed))


def _new_id(values: Mapping[int, Value], ident: int) -> int:
    value = values[ident]
    assert isinstance(value, Ref)
    return value.id


def _targets_outside(clone: Clone) -> tuple[str, ...]:
    copies = set(clone.names.values())
    targets = (target for block in clone.blocks for target in block.branch.successors)
    return tuple(dict.fromkeys(target for target in targets if target not in copies))


def _extended(phi: Phi, sources: list[str], clone: Clone) -> Phi:
    added = tuple(
        (clone.names[name], clone.value(value)) for name, value in phi.incoming if name in sources
    )
    return replace(phi, incoming=(*phi.incoming, *added))


def _used_elsewhere(function: Function, inside: set[str]) -> set[int]:
    """Ids read by blocks outside `inside`, phis read at the ends of blocks outside included."""
    used: set[int] = set()
    for block in function.blocks:
        for phi in block.phis:
            used |= {v.id for name, v in phi.incoming if isinstance(v, Ref) and name not in inside}
        if block.name in inside:
            continue
        read = [value for instr in block.instrs for value in instr.operands]
        read += block.branch.read
        used |= {value.id for value in read if isinstance(value, Ref)}
    return used


def _definitions(ident: int, home: str, clones: Collection[Clone]) -> dict[str, Value]:
    """What `ident` is called at the end of each block that defines it or a copy of it."""
    names: dict[str, Value] = {home: Ref(ident)}
    for clone in clones:
        if home in clone.names:
            names[clone.names[home]] = clone.values[ident]
    return names
