"""Accesses of a nest that never meet the same address twice, once the nest is one loop.

In the flattened loop an index is no longer affine in the iteration index. What keeps accesses of
one address in order from iteration to iteration is then a recurrence through memory; a proof that
no address comes back removes it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from vividc.machine.opcodes import MEMORY
from vividc.ssa.analysis.counters import Counter, counter_of, defined_in
from vividc.ssa.analysis.induction import constant_step, never_wraps
from vividc.ssa.analysis.polynomial import Polynomial, Polynomials
from vividc.ssa.edit import block_of, with_blocks
from vividc.ssa.flow import Loop
from vividc.ssa.ir import Function, Instr, Ref, is_dimension

_STEP_LIMIT = 1 << 14


def mark_distinct(
    function: Function, outer: Loop, inner: Loop, runs_once: Callable[[str, Instr], bool]
) -> Function:
    """Sets `distinct` to the header of `outer` for the accesses that prove to be so.

    Accesses that run at most once in an outer iteration (`runs_once`, given block and access), with
    an index that the outer iteration changes; and accesses of the inner loop to element (i, j) of
    an array whose rows the inner counter stays in. The program's indices are taken to lie in their
    arrays: anything else is undefined.
    """
    proof = _Proof(function, outer, inner)
    changed = []
    for block in function.blocks:
        if block.name not in outer.blocks:
            continue
        within = block.name in inner.blocks
        instrs = tuple(
            replace(instr, distinct=outer.header)
            if instr.op in MEMORY
            and (proof.in_rows(instr) if within else runs_once(block.name, instr))
            and (within or proof.moves_on(instr))
            else instr
            for instr in block.instrs
        )
        if instrs != block.instrs:
            changed.append(replace(block, instrs=instrs))
    return with_blocks(function, changed) if changed else function


@dataclass
class _Proof:
    function: Function
    outer: Loop
    inner: Loop

    def __post_init__(self) -> None:
        self.known = Polynomials(self.function)
        self.varying = {Ref(ident) for ident in defined_in(self.function, self.outer)}
        self.rows = counter_of(self.function, self.outer)
        self.columns = counter_of(self.function, self.inner)
        self.monotone = self._monotone()

    def moves_on(self, access: Instr) -> bool:
        """Whether each outer iteration gives another index, the same throughout the iteration."""
        if not self._has_fixed_base(access):
            return False
        index = self.known.of(access.operands[1])
        for value in self.monotone:
            parts = index.linear_in(value)
            if parts is not None and parts[0].terms:
                slope, rest = parts
                return self._is_fixed(rest) and _is_nonzero(slope)
        return False

    def in_rows(self, access: Instr) -> bool:
        """Whether the index is i * size + j (or j * size + i), and the second counter moves within
        a window of `size`.
        """
        if self.rows is None or self.columns is None or not self._has_fixed_base(access):
            return False
        index = self.known.of(access.operands[1])
        inner = index.linear_in(Ref(self.columns.phi.id))
        outer = None if inner is None else inner[1].linear_in(Ref(self.rows.phi.id))
        if inner is None or outer is None or not self._is_fixed(outer[1]):
            return False
        slopes = (outer[0], inner[0])
        return self._is_row(*slopes, self.columns) or self._is_row(*slopes[::-1], self.rows)

    def _monotone(self) -> list[Ref]:
        """Phis of the outer loop that each outer iteration moves one way, and that never wrap."""
        counters = []
        if self.rows is not None and abs(self.rows.step) <= _STEP_LIMIT:
            counters.append(Ref(self.rows.phi.id))
        for phi in block_of(self.function, self.outer.header).phis:
            step = constant_step(self.function, self.outer, phi)
            if not step or abs(step) > _STEP_LIMIT or Ref(phi.id) in counters:
                continue
            if never_wraps(self.function, self.outer.blocks, Ref(phi.id), by_one=False):
                counters.append(Ref(phi.id))
        return counters

    def _has_fixed_base(self, access: Instr) -> bool:
        base = access.operands[0]
        return not (isinstance(base, Ref) and base in self.varying)

    def _is_fixed(self, rest: Polynomial) -> bool:
        return not any(value in self.varying for monomial in rest.terms for value in monomial)

    def _is_row(self, size: Polynomial, unit: Polynomial, counter: Counter) -> bool:
        """Whether `size` is a dimension, perhaps a known one, `unit` is 1, and the counter has at
        most `size` words.
        """
        if unit.constant != 1 or len(size.terms) != 1:
            return False
        [(monomial, factor)] = size.terms.items()
        if monomial and (factor != 1 or len(monomial) != 1 or not is_dimension(monomial[0])):
            return False
        if not monomial and not 0 < factor <= _STEP_LIMIT:
            return False
        ends = [self.known.of(counter.initial), self.known.of(counter.limit)]
        first, last = ends if counter.step > 0 else ends[::-1]
        excess = last.plus(first, -1).plus(size, -1).constant
        return excess is not None and -_STEP_LIMIT <= excess <= 0


def _is_nonzero(slope: Polynomial) -> bool:
    """A small constant, or a dimension times one: an array that is accessed is not empty."""
    if len(slope.terms) != 1:
        return False
    [(monomial, factor)] = slope.terms.items()
    return abs(factor) <= _STEP_LIMIT and all(is_dimension(value) for value in monomial)
