"""A kernel of matrix products and of what is done to each element: which parts of arrays they read
and write, as a launch needs to know.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

from vividc.machine.opcodes import OPCODES, Opcode
from vividc.machine.semantics import evaluate
from vividc.machine.words import float_of, signed

ROW, COL, INNER = range(3)
"""Coordinates of a step: of its result, and of the sum."""

AUTO: Final = "auto"
GPU: Final = "gpu"
"""Modes of a kernel besides the TPU-like ones: what is predicted to be best, and on the tiles."""

ENDLESS = 1e15
"""Cycles of what cannot be run: a number that a file can hold."""

LOAD, INPUT, CONST, SUM = "load", "input", "const", "sum"
"""Leaves of expressions; `SUM`: what a product has added up."""


@dataclass(frozen=True, slots=True)
class Size:
    """`constant` plus each factor times a number that the launch gives, by input key."""

    constant: int = 0
    terms: tuple[tuple[str, int], ...] = ()

    def at(self, words: Mapping[str, int]) -> int:
        """The number in a launch with these words."""
        return self.constant + sum(factor * signed(words[key]) for key, factor in self.terms)

    @property
    def text(self) -> str:
        """The sum as it is written."""
        parts = [key if factor == 1 else f"{factor}*{key}" for key, factor in self.terms]
        return "+".join([*parts, *([str(self.constant)] if self.constant or not parts else [])])


@dataclass(frozen=True, slots=True)
class Axis:
    """A subscript: `factor` times a coordinate (-1: none), plus `offset`."""

    coordinate: int
    factor: int
    offset: Size


@dataclass(frozen=True, slots=True)
class View:
    """The elements of a parameter with these subscripts."""

    array: str
    axes: tuple[Axis, ...]

    def swapped(self) -> View:
        """With rows for columns."""
        return replace(
            self, axes=tuple(replace(a, coordinate=_OTHER[a.coordinate]) for a in self.axes)
        )

    @property
    def text(self) -> str:
        """Its name, and whether its first index is not the first of its coordinates."""
        order = [axis.coordinate for axis in self.axes if axis.coordinate >= 0]
        return self.array + ("^T" if order in _TRANSPOSED else "")


_TRANSPOSED = ([INNER, ROW], [COL, INNER], [COL, ROW])
_ARITY = {op.value: info.arity for op, info in OPCODES.items()}
_OTHER = {-1: -1, ROW: COL, COL: ROW, INNER: INNER}


@dataclass(frozen=True, slots=True)
class Term:
    """An expression: an element of `view`, the word of the scalar `key`, the constant `word`, the
    sum, or an operation (an opcode's name) on `args`.
    """

    op: str
    args: tuple[Term, ...] = ()
    view: View | None = None
    key: str = ""
    word: int = 0

    @property
    def views(self) -> Iterator[View]:
        """What it reads."""
        if self.view is not None:
            yield self.view
        for arg in self.args:
            yield from arg.views

    @property
    def is_sound(self) -> bool:
        """Whether it is one of these leaves, or an opcode with as many operands as it has."""
        if self.op in (LOAD, INPUT, CONST, SUM):
            return not self.args and (self.op == LOAD) is (self.view is not None)
        known = self.op in _ARITY and _ARITY[self.op] == len(self.args) > 0
        return known and self.view is None and all(arg.is_sound for arg in self.args)

    @property
    def keys(self) -> Iterator[str]:
        """The scalars that it reads."""
        if self.op == INPUT:
            yield self.key
        for arg in self.args:
            yield from arg.keys

    def swapped(self) -> Term:
        """With rows for columns."""
        view = None if self.view is None else self.view.swapped()
        return replace(self, view=view, args=tuple(arg.swapped() for arg in self.args))

    def with_sum(self, view: View) -> Term:
        """With the sum in place of elements of `view`."""
        if self.view == view:
            return Term(SUM)
        return replace(self, args=tuple(arg.with_sum(view) for arg in self.args))


@dataclass(frozen=True, slots=True)
class Range:
    """A coordinate goes from `first` up to below `limit`."""

    first: Size
    limit: Size


@dataclass(frozen=True, slots=True)
class Edge:
    """Only elements with row * coordinate + col * coordinate + constant >= 0 are computed."""

    row: int
    col: int
    constant: Size


@dataclass(frozen=True, slots=True)
class Elementwise:
    """Each element of `result` becomes `value`."""

    result: View
    value: Term
    ranges: tuple[Range, ...]
    edges: tuple[Edge, ...] = ()
    line: str = ""

    def swapped(self) -> Elementwise:
        """With rows for columns."""
        rows, cols = self.ranges
        edges = tuple(Edge(edge.col, edge.row, edge.constant) for edge in self.edges)
        result, value = self.result.swapped(), self.value.swapped()
        return Elementwise(result, value, (cols, rows), edges, self.line)

    @property
    def terms(self) -> tuple[Term, ...]:
        """All expressions."""
        return (self.value,)

    @property
    def views(self) -> tuple[View, ...]:
        """What it reads."""
        return tuple(self.value.views)


@dataclass(frozen=True, slots=True)
class Product:
    """Each element of `result` becomes `finish` of the sum of `left` * `right` over the inner
    coordinate, in its order, one fused operation after the other, from `start`.

    Attributes
    ----------
    ranges
        Of rows, columns and the inner coordinate.
    line
        Of the sum, in the source.
    """

    left: Term
    right: Term
    result: View
    ranges: tuple[Range, ...]
    start: Term
    finish: Term = Term(SUM)
    edges: tuple[Edge, ...] = ()
    line: str = ""

    def swapped(self) -> Product:
        """The transposed result as the product of the transposed matrices."""
        rows, cols, inner = self.ranges
        return replace(
            self,
            left=self.right.swapped(),
            right=self.left.swapped(),
            result=self.result.swapped(),
            ranges=(cols, rows, inner),
            start=self.start.swapped(),
            finish=self.finish.swapped(),
            edges=tuple(Edge(edge.col, edge.row, edge.constant) for edge in self.edges),
        )

    @property
    def terms(self) -> tuple[Term, ...]:
        """All expressions."""
        return (self.left, self.right, self.start, self.finish)

    @property
    def views(self) -> tuple[View, ...]:
        """What it reads."""
        return tuple(view for term in self.terms for view in term.views)

    @property
    def text(self) -> str:
        """The product as a formula."""
        left, right = (_written(term, around=True) for term in (self.left, self.right))
        total = f"{left} {right}"
        if self.start != Term(CONST):
            total += f" + {_written(self.start)}"
        return f"{self.result.text} = {_written(self.finish, total)}"


_WRITTEN = {
    "fadd": "{} + {}",
    "fsub": "{} - {}",
    "fmul": "{} * {}",
    "fdiv": "{} / {}",
    "fneg": "-{}",
    "fma": "{0} * {1} + {2}",
    "fnma": "{2} - {0} * {1}",
    "fms": "{0} * {1} - {2}",
}


def _written(term: Term, total: str = "", *, around: bool = False) -> str:
    """An expression as text; `around`: it is a factor."""
    leaves = {
        SUM: total,
        LOAD: "" if term.view is None else term.view.text,
        INPUT: term.key,
        CONST: f"{float_of(term.word):g}",
    }
    if term.op in leaves:
        return leaves[term.op]
    positive = positive_part(term)
    if positive is not None:
        return f"max({_written(positive, total)}, 0)"
    args = [_written(arg, f"({total})" if total else "", around=True) for arg in term.args]
    if term.op in _WRITTEN:
        text = _WRITTEN[term.op].format(*args)
        return f"({text})" if around else text
    return f"{term.op}({', '.join(args)})"


Step = Product | Elementwise


def is_mirror(step: Elementwise) -> bool:
    """Whether a step copies one side of the diagonal of a square to the other: c[j, i] = c[i, j]
    for i <= j, or i < j, so that it changes nothing that it reads.
    """
    view = step.value.view
    if view is None or len(step.result.axes) != 2 or step.ranges[ROW] != step.ranges[COL]:  # noqa: PLR2004
        return False
    first, second = step.result.axes
    is_square = (first.coordinate, second.coordinate) == (ROW, COL) and first.factor == 1
    alike = replace(second, coordinate=ROW) == first and view == step.result.swapped()
    return is_square and alike and any(map(_is_one_side, step.edges))


def _is_one_side(edge: Edge) -> bool:
    """Whether no element and its mirror image are both computed, the diagonal aside."""
    no_terms = not edge.constant.terms and edge.constant.constant <= 0
    return no_terms and (edge.row, edge.col) in ((1, -1), (-1, 1))


@dataclass(frozen=True, slots=True)
class Products:
    """All that a kernel does, one step after the other.

    Attributes
    ----------
    strides
        Arrays of two dimensions whose rows are taken to be so long: a launch checks it.
    mode
        "auto", "gpu", "tpu-unified", "tpu-partitioned": as asked for when it was compiled.
    cycles_a_term
        Of a tile in GPU-like mode, for each product of two elements: measured, endless if its
        arrays fit no tile.
    """

    steps: tuple[Step, ...]
    strides: tuple[tuple[str, Size], ...] = ()
    mode: str = "auto"
    cycles_a_term: float = 0.0

    @property
    def products(self) -> tuple[Product, ...]:
        """The steps that are products."""
        return tuple(step for step in self.steps if isinstance(step, Product))

    @property
    def text(self) -> str:
        """The products as formulas."""
        return "; ".join(product.text for product in self.products)

    @property
    def sizes(self) -> Iterator[Size]:
        """All that a launch must be able to compute."""
        yield from (size for _, size in self.strides)
        for step in self.steps:
            yield from (size for one in step.ranges for size in (one.first, one.limit))
            yield from (edge.constant for edge in step.edges)
            for view in (step.result, *step.views):
                yield from (axis.offset for axis in view.axes)


ZERO = Term(CONST)
"""The number 0."""

_ONE, _MINUS_ONE = 0x3F800000, 0xBF800000


def positive_part(term: Term) -> Term | None:
    """x, if an expression is max(x, 0) of numbers."""
    inside = [arg for arg in term.args[1:] if arg != ZERO]
    if term.op != Opcode.SELECT.value or len(inside) != 1:
        return None
    (x,) = inside
    test = term.args[0]
    if not test.op.startswith("fcmp") or any(arg not in (x, ZERO) for arg in test.args):
        return None
    for word, wanted in ((_ONE, _ONE), (_MINUS_ONE, 0), (0, 0)):
        taken = evaluate(Opcode(test.op), [word if arg == x else 0 for arg in test.args])
        if [word if arg == x else 0 for arg in term.args[1:]][1 - taken] != wanted:
            return None
    return x
