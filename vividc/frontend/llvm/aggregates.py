"""Tuples in SSA: a phi or a select of an array or a structure becomes one for each of its elements.

Numba's tuples are LLVM's aggregates. Where they are made and read in one place LLVM takes them
apart; where paths join it leaves phis of whole aggregates.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import accumulate

from vividc.frontend.llvm.layout import members
from vividc.frontend.llvm.tokens import Structs
from vividc.ssa.edit import FreshIds, substitute
from vividc.ssa.ir import (
    Block,
    Float,
    Function,
    Instr,
    Int,
    Key,
    Kind,
    Named,
    Parts,
    Phi,
    Ref,
    Value,
)

_ARRAY = re.compile(r"\[(\d+)x(.*)\]")
_MOST = 1024
"""Elements of an aggregate that is taken apart: one of more is refused where it is used."""
_PARTS = frozenset({"insertvalue", "extractvalue"})
_JOINS = frozenset({"select", "freeze"})


def split_aggregates(function: Function, structs: Structs) -> Function:
    """Replace phis, choices and parts of aggregates by those of their elements.

    What comes out of a call or a load stays whole, with all that is made of it.
    """
    if not any(op.op in _PARTS for block in function.blocks for op in block.instrs):
        return function
    splitter = _Splitter(function, structs)
    blocks = tuple(splitter.block(block) for block in function.blocks)
    return substitute(replace(function, blocks=blocks), splitter.known)


class _Splitter:
    """Elements of a function's aggregates; `known`: what each `extractvalue` gives."""

    def __init__(self, function: Function, structs: Structs) -> None:
        self.known: dict[int, Value] = {}
        self._ids = FreshIds(function)
        self._definitions = function.definitions
        self._structs = structs
        self._whole = self._unknown()

    def block(self, block: Block) -> Block:
        """The block without aggregates that could be taken apart."""
        phis = tuple(part for phi in block.phis for part in self._phi(phi))
        ops = tuple(part for op in block.instrs for part in self._op(op))
        return replace(block, phis=phis, instrs=ops)

    def _unknown(self) -> set[Key]:
        """Aggregates that stay whole."""
        whole = {
            name
            for name, item in self._definitions.items()
            if not self._types(item.type)
            or (
                isinstance(item, Instr)
                and _is_aggregate(item.type)
                and item.op not in _PARTS | _JOINS
            )
        }
        while True:
            more = {
                name
                for name, item in self._definitions.items()
                if name not in whole
                and any(isinstance(arg, Named) and arg.key in whole for arg in _aggregates(item))
            }
            if not more:
                return whole
            whole |= more

    def _phi(self, phi: Phi) -> Iterator[Phi]:
        if phi.id in self._whole or not _is_aggregate(phi.type):
            yield phi
            return
        columns = [self._elements(value, phi.type) for _, value in phi.incoming]
        for number, type_ in enumerate(self._types(phi.type)):
            values = (column[number] for column in columns)
            incoming = tuple(zip((pred for pred, _ in phi.incoming), values, strict=True))
            yield Phi(self._ids(phi.id, number), type_, incoming, phi.loc)

    def _op(self, op: Instr) -> Iterator[Instr]:
        if op.id in self._whole or not (op.op in _PARTS or _is_aggregate(op.type)):
            yield op
        elif op.op == "extractvalue" and not _is_aggregate(op.type):
            self.known[op.id] = self._picked(op)[0]
        elif op.op in _JOINS:
            first = len(op.operands) - len(_aggregates(op))
            columns = [self._elements(arg, op.type) for arg in op.operands[first:]]
            for number, type_ in enumerate(self._types(op.type)):
                args = (*op.operands[:first], *(column[number] for column in columns))
                yield replace(op, id=self._ids(op.id, number), type=type_, operands=args)

    def _elements(self, operand: Value, type_: Kind) -> tuple[Value, ...]:
        """The elements of an aggregate in order."""
        if isinstance(operand, Parts):
            return tuple(self._constants(operand, type_))
        assert isinstance(operand, Named)
        definition = self._definitions[operand.key]
        if isinstance(definition, Instr) and definition.op == "extractvalue":
            return self._picked(definition)
        if isinstance(definition, Instr) and definition.op == "insertvalue":
            return self._inserted(definition)
        return tuple(Ref(self._ids(operand.key, n)) for n in range(len(self._types(type_))))

    def _inserted(self, op: Instr) -> tuple[Value, ...]:
        whole = self._elements(op.operands[0], op.type)
        start, stop = self._span(op.type, op.strides)
        is_aggregate = _is_aggregate(op.source)
        value = self._elements(op.operands[1], op.source) if is_aggregate else (op.operands[1],)
        return (*whole[:start], *value, *whole[stop:])

    def _picked(self, op: Instr) -> tuple[Value, ...]:
        start, stop = self._span(op.source, op.strides)
        return self._elements(op.operands[0], op.source)[start:stop]

    def _span(self, type_: Kind, indices: tuple[int, ...]) -> tuple[int, int]:
        """First and end of the elements at `indices`."""
        start, stop = 0, len(self._types(type_))
        for index in indices:
            inner = self._inner(type_)
            ends = list(accumulate((len(self._types(one)) for one in inner), initial=start))
            type_, start, stop = inner[index], ends[index], ends[index + 1]
        return start, stop

    def _types(self, type_: Kind) -> tuple[str, ...]:
        """Types of the elements, however deep; of what is no aggregate itself; () of too many."""
        if not _is_aggregate(type_):
            return (str(type_),)
        leaves = tuple(leaf for one in self._inner(type_) for leaf in self._types(one))
        return leaves if len(leaves) <= _MOST else ()

    def _inner(self, type_: Kind) -> list[str]:
        text = str(type_)
        array = _ARRAY.fullmatch(text)
        if array is not None:
            return [array[2]] * min(int(array[1]), _MOST + 1)
        return list(members(text, self._structs))

    def _constants(self, parts: Parts, type_: Kind) -> Iterator[Value]:
        """Without values: of an aggregate that is zero, or undefined."""
        if not parts.values:
            for leaf in self._types(type_):
                yield Float(0.0) if leaf in ("float", "double") else Int(0)
            return
        for value, inner in zip(parts.values, self._inner(type_), strict=True):
            if isinstance(value, Parts):
                yield from self._constants(value, inner)
            else:
                yield value


def _is_aggregate(type_: Kind) -> bool:
    return str(type_)[:1] in ("[", "{", "%")


def _aggregates(item: Instr | Phi) -> tuple[Value, ...]:
    """Operands whose elements make those of the result."""
    if isinstance(item, Phi):
        return tuple(value for _, value in item.incoming)
    if item.op == "select":
        return item.operands[1:]
    return item.operands if item.op in _PARTS | {"freeze"} else ()
