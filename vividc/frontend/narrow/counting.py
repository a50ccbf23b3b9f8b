"""Which 64-bit parameters only count iterations or index arrays: they are bound as words.

A loop that starts at a constant and goes by small steps never gets past 2**31, nor does an index of
an array. The launch refuses larger values of such a parameter; in return, loops stay counted ones.
"""

from __future__ import annotations

from collections.abc import Iterator

from vividc.frontend.ranges.interval import S32, contains
from vividc.ssa.analysis.induction import induction_of
from vividc.ssa.flow import Flow, flow_of
from vividc.ssa.ir import Function, Instr, Int, Key, Named, Phi, Ref, Value, definition_of

_SMALL_STEP = 16
_EXTENSIONS = frozenset({"sext", "zext", "trunc", "freeze"})
_ARITHMETIC = frozenset({"sext", "zext", "freeze", "add", "sub", "mul", "shl", "select", "call"})
_SHRINKING = frozenset({"lshr", "ashr", "sdiv", "udiv", "sfloordiv", "ufloordiv"})
_LARGEST_SHRINK = 16


def word_parameters(function: Function) -> frozenset[str]:
    """Names of the i64 parameters that bound, start or step such a loop."""
    wide = {name for name, type_ in function.inputs if type_ == "i64"}
    if not wide:
        return frozenset()
    search = _Search(function)
    counting: set[str] = set()
    for header in search.flow.loops:
        for operand in search.counts(header):
            counting |= wide & search.sources(operand)
    return frozenset(counting)


class _Search:
    def __init__(self, function: Function) -> None:
        self.flow: Flow = flow_of(function)
        self._function = function
        self._indices = self._sources_of_indices()

    def counts(self, header: str) -> Iterator[Value]:
        """First value, step and limit of each induction of a loop that stays within words."""
        body = self.flow.loops[header]
        for phi in self._function.by_name[header].phis:
            induction = induction_of(self._function, body, phi)
            if induction is None:
                continue
            starts = [value for pred, value in phi.incoming if pred not in body]
            limits = list(self._limits(phi, body))
            if phi.id in self._indices or self._is_short(induction.by, starts, limits):
                yield from (induction.by, *starts, *limits)

    def sources(self, operand: Value, *, indexes: bool = False) -> set[Key]:
        """Parameters and phis that an operand is computed from."""
        sources: set[Key] = set()
        pending, seen = [operand], set[Key]()
        while pending:
            current = pending.pop()
            if not isinstance(current, Named) or current.key in seen:
                continue
            seen.add(current.key)
            definition = definition_of(self._function, current)
            if isinstance(definition, Instr):
                kept = _keeps_magnitude(definition) or (indexes and definition.op == "trunc")
                pending.extend(definition.operands if kept else ())
            else:
                sources.add(current.key)
        return sources

    def _sources_of_indices(self) -> set[Key]:
        return {
            name
            for block in self._function.blocks
            for op in block.instrs
            if op.op in ("load", "store")
            for name in self.sources(op.operands[-1], indexes=True)
        }

    def _limits(self, phi: Phi, body: frozenset[str]) -> Iterator[Value]:
        """What the loop's exits compare the phi or its next value with."""
        own = {Ref(phi.id), *(value for pred, value in phi.incoming if pred in body)}
        for name in self.flow.order:
            leave = self._function.by_name[name].branch
            if name not in body or all(target in body for target in leave.successors):
                continue
            test = self._defining(leave.cond)
            if test is not None and test.op == "icmp":
                left, right = test.operands
                for one, other in ((left, right), (right, left)):
                    if self._unextended(one) in own:
                        yield other

    def _unextended(self, operand: Value) -> Value:
        definition = self._defining(operand)
        if definition is None or definition.op not in _EXTENSIONS:
            return operand
        source = definition.operands[0]
        return source if isinstance(source, Named) else operand

    def _defining(self, operand: Value | None) -> Instr | None:
        definition = definition_of(self._function, operand)
        return definition if isinstance(definition, Instr) else None

    def _is_short(self, step: Value, starts: list[Value], limits: list[Value]) -> bool:
        """Whether the loop goes from or to a constant by small steps."""
        if not isinstance(step, Int) or not 0 < abs(step.value) <= _SMALL_STEP or not limits:
            return False
        return any(
            all(isinstance(end, Int) and contains(S32, (end.value, end.value)) for end in ends)
            for ends in (starts, limits)
        )


def _keeps_magnitude(op: Instr) -> bool:
    """Whether a small result means small operands: not so after a mask or a truncation."""
    if op.op in _SHRINKING:
        by = op.operands[1]
        limit = 4 if op.op in ("lshr", "ashr") else _LARGEST_SHRINK
        return isinstance(by, Int) and 0 < by.value <= limit
    return op.op in _ARITHMETIC
