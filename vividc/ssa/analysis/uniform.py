"""Values that are the same in all threads of a group: a counter that they all start alike, an
address made of it, a load from there.

The threads of a group run the iterations of a loop in step, so what counts its iterations counts
the same for all that are still in it.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from vividc.machine.opcodes import MEMORY, Opcode
from vividc.ssa.analysis.levels import Level
from vividc.ssa.edit import incoming
from vividc.ssa.ir import Instr, Phi, Ref, Value


@dataclass(frozen=True)
class Uniform:
    """Attributes
    ----------
    values
        Ids of the values that all threads that compute them in one step have in common.
    stepping
        Headers of the loops that are left by all threads of a group in the same step.
    """

    values: frozenset[int]
    stepping: frozenset[str]


def uniform_values(root: Level, own_loads: Collection[int]) -> Uniform:
    """What is uniform over threads that take an iteration of the loop `root` each.

    Parameters
    ----------
    own_loads
        Ids of loads that each thread is to do for itself all the same.
    """
    return _Analysis(root, own_loads).run()


class _Analysis:
    def __init__(self, root: Level, own_loads: Collection[int]) -> None:
        self.levels = list(root.all_levels())
        self.root = root
        self.home: dict[int, Level] = {}
        self.instrs: dict[int, tuple[Instr, Level]] = {}
        self.phis: dict[int, tuple[Phi, Level]] = {}
        for level in self.levels:  # inner ones come later and take over
            for name, block in level.blocks.items():
                self.home |= {item.id: level for item in block.items}
                self.instrs |= {instr.id: (instr, level) for instr in block.instrs}
                if level is not root and name == level.loop.header:
                    self.phis |= {phi.id: (phi, level) for phi in block.phis}
        stored = {i.array for i, _ in self.instrs.values() if i.op is Opcode.STORE}
        self.uniform = {
            ident
            for ident, (instr, _) in self.instrs.items()
            if instr.op is not Opcode.STORE
            and not (instr.op is Opcode.LOAD and (instr.array in stored or ident in own_loads))
        }
        self.uniform |= self.phis.keys()
        self.stepping = {level.loop.header for level in self.levels if level is not root}

    def run(self) -> Uniform:
        """Drops what is not uniform until all that is left agrees."""
        before = None
        while before != (before := (len(self.uniform), len(self.stepping))):
            self.stepping = {
                level.loop.header
                for level in self.levels
                if level.loop.header in self.stepping and self._leaves_together(level)
            }
            self.uniform = {ident for ident in self.uniform if self._holds(ident)}
        return Uniform(frozenset(self.uniform), frozenset(self.stepping))

    def _leaves_together(self, level: Level) -> bool:
        """Whether the header's test alone ends the loop, and all threads make the same one.

        The header then is a block of its own, so it is not the latch and accesses no memory.
        """
        if {source for source, _ in level.loop.exits} != {level.loop.header}:
            return False
        if level.latch == level.loop.header:
            return False
        if any(instr.op in MEMORY for instr in level.header.instrs):
            return False
        cond = level.header.branch.cond
        return cond is None or self._is_uniform(cond, level)

    def _holds(self, ident: int) -> bool:
        if ident in self.phis:
            phi, level = self.phis[ident]
            again = incoming(phi, level.latch)
            starts = [value for name, value in phi.incoming if name != level.latch]
            around = self._around(level)
            return self._is_uniform(again, level) and all(
                self._is_uniform(value, around) for value in starts
            )
        instr, level = self.instrs[ident]
        return all(self._is_uniform(value, level) for value in instr.operands)

    def _is_uniform(self, value: Value, reader: Level) -> bool:
        """Whether a value is uniform where `reader`'s own blocks read it."""
        if not isinstance(value, Ref) or value.id not in self.home:
            return True
        if value.id not in self.uniform:
            return False
        level = self.home[value.id]
        while not reader.loop.blocks <= level.loop.blocks:
            if level.loop.header not in self.stepping:
                return False  # threads leave in different steps, with different words
            level = self._around(level)
        return True

    def _around(self, level: Level) -> Level:
        around = [o for o in self.levels if level.loop.blocks < o.loop.blocks]
        return min(around, key=lambda o: len(o.loop.blocks))
