"""Restores SSA form for a value that has several definitions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from vividc.errors import InternalError, SourceLoc
from vividc.host.once import changed
from vividc.ssa.edit import map_values, next_id, uses
from vividc.ssa.flow import predecessors
from vividc.ssa.ir import Block, Function, Kind, Phi, Ref, Value


def repair(
    function: Function,
    ident: int,
    type_: Kind,
    definitions: Mapping[str, Value],
    loc: SourceLoc | None = None,
) -> Function:
    """Every use of `ident` outside the defining blocks reads the definition that reaches it.

    Phis are placed on demand, walking back from the uses (Braun et al. 2013, section 2). The
    function has no unreachable blocks.

    Parameters
    ----------
    definitions
        The value that stands for `ident` at the end of each block that defines it. Uses inside
        these blocks are left alone, and so are phi inputs that come from them if they do not read
        `ident` itself.

    Raises
    ------
    InternalError
        If a use can be reached without passing a definition.
    """
    walk = _Repair(function, ident, type_, dict(definitions), loc)
    return walk.run()


@dataclass
class _Repair:
    function: Function
    ident: int
    type: Kind
    at_end: dict[str, Value]
    loc: SourceLoc | None
    phis: dict[str, Phi] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.predecessors = predecessors(self.function)
        self.free = next_id(self.function)
        self.defining = frozenset(self.at_end)
        self.at_start: dict[str, Value] = {}
        self.unfilled: list[str] = []

    def run(self) -> Function:
        blocks = [self._rewritten(block) for block in self.function.blocks]
        while self.unfilled:  # filling a phi may ask for more
            name = self.unfilled.pop()
            incoming = tuple((source, self._end(source)) for source in self.predecessors[name])
            self.phis[name] = replace(self.phis[name], incoming=incoming)
        with_phis = (
            replace(block, phis=(*block.phis, self.phis[block.name]))
            if block.name in self.phis
            else block
            for block in blocks
        )
        return replace(self.function, blocks=tuple(with_phis))

    def _rewritten(self, block: Block) -> Block:
        mine = Ref(self.ident)
        phis = tuple(self._filled(phi) if self._comes_into(phi) else phi for phi in block.phis)
        block = changed(block, phis=phis)
        if block.name in self.defining or not self._reads(block):
            return block
        value = self._start(block.name)
        made = map_values(changed(block, phis=()), lambda v: value if v == mine else v)
        return changed(made, phis=phis)

    def _is_mine(self, value: Value) -> bool:
        return isinstance(value, Ref) and value.id == self.ident

    def _comes_into(self, phi: Phi) -> bool:
        return any(self._is_mine(value) for _, value in phi.incoming)

    def _filled(self, phi: Phi) -> Phi:
        incoming = (
            (name, self._end(name) if self._is_mine(value) else value)
            for name, value in phi.incoming
        )
        return changed(phi, incoming=tuple(incoming))

    def _reads(self, block: Block) -> bool:
        return any(map(self._is_mine, uses(block)))

    def _end(self, name: str) -> Value:
        return self.at_end[name] if name in self.at_end else self._start(name)

    def _start(self, name: str) -> Value:
        """The value at the start of block `name`: a straight walk up, then a phi."""
        chain: list[str] = []
        while name not in self.at_start and len(self.predecessors[name]) == 1:
            chain.append(name)
            name = self.predecessors[name][0]
            if name in self.at_end:
                value = self.at_end[name]
                break
        else:
            value = self._known_or_phi(name)
        for passed in chain:
            self.at_start[passed] = value
        return value

    def _known_or_phi(self, name: str) -> Value:
        if name in self.at_start:
            return self.at_start[name]
        if not self.predecessors[name]:
            raise InternalError(f"value {self.ident} is used where no definition reaches")
        phi = Phi(self.free, self.type, (), self.loc)
        self.free += 1
        self.phis[name] = phi
        self.unfilled.append(name)
        self.at_start[name] = Ref(phi.id)
        return Ref(phi.id)
