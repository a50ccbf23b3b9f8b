"""One array for each pointer: where a variable of a kernel's is this array here and that one there,
control flow is copied for each, so that every access names its array.

`x = A @ x` in a loop makes a new array while it reads the one before, `a, b = b, a` exchanges two:
in one iteration a pointer is into the one, in the next into the other. Both iterations become code
of their own, with the arrays in turn. An array that is made takes the place of one that nobody
reads any more, so that `x = f(x)` needs two places, and one where the old x is not read after the
new one was made; then nothing is copied.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Set
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final

from vividc.frontend.llvm.calls import ALLOCATE
from vividc.ssa.edit import (
    FreshIds,
    first_free,
    fresh_name,
    incoming,
    map_values,
    rename_incoming,
    uses,
)
from vividc.ssa.flow import flow_of
from vividc.ssa.ir import (
    Block,
    Branch,
    Function,
    Global,
    Input,
    Instr,
    Key,
    Named,
    Phi,
    Ref,
    Value,
    result_type,
)
from vividc.ssa.rewrite.repair import repair

_MOST_GROWTH: Final = 4
"""Times the instructions of the kernel as written that it may have."""
_FEW: Final = 600
"""So many it may have in any case."""
_WAYS: Final = ("then", "else", "end")
_FORWARDED: Final = frozenset({"getelementptr", "freeze"})

Arrays = dict[int, Value]
"""Which array each of some pointers is into."""
Place = Callable[[int, int], Value]
"""The array that an allocation, by its id, makes if it takes place number so many of its pool."""


def is_allocation(item: Phi | Instr | None) -> bool:
    """Whether the kernel makes an array here."""
    return isinstance(item, Instr) and item.op == "call" and item.pred.startswith(ALLOCATE)


def base_of(function: Function, pointer: Value) -> Value:
    """What a pointer was computed from: a choice, an allocation, an input, a constant."""
    while isinstance(pointer, Ref):
        definition = function.definitions.get(pointer.id)
        if not isinstance(definition, Instr) or definition.op not in _FORWARDED:
            return pointer
        pointer = definition.operands[0]
    return pointer


def choices_of(item: Phi | Instr | None) -> tuple[Value, ...]:
    """The pointers that a pointer phi or select chooses from."""
    if item is None or item.type != "ptr":
        return ()
    if isinstance(item, Phi):
        return tuple(value for _, value in item.incoming)
    return item.operands[1:] if item.op == "select" else ()


def roots_of(function: Function, pointer: Value) -> frozenset[Key]:
    """What a pointer may point into: allocations, inputs and constants."""
    found: set[Key] = set()
    seen: set[Key] = set()
    pending = [pointer]
    while pending:
        base = base_of(function, pending.pop())
        if isinstance(base, Global):
            found.add(base.name)
        if not isinstance(base, Named) or base.key in seen:
            continue
        seen.add(base.key)
        item = function.definitions.get(base.key)
        pending += choices_of(item)
        if not choices_of(item):
            found.add(base.key)
    return frozenset(found)


def merges(function: Function) -> Iterator[Phi | Instr]:
    """All pointer phis and selects."""
    return (item for block in function.blocks for item in block.items if choices_of(item))


def mixed_choices(function: Function) -> list[Phi | Instr]:
    """Choices between pointers into different arrays."""
    return [item for item in merges(function) if len(roots_of(function, Ref(item.id))) > 1]


def related(function: Function, wanted: Iterable[Phi | Instr]) -> frozenset[int]:
    """Some choices between pointers, and all that may be into one of the same arrays."""
    roots = {item.id: roots_of(function, Ref(item.id)) for item in merges(function)}
    found: set[int] = set()
    more = {item.id for item in wanted}
    while not more <= found:
        found |= more
        arrays = {root for id_ in found for root in roots[id_]}
        more = {id_ for id_, own in roots.items() if own & arrays}
    return frozenset(found)


def apart(
    function: Function, choices: frozenset[int], place: Place | None = None
) -> Function | None:
    """The function in which each of these choices between pointers is a pointer into one array.

    Parameters
    ----------
    choices
        Phis and selects, with all that are related to them.
    place
        Names the arrays that take the place of all allocations; None: these are left.

    Returns
    -------
    None: it would be too long, or a pointer comes from elsewhere.
    """
    most = max(_MOST_GROWTH * sum(len(block.items) for block in function.blocks), _FEW)
    variables = set(choices)
    if place is not None:
        items = (item for block in function.blocks for item in block.instrs)
        variables |= {item.id for item in items if is_allocation(item)}
    for id_ in sorted(choices):
        choice = function.definitions[id_]
        if isinstance(choice, Instr):
            function = _as_branch(function, choice)
    copies = Copies(function, frozenset(variables), place, most)
    return copies.made() if copies.walk() else None


def _as_branch(function: Function, choice: Instr) -> Function:
    """A select as a branch and a phi."""
    block = function.by_name[function.block_of[choice.id]]
    at = block.instrs.index(choice)
    then, other, end = (fresh_name(function, f"{block.name}.{way}") for way in _WAYS)
    branch = Branch(then, choice.operands[0], other, loc=choice.loc)
    ways = tuple(Block(name, (), (), Branch(end, loc=choice.loc)) for name in (then, other))
    chosen = tuple(zip((then, other), choice.operands[1:], strict=True))
    phi = Phi(choice.id, choice.type, chosen, choice.loc)
    tail = Block(end, (phi,), block.instrs[at + 1 :], block.branch)
    blocks: list[Block] = []
    for one in function.blocks:
        phis = tuple(rename_incoming(phi, block.name, end) for phi in one.phis)
        if one is not block:
            blocks.append(replace(one, phis=phis))
            continue
        head = replace(block, phis=phis, instrs=block.instrs[:at], branch=branch)
        blocks += (head, *ways, tail)
    return replace(function, blocks=tuple(blocks))


@dataclass(frozen=True)
class _Copy:
    """A block where these pointers are arrays, those defined in it among them; `ends`: how each of
    its successors is called.
    """

    block: Block
    name: str
    arrays: Arrays
    ends: dict[str, str]

    def array(self, value: Value) -> Value:
        """A value or, if it is one of the pointers, its array."""
        return self.arrays.get(value.id, value) if isinstance(value, Ref) else value


@dataclass
class Copies:
    """Copies of blocks, one for each way in which the pointers that are read later are into arrays.

    Attributes
    ----------
    variables
        Pointer phis that are told apart, and allocations.
    """

    function: Function
    variables: frozenset[int]
    place: Place | None
    most: int
    names: dict[tuple[str, frozenset[tuple[int, Value]]], str] = field(default_factory=dict)
    copies: dict[str, list[_Copy]] = field(default_factory=lambda: defaultdict(list))

    def walk(self) -> bool:
        """Find all that can be reached; False: there are too many."""
        entry = self.function.blocks[0]
        pending: list[tuple[Block, Arrays]] = [(entry, {})]
        self._name(entry.name, {})
        length = 0
        while pending:
            block, arrays = pending.pop()
            name = self._name(block.name, arrays)
            inside = self._inside(block, arrays)
            length += len(block.items)
            if length > self.most:
                return False
            ends: dict[str, str] = {}
            for successor in dict.fromkeys(block.branch.successors):
                later = self._along(block.name, successor, inside)
                if later is None:
                    return False
                known = len(self.names)
                ends[successor] = self._name(successor, later)
                if len(self.names) > known:
                    pending.append((self.function.by_name[successor], later))
            whole = {id_: array for id_, array in inside.items() if id_ in self._whole}
            self.copies[block.name].append(_Copy(block, name, whole, ends))
        return True

    def _name(self, block: str, arrays: Arrays) -> str:
        key = block, frozenset(arrays.items())
        if key not in self.names:
            count = sum(one == block for one, _ in self.names)
            taken = {*self.function.by_name, *self.names.values()}
            self.names[key] = first_free(taken, f"{block}.again") if count else block
        return self.names[key]

    def _inside(self, block: Block, arrays: Arrays) -> Arrays:
        """Arrays at the end of a block."""
        found = dict(arrays)
        for at, op in enumerate(block.instrs):
            if op.id not in self.variables or self.place is None:
                continue
            busy, number = self.read_behind(block, at, found), 0
            while (array := self.place(op.id, number)) in busy:
                number += 1
            found[op.id] = array
        return found

    def read_behind(self, block: Block, at: int, arrays: Arrays) -> set[Value]:
        """Arrays that are read behind an allocation."""
        live = self._live_out[block.name] | set(self._read(block.instrs[at + 1 :]))
        return {arrays[id_] for id_ in live if id_ in arrays}

    def _along(self, source: str, target: str, arrays: Arrays) -> Arrays | None:
        """Arrays of what is read in a block or behind it, coming from another."""
        found: Arrays = {}
        for phi in self.function.by_name[target].phis:
            if phi.id in self.variables:
                array = self._array(phi, incoming(phi, source), arrays)
                if array is None:
                    return None
                found[phi.id] = array
        return found | {id_: arrays[id_] for id_ in self._live_in[target] if id_ in arrays}

    def _array(self, phi: Phi, pointer: Value, arrays: Arrays) -> Value | None:
        """The array that a pointer is into; where it is null, nothing is accessed through it, and
        any array will do.
        """
        base = base_of(self.function, pointer)
        if isinstance(base, Ref):
            return arrays.get(base.id)
        if isinstance(base, Input | Global):
            return base
        some = min(roots_of(self.function, Ref(phi.id)), key=str, default=None)
        if isinstance(some, int):
            return self.place(some, 0) if self.place and some in self.variables else None
        return None if some is None else Input(some)

    def _read(self, instrs: Iterable[Instr]) -> Iterator[int]:
        for op in instrs:
            yield from self._of(op.operands)

    def _of(self, values: Iterable[Value]) -> Iterator[int]:
        for value in values:
            base = base_of(self.function, value)
            if isinstance(base, Ref) and base.id in self.variables:
                yield base.id

    @cached_property
    def _whole(self) -> Set[int]:
        """The pointers that are arrays, not places in them."""
        definitions = self.function.definitions
        whole = set(self.variables)
        while True:
            inside = {
                id_
                for id_ in whole
                for value in choices_of(definitions[id_])
                if isinstance(value, Ref) and value.id not in whole
            }
            if not inside:
                return whole
            whole -= inside

    @cached_property
    def _live_in(self) -> dict[str, Set[int]]:
        """What is read in a block or behind it, of what is defined before it."""
        function, flow = self.function, flow_of(self.function)
        live: dict[str, Set[int]] = {block.name: frozenset() for block in function.blocks}
        grown = True
        while grown:
            grown = False
            for name in reversed(flow.order):
                block = function.by_name[name]
                inside = self._after(name, live) | set(self._of(uses(block)))
                inside -= {item.id for item in block.items}
                if inside != live[name]:
                    live[name], grown = inside, True
        return live

    @cached_property
    def _live_out(self) -> dict[str, Set[int]]:
        return {name: self._after(name, self._live_in) for name in self._live_in}

    def _after(self, name: str, live: Mapping[str, Set[int]]) -> set[int]:
        """What is read behind a block, on the way there by phis."""
        found: set[int] = set()
        for successor in self.function.by_name[name].branch.successors:
            found |= live[successor]
            for phi in self.function.by_name[successor].phis:
                found.update(self._of([incoming(phi, name)]))
        return found

    def made(self) -> Function:
        """The function of the copies."""
        ids = FreshIds(self.function)
        sources: dict[str, list[_Copy]] = defaultdict(list)
        for copy in (copy for copies in self.copies.values() for copy in copies):
            for end in dict.fromkeys(copy.ends.values()):
                sources[end].append(copy)
        defined: dict[int, dict[str, Value]] = defaultdict(dict)
        blocks: list[Block] = []
        for block in self.function.blocks:
            for copy in self.copies[block.name]:
                own = {
                    item.id: item.id if copy.name == block.name else ids()
                    for item in block.items
                    if item.id not in self._whole
                }
                blocks.append(_copied(copy, own, sources[copy.name]))
                for old, new in own.items():
                    defined[old][copy.name] = Ref(new)
        function = replace(self.function, blocks=tuple(blocks))
        return _repaired(function, self.function, defined)


def _copied(copy: _Copy, own: Mapping[int, int], sources: list[_Copy]) -> Block:
    """A copy whose definitions have ids of their own; what it reads of other blocks is to be
    repaired.
    """

    def change(value: Value) -> Value:
        found = copy.array(value)
        return Ref(own[found.id]) if isinstance(found, Ref) and found.id in own else found

    def came(phi: Phi, source: _Copy) -> Value:
        return source.array(incoming(phi, source.block.name))

    block = copy.block
    phis = tuple(
        replace(
            phi,
            id=own[phi.id],
            incoming=tuple((source.name, came(phi, source)) for source in sources),
        )
        for phi in block.phis
        if phi.id in own
    )
    body = map_values(replace(block, phis=()), change)
    instrs = tuple(replace(op, id=own[op.id]) for op in body.instrs if op.id in own)
    branch = body.branch
    targets = [None if t is None else copy.ends.get(t) for t in (branch.target, branch.otherwise)]
    branch = replace(branch, target=targets[0], otherwise=targets[1])
    return Block(copy.name, phis, instrs, branch)


def _repaired(
    function: Function, before: Function, defined: Mapping[int, dict[str, Value]]
) -> Function:
    """The function where what is read of another block is what was computed on the way."""
    for id_, ways in defined.items():
        if len(ways) > 1:
            item = before.definitions[id_]
            function = repair(function, id_, result_type(item), ways, item.loc)
    return function
