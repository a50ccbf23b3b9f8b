"""Which 64-bit parameters only count iterations or index arrays: they are bound as words.

A loop that starts at a constant and goes by small steps never gets past 2**31, nor does an index of
an array. The launch refuses larger values of such a parameter; in return, loops stay counted ones.
"""

from __future__ import annotations

from collections.abc import Iterator

from vividc.frontend.llvm.ir import Flow, Int, Local, Op, Operand, WideFunction, WidePhi, flow_of
from vividc.frontend.ranges.interval import S32, contains

_SMALL_STEP = 16
_EXTENSIONS = frozenset({"sext", "zext", "trunc", "freeze"})
_ARITHMETIC = frozenset({"sext", "zext", "freeze", "add", "sub", "mul", "shl", "select", "call"})
_SHRINKING = frozenset({"lshr", "ashr", "sdiv", "udiv", "sfloordiv", "ufloordiv"})
_LARGEST_SHRINK = 16


def word_parameters(function: WideFunction) -> frozenset[str]:
    """Names of the i64 parameters that bound, start or step such a loop."""
    wide = {name for name, type_ in function.params if type_ == "i64"}
    if not wide:
        return frozenset()
    search = _Search(function)
    found: set[str] = set()
    for header in search.flow.loops:
        for operand in search.counts(header):
            found |= search.sources(operand) & wide
    return frozenset(found)


class _Search:
    def __init__(self, function: WideFunction) -> None:
        self.flow: Flow = flow_of(function)
        self._function = function
        self._definitions = function.definitions
        self._indices = self._sources_of_indices()

    def counts(self, header: str) -> Iterator[Operand]:
        """First value, step and limit of each induction of a loop that stays within words."""
        body = self.flow.loops[header]
        for phi in self._function.by_name[header].phis:
            step = self._step(phi, body)
            if step is None:
                continue
            starts = [value for pred, value in phi.incoming if pred not in body]
            limits = list(self._limits(phi, body))
            if phi.name in self._indices or self._is_short(step, starts, limits):
                yield from (step, *starts, *limits)

    def sources(self, operand: Operand, *, indexes: bool = False) -> set[str]:
        """Parameters and phis that an operand is computed from."""
        found: set[str] = set()
        pending, seen = [operand], set[str]()
        while pending:
            current = pending.pop()
            if not isinstance(current, Local) or current.name in seen:
                continue
            seen.add(current.name)
            definition = self._definitions.get(current.name)
            if isinstance(definition, Op):
                kept = _keeps_magnitude(definition) or (indexes and definition.op == "trunc")
                pending.extend(definition.args if kept else ())
            else:
                found.add(current.name)
        return found

    def _sources_of_indices(self) -> set[str]:
        return {
            name
            for block in self._function.blocks
            for op in block.ops
            if op.op in ("load", "store")
            for name in self.sources(op.args[-1], indexes=True)
        }

    def _step(self, phi: WidePhi, body: frozenset[str]) -> Operand | None:
        """What an iteration adds to the phi; None if it is no induction."""
        again = [value for pred, value in phi.incoming if pred in body]
        definition = self._defining(again[0]) if len(again) == 1 else None
        if definition is None or definition.op not in ("add", "sub"):
            return None
        first, second = definition.args
        if first != Local(phi.name):
            first, second = second, first
        if first != Local(phi.name) or not self._is_invariant(second, body):
            return None
        return second

    def _is_invariant(self, operand: Operand, body: frozenset[str]) -> bool:
        if not isinstance(operand, Local):
            return True
        return self._function.block_of.get(operand.name) not in body

    def _limits(self, phi: WidePhi, body: frozenset[str]) -> Iterator[Operand]:
        """What the loop's exits compare the phi or its next value with."""
        own = {phi.name, *(v.name for p, v in phi.incoming if p in body and isinstance(v, Local))}
        for name in self.flow.order:
            leave = self._function.by_name[name].exit
            if name not in body or all(target in body for target in leave.targets):
                continue
            test = self._defining(leave.cond)
            if test is not None and test.op == "icmp":
                left, right = test.args
                for one, other in ((left, right), (right, left)):
                    if isinstance(one, Local) and self._widened(one) in own:
                        yield other

    def _widened(self, operand: Local) -> str:
        definition = self._defining(operand)
        if definition is None or definition.op not in _EXTENSIONS:
            return operand.name
        source = definition.args[0]
        return source.name if isinstance(source, Local) else operand.name

    def _defining(self, operand: Operand | None) -> Op | None:
        found = self._definitions.get(operand.name) if isinstance(operand, Local) else None
        return found if isinstance(found, Op) else None

    def _is_short(self, step: Operand, starts: list[Operand], limits: list[Operand]) -> bool:
        """Whether the loop goes from or to a constant by small steps."""
        if not isinstance(step, Int) or not 0 < abs(step.value) <= _SMALL_STEP or not limits:
            return False
        return any(
            all(isinstance(end, Int) and contains(S32, (end.value, end.value)) for end in ends)
            for ends in (starts, limits)
        )


def _keeps_magnitude(op: Op) -> bool:
    """Whether a small result means small operands: not so after a mask or a truncation."""
    if op.op in _SHRINKING:
        by = op.args[1]
        limit = 4 if op.op in ("lshr", "ashr") else _LARGEST_SHRINK
        return isinstance(by, Int) and 0 < by.value <= limit
    return op.op in _ARITHMETIC
