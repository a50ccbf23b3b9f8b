"""Unroll-and-jam: several iterations of an outer loop share the iterations of the inner one.

No operation is reassociated: each outer iteration keeps its own recurrences, which then run side by
side (Callahan, Cocke and Kennedy, "Estimating interlock and improving balance for pipelined
architectures", 1988).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from vividc.machine.opcodes import Opcode
from vividc.ssa.analysis.induction import constant_step, is_invariant, never_wraps
from vividc.ssa.edit import (
    block_of,
    defined_types,
    incoming,
    next_id,
    rename_incoming,
    retarget,
    uses,
    with_blocks,
)
from vividc.ssa.flow import Loop
from vividc.ssa.ir import Block, Const, Function, Instr, Phi, Ref, Value
from vividc.ssa.loops.nest import Nest, find_nest, forbids_jam
from vividc.ssa.loops.unroll import MainLoop, close_main_loop, main_loop, untested
from vividc.ssa.rewrite.clone import Clone, clone_blocks
from vividc.ssa.rewrite.refusal import Refusal


@dataclass(frozen=True)
class Jammed:
    """`main` and `inner` are the headers of the new nest, `rest` and `rest_inner` of the old."""

    function: Function
    main: str
    inner: str
    rest: str
    rest_inner: str


def jam(function: Function, outer: Loop, factor: int) -> Jammed | Refusal:
    """Runs `factor` iterations of a counted loop around one other loop together, then the rest.

    Loops have one preheader and one latch each.
    """
    if factor < 2 or factor & (factor - 1):  # noqa: PLR2004 - copies
        return Refusal("the factor is no power of two")
    nest = find_nest(function, outer)
    if isinstance(nest, Refusal):
        return nest
    refused = forbids_jam(nest, factor)
    if refused is not None:
        return refused
    made = main_loop(function, outer, factor)
    if isinstance(made, Refusal):
        return made
    entering = _entering(nest, made, factor)
    if isinstance(entering, Refusal):
        return entering
    wiring = _Wiring(nest, made, factor)
    wiring.clone(entering)
    function = wiring.wired()
    inner = wiring.clones[0].names[nest.inner.header]
    return Jammed(function, made.header, inner, outer.header, nest.inner.header)


@dataclass(frozen=True)
class _Steps:
    """Additions for the main header: phi id and copy -> the phi's value in that copy."""

    instrs: tuple[Instr, ...]
    values: dict[tuple[int, int], Value]


def _entering(nest: Nest, made: MainLoop, factor: int) -> _Steps | Refusal:
    """Header phis that move by a constant are computed in the main header for every copy; others
    must get their next value before the inner loop, or be read after the nest only.
    """
    body = nest.outer.blocks
    header = block_of(nest.function, nest.outer.header)
    early = {
        ident for name in nest.before for ident in defined_types(block_of(nest.function, name))
    }
    read = _read_inside(nest)
    free = next_id(made.function)
    instrs: list[Instr] = []
    values: dict[tuple[int, int], Value] = {}
    for phi in header.phis:
        carried = incoming(phi, nest.outer.latches[0])
        step = constant_step(nest.function, nest.outer, phi)
        if step is None:
            known = is_invariant(nest.function, body, carried) or phi.id not in read
            if not known and not (isinstance(carried, Ref) and carried.id in early):
                return Refusal("an outer iteration needs the one before to be complete")
            continue
        for copy in range(1, factor + 1):
            word = Const((step * copy) & 0xFFFFFFFF)
            operands = (made.values[phi.id], word)
            instr = Instr(free, Opcode.ADD, phi.type, operands, loc=phi.loc)
            exact = never_wraps(nest.function, body, Ref(phi.id), by_one=False)
            instr = replace(instr, exact=exact)
            free += 1
            instrs.append(instr)
            values[phi.id, copy] = Ref(instr.id)
    return _Steps(tuple(instrs), values)


def _read_inside(nest: Nest) -> set[int]:
    """Ids that the nest itself reads."""
    names = nest.outer.blocks
    inside = [block for block in nest.function.blocks if block.name in names]
    values = [value for block in inside for value in uses(block)]
    incoming_values = ((n, v) for block in inside for phi in block.phis for n, v in phi.incoming)
    values += [value for name, value in incoming_values if name in names]
    return {value.id for value in values if isinstance(value, Ref)}


