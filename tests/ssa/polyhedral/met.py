"""Which iterations of a static-control part met in memory when it ran, against its dependences."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from random import Random

import islpy as isl
import numpy as np

from tests.ssa.compiled import Outside, compiled
from vividc.machine.opcodes import MEMORY
from vividc.machine.words import signed, word_of
from vividc.ssa.ir import Const, Function, Input, Ref, Value, pitch_of
from vividc.ssa.polyhedral.forms import ZERO, symbol
from vividc.ssa.polyhedral.relations import Relations
from vividc.ssa.polyhedral.scop import Dimension, Scop, Statement

_MOST_PAIRS = 25
"""Pairs of iterations of two statements that isl is asked about."""

_MOST_BLOCKS = 100_000

Iteration = tuple[str, tuple[int, ...]]
"""A statement and its coordinates."""


@dataclass
class _Met:
    """Iterations that touch a byte that an earlier one has touched, one of both as a store."""

    scop: Scop
    pairs: dict[tuple[str, str], set[tuple[tuple[int, ...], ...]]] = field(default_factory=dict)
    values: dict[Value, int] = field(default_factory=dict)
    """Of symbols that are computed before the part."""
    _written: dict[tuple[str, int], Iteration] = field(default_factory=dict)
    _read: dict[tuple[str, int], set[Iteration]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.statements: dict[int, list[Statement]] = {}
        for statement in self.scop.statements:
            for ident in statement.accesses:
                self.statements.setdefault(ident, []).append(statement)

    def watched(self) -> dict[int, tuple[Value, ...]]:
        """What is told of each access: the counters around it, and the symbols."""
        return {ident: tuple(self._told(ident)) for ident in self.statements}

    def _told(self, ident: int) -> Iterator[Value]:
        for dim in self._dims(ident):
            yield Ref(dim.counter.phi.id)
            yield dim.counter.initial
        yield from self.scop.symbols.values()

    def _dims(self, ident: int) -> tuple[Dimension, ...]:
        """The loops around an access; a header's own among them."""
        return max((one.dims for one in self.statements[ident]), key=len)

    def touch(self, ident: int, byte: int, values: tuple[int, ...]) -> None:
        """An access runs."""
        dims = self._dims(ident)
        at, starts = values[: 2 * len(dims) : 2], values[1 : 2 * len(dims) : 2]
        self.values.update(zip(self.scop.symbols.values(), values[2 * len(dims) :], strict=True))
        coordinates = [_coordinate(dim, word) for dim, word in zip(dims, at, strict=True)]
        statement = self.statements[ident][0]
        if len(self.statements[ident]) > 1:  # of a header: before its loop, or after an iteration
            short, long = sorted(self.statements[ident], key=lambda one: len(one.dims))
            is_first = at[-1] == starts[-1]
            statement = short if is_first else long
            coordinates[-1:] = [] if is_first else [coordinates[-1] - 1]
        access = statement.accesses[ident]
        self._meet((statement.name, tuple(coordinates)), (access.array, byte), access.is_store)

    def _meet(self, now: Iteration, place: tuple[str, int], is_store: bool) -> None:
        if place in self._written:
            self._pair(self._written[place], now)
        if is_store:
            for before in self._read.pop(place, ()):
                self._pair(before, now)
            self._written[place] = now
        else:
            self._read.setdefault(place, set()).add(now)

    def _pair(self, first: Iteration, second: Iteration) -> None:
        if first != second:
            self.pairs.setdefault((first[0], second[0]), set()).add((first[1], second[1]))


def _coordinate(dim: Dimension, word: int) -> int:
    factor = dict(dim.value.terms)[dim.name]
    assert dim.value == symbol(dim.name).times(factor) != ZERO
    return signed(word) // factor


def demand_dependences(function: Function, scop: Scop, args: tuple[object, ...]) -> int:
    """How many pairs of iterations met, when the function ran, or in its first blocks; fails if the
    relations of its part lack one of them. One that leaves its arrays means nothing.
    """
    met = _Met(scop)
    arrays, inputs = _arguments(function, args)
    try:
        compiled(scop.function, met.watched(), met.touch)(arrays, inputs, _MOST_BLOCKS)
    except Outside:
        return 0
    relations = Relations(scop)
    known = relations.dependences.intersect_params(_parameters(met, relations, inputs))
    for (first, second), pairs in met.pairs.items():
        some = Random(1).sample(sorted(pairs), min(len(pairs), _MOST_PAIRS))
        points = "; ".join(f"{first}{list(one)} -> {second}{list(two)}" for one, two in some)
        missing = isl.UnionMap(f"{{ {points} }}").subtract(known.project_out_all_params())
        assert missing.is_empty(), f"{scop.function.name}: not among the dependences: {missing}"
    return sum(map(len, met.pairs.values()))


def _parameters(met: _Met, relations: Relations, inputs: dict[str, int]) -> isl.Set:
    """The symbols as they were."""
    equal = []
    for name, value in relations.scop.symbols.items():
        if isinstance(value, Const):
            word = value.word
        else:
            word = inputs[value.key] if isinstance(value, Input) else met.values.get(value, 0)
        equal.append(f"{name} = {signed(word)}")
    return isl.Set(f"{relations.parameters} -> {{ : {' and '.join(equal) or 'true'} }}")


def _arguments(
    function: Function, args: tuple[object, ...]
) -> tuple[dict[str, list[int]], dict[str, int]]:
    arrays: dict[str, list[int]] = {}
    inputs: dict[str, int] = {}
    for param, value in zip(function.params, args, strict=True):
        if isinstance(value, np.ndarray):
            arrays[param.name] = value.reshape(-1).view(np.uint32).tolist()
            inputs[f"&{param.name}"] = 0
            for axis, size in enumerate(value.shape):
                inputs[f"{param.name}.shape{axis}"] = size
                inputs[pitch_of(param.name, axis).key] = size
        elif isinstance(value, float | np.floating):
            inputs[param.name] = word_of(float(value))
        else:
            inputs |= param.words_of(int(value))  # type: ignore[call-overload]
    for local in function.locals:
        arrays[local.name] = list(local.contents or [0] * local.words)
        inputs[f"&{local.name}"] = 0
    return arrays, inputs


def has_words_only(function: Function) -> bool:
    """Whether all accesses are of words."""
    instrs = (instr for block in function.blocks for instr in block.instrs)
    return all(instr.width == 4 for instr in instrs if instr.op in MEMORY)
