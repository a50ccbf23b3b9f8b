"""Whether iterations of a loop prove to touch bytes of their own in every array that it writes."""

from __future__ import annotations

from vividc.machine.opcodes import MEMORY, Opcode
from vividc.ssa.analysis.counters import defined_in
from vividc.ssa.analysis.induction import constant_step
from vividc.ssa.analysis.levels import Level
from vividc.ssa.analysis.polynomial import Polynomial, Polynomials
from vividc.ssa.ir import Function, Input, Instr, Ref, Value
from vividc.ssa.loops.threads.make import private_arrays


def meeting_array(function: Function, level: Level) -> str | None:
    """An array in which two iterations may meet, one of them writing; None if there is none.

    Iterations stay apart where all indices are a counter times a constant, plus what is fixed, plus
    constants that differ by less; and where they are in the row of the counter's number, whatever
    the column: a subscript outside its dimension is undefined.
    """
    own = set(private_arrays(function, level))
    accesses = [i for block in level.blocks.values() for i in block.instrs if i.op in MEMORY]
    written = {i.array: None for i in accesses if i.op is Opcode.STORE}
    steps = {phi.id: constant_step(function, level.loop, phi) for phi in level.header.phis}
    proof = _Proof(function, level)
    for array in written:
        group = [instr for instr in accesses if instr.array == array]
        apart = any(
            proof.in_windows(group, ident, step) or proof.in_rows(group, ident)
            for ident, step in steps.items()
            if step
        )
        if array not in own and not apart:
            return array
    return None


class _Proof:
    def __init__(self, function: Function, level: Level) -> None:
        self.function = function
        self.known = Polynomials(function)
        self.varying: set[Value] = {Ref(i) for i in defined_in(function, level.loop)}

    def in_windows(self, group: list[Instr], counter: int, step: int) -> bool:
        """Whether all accesses of iteration i lie in a window that moves on by its own length."""
        forms = set()
        places = []
        for instr in group:
            parts = self._parts(instr, counter)
            if parts is None or parts[0].constant is None or instr.offset % (1 << instr.shift):
                return False
            slope, rest = parts
            fixed = tuple(sorted(((m, c) for m, c in rest.terms.items() if m), key=repr))
            if any(value in self.varying for monomial, _ in fixed for value in monomial):
                return False
            forms.add((slope.constant, fixed, instr.shift, instr.width == 1 << instr.shift))
            places.append(rest.coefficient() + instr.offset // (1 << instr.shift))
        if len(forms) != 1:
            return False
        [(factor, _, _, whole)] = forms
        return whole and factor is not None and max(places) - min(places) < abs(factor * step)

    def in_rows(self, group: list[Instr], counter: int) -> bool:
        """Whether all accesses are to elements (i, ...) of an array of several dimensions."""
        param = next((p for p in self.function.params if p.name == group[0].array), None)
        if param is None or param.ndim < 2 or param.flat:  # noqa: PLR2004 - rows and columns
            return False
        dims: set[Value] = {Input(f"{param.name}.shape{n}") for n in range(1, param.ndim)}
        for instr in group:
            parts = self._parts(instr, counter)
            if parts is None:
                return False
            [*slope] = parts[0].terms.items()
            if len(slope) != 1 or set(slope[0][0]) != dims or slope[0][1] != 1:
                return False
            if len(slope[0][0]) != len(dims) or any(dims <= set(m) for m in parts[1].terms):
                return False
        return True

    def _parts(self, instr: Instr, counter: int) -> tuple[Polynomial, Polynomial] | None:
        """(a, b) of an index a * counter + b into the array from its start."""
        if instr.operands[0] != Input(f"&{instr.array}"):
            return None
        return self.known.of(instr.operands[1]).linear_in(Ref(counter))