@dataclass
class _Wiring:
    """Puts the copies together: all parts before, the inner bodies in one loop, all parts after."""

    nest: Nest
    made: MainLoop
    factor: int

    def __post_init__(self) -> None:
        self.clones: list[Clone] = []
        self.function = self.made.function
        self.blocks: dict[str, Block] = {}
        self.carried: dict[int, Value] = {}

    def clone(self, steps: _Steps) -> None:
        """The copies, each with its own values for the outer header's phis."""
        main = block_of(self.function, self.made.header)
        main = replace(main, instrs=(*main.instrs, *steps.instrs))
        self.function = with_blocks(self.function, (main,))
        outer = self.nest.outer
        header = block_of(self.nest.function, outer.header)
        given = dict(self.made.values)
        for copy in range(self.factor):
            clone = clone_blocks(self.function, outer.blocks, given=given, stem=f"jam{copy}")
            clone = untested(clone, outer)
            self.function = replace(self.function, blocks=(*self.function.blocks, *clone.blocks))
            self.clones.append(clone)
            given = {
                phi.id: steps.values.get(
                    (phi.id, copy + 1), clone.value(incoming(phi, outer.latches[0]))
                )
                for phi in header.phis
            }
        self.carried = given

    def wired(self) -> Function:
        """The function with all edges in place."""
        self.blocks = {block.name: block for block in self.function.blocks}
        fused = self._fused_header()
        for copy in range(self.factor):
            self._wire(copy)
        self.blocks[fused.name] = fused
        gone = {self._name(copy, self._inner.header) for copy in range(1, self.factor)}
        kept = tuple(self.blocks[b.name] for b in self.function.blocks if b.name not in gone)
        function = replace(self.function, blocks=kept)
        main = block_of(function, self.made.header)
        first = self._name(0, self.nest.outer.header)
        main = replace(main, branch=retarget(main.branch, main.name, first))
        last = self._name(self.factor - 1, self.nest.outer.latches[0])
        return close_main_loop(with_blocks(function, (main,)), self.made, last, self.carried)

    @property
    def _inner(self) -> Loop:
        return self.nest.inner

    def _name(self, copy: int, original: str) -> str:
        return self.clones[copy].names[original]

    def _fused_header(self) -> Block:
        """All inner headers in one; the first one's test decides for all."""
        last = self.factor - 1
        before, latch = self.nest.before[-1], self._inner.latches[0]
        phis: list[Phi] = []
        instrs: list[Instr] = []
        for copy in range(self.factor):
            block = self.blocks[self._name(copy, self._inner.header)]
            for phi in block.phis:
                moved = rename_incoming(phi, self._name(copy, before), self._name(last, before))
                phis.append(
                    rename_incoming(moved, self._name(copy, latch), self._name(last, latch))
                )
            instrs += block.instrs
        first = self.blocks[self._name(0, self._inner.header)]
        return replace(first, phis=tuple(phis), instrs=tuple(instrs))

    def _wire(self, copy: int) -> None:
        nest, last = self.nest, self.factor - 1
        following = min(copy + 1, last)
        header = self._name(copy, self._inner.header)
        fused = self._name(0, self._inner.header)
        self._jump(
            self._name(copy, nest.before[-1]),
            header,
            fused if copy == last else self._name(following, nest.outer.header),
        )
        self._jump(
            self._name(copy, self._inner.latches[0]),
            header,
            fused if copy == last else self._name(following, nest.entry),
        )
        self._jump(
            self._name(copy, nest.outer.latches[0]),
            self._name(copy, nest.outer.header),
            self.made.header if copy == last else self._name(following, nest.leave),
        )
        if copy:
            before = self._name(copy - 1, self._inner.latches[0])
            self._enter(self._name(copy, nest.entry), header, before)
            before = self._name(copy - 1, nest.outer.latches[0])
            self._enter(self._name(copy, nest.leave), header, before)

    def _jump(self, name: str, old: str, new: str) -> None:
        block = self.blocks[name]
        self.blocks[name] = replace(block, branch=retarget(block.branch, old, new))

    def _enter(self, name: str, old: str, new: str) -> None:
        block = self.blocks[name]
        phis = tuple(rename_incoming(phi, old, new) for phi in block.phis)
        self.blocks[name] = replace(block, phis=phis)
