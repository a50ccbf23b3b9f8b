"""Runs a kernel's own Python on numbers that count: its operations, and its dataflow floor.

No compiler is asked, so that the figures do not change with it, but for the floors of divisions and
roots, which follow what these expand to:

- An operation is arithmetic on data: on elements of arrays and on float arguments. Index
  arithmetic, loop counters and what is known from sizes count nothing; signs and absolute values
  are free.
- A sum that takes a product is one operation, an FMA, as is a difference (`c - a * b`). A product
  counts by itself if anything but a sum takes it.
- What is computed again from the very same elements, unchanged since, counts once:
  `alpha * a[i, k]` in a loop over j.
- A minimum, a comparison, a division, a root or an exponential are one operation each.

The floor is the longest path to a stored value: every operation as soon as its operands are there,
on as many PEs as it takes, sums in the order of the text, memory and branches free, with the
latencies of the fabric; those of division, root and exponential are the paths through what they
expand to, from each operand.
"""

from __future__ import annotations

import math
import types
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Final

import numpy as np

import vividc
from vividc import arch
from vividc.dfg.builder import GraphBuilder
from vividc.dfg.ir import DFG, Node
from vividc.dfg.order import evaluation_order
from vividc.dfg.pipeline import optimize
from vividc.machine.opcodes import Opcode

FABRIC: Final = "vivid-tile"
Number = int | float


@dataclass(slots=True, eq=False)
class Value:
    """A number of the run: when it is there, and whether it is a product that a sum may yet take.

    `ready`: when a product's own operands are there; None of what is no product, or counted.
    """

    trace: Trace
    number: Number
    time: int = 0
    ready: int | None = None

    __array_ufunc__ = None  # numpy's scalars leave arithmetic with it to this class

    def __add__(self, other: Value | Number) -> Value:
        return self.trace.sum(self, other, 1)

    def __sub__(self, other: Value | Number) -> Value:
        return self.trace.sum(self, other, -1)

    def __rsub__(self, other: Number) -> Value:
        return self.trace.sum(-self, other, 1)

    def __mul__(self, other: Value | Number) -> Value:
        return self.trace.product(self, other)

    def __truediv__(self, other: Value | Number) -> Value:
        return self.trace.apply(Opcode.FDIV, _quotient, self, other)

    def __rtruediv__(self, other: Number) -> Value:
        return self.trace.apply(Opcode.FDIV, _quotient, other, self)

    def __rpow__(self, other: Number) -> Value:
        return self.trace.apply(Opcode.EXP2, lambda power: other**power, self)

    def __neg__(self) -> Value:
        return Value(self.trace, -self.number, self.time, self.ready)

    def __abs__(self) -> Value:
        self.trace.count_product(self)
        return Value(self.trace, abs(self.number), self.time)

    def __lt__(self, other: Value | Number) -> bool:
        return self.trace.compared(self, other) < 0

    def __le__(self, other: Value | Number) -> bool:
        return self.trace.compared(self, other) <= 0

    def __gt__(self, other: Value | Number) -> bool:
        return self.trace.compared(self, other) > 0

    def __eq__(self, other: object) -> bool:
        assert isinstance(other, Value | int | float)
        return self.trace.compared(self, other) == 0

    __hash__ = None  # type: ignore[assignment]  # elements that are equal are not the same

    __radd__ = __add__
    __rmul__ = __mul__

    def __int__(self) -> int:
        return int(self.number)


class Cells:
    """An array of values; a stored value is one of its own from then on."""

    def __init__(self, trace: Trace, array: np.ndarray) -> None:
        self.trace = trace
        self.shape = array.shape
        self.values = [Value(trace, number) for number in array.ravel().tolist()]

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, index: int | tuple[int, ...]) -> Value:
        return self.values[self._place(index)]

    def __setitem__(self, index: int | tuple[int, ...], stored: Value | Number) -> None:
        self.values[self._place(index)] = self.trace.store(stored)

    def _place(self, index: int | tuple[int, ...]) -> int:
        place = 0
        subscripts = index if isinstance(index, tuple) else (index,)
        for subscript, extent in zip(subscripts, self.shape, strict=True):
            if not 0 <= subscript < extent:
                raise IndexError(f"{index} of an array {self.shape}")
            place = place * extent + subscript
        return place


@dataclass
class Trace:
    """What has run so far.

    Attributes
    ----------
    operations
        How many there were.
    floor
        When the last value that was stored is there.
    """

    operations: int = 0
    floor: int = 0
    known: dict[tuple[object, ...], tuple[Value, tuple[Value | Number, ...]]] = field(
        default_factory=dict
    )
    """Results by operation and operands; the operands are kept, so that nothing else gets their
    identity.
    """

    def sum(self, a: Value, b: Value | Number, sign: int) -> Value:
        """a + sign * b."""

        def compute() -> Value:
            number = a.number + sign * _number(b)
            fused = [(p, other) for p, other in ((a, b), (b, a)) if _is_product(p)]
            if not fused:
                return self._result(number, _latency(_kind(a, b, Opcode.FADD, Opcode.ADD)), a, b)
            # Of two products the one that is there last is taken: the other has time.
            product, other = max(fused, key=lambda pair: pair[0].ready)  # type: ignore[union-attr]
            if isinstance(other, Value):
                self.count_product(other)
            self.operations += 1
            assert isinstance(product, Value)
            assert product.ready is not None
            start = max(product.ready, other.time if isinstance(other, Value) else 0)
            return Value(self, number, start + _latency(Opcode.FMA))

        return self._once(("sum", sign), compute, a, b)

    def product(self, a: Value, b: Value | Number) -> Value:
        """a * b; of floats, one that a sum may take."""

        def compute() -> Value:
            number = a.number * _number(b)
            if _kind(a, b, Opcode.FMUL, Opcode.MUL) is Opcode.MUL:
                return self._result(number, _latency(Opcode.MUL), a, b)
            ready = max(self._times(a, b))
            return Value(self, number, ready + _latency(Opcode.FMUL), ready)

        return self._once(("product",), compute, a, b)

    def apply(self, op: Opcode, function: Callable[..., float], *operands: Value | Number) -> Value:
        """An elementary function of floats."""

        def compute() -> Value:
            number = function(*map(_number, operands))
            times = [
                self._times(operand)[0] + path
                for operand, path in zip(operands, paths(op), strict=True)
                if isinstance(operand, Value)
            ]
            self.operations += 1
            return Value(self, number, max(times))

        return self._once((op,), compute, *operands)

    def extreme(
        self, choose: Callable[[Number, Number], Number], *operands: Value | Number
    ) -> Value:
        """The least or the greatest of two."""
        a, b = operands
        chosen = choose(_number(a), _number(b))
        latency = _latency(_kind(a, b, Opcode.FMIN, Opcode.SMIN))
        return self._once((choose,), lambda: self._result(chosen, latency, a, b), a, b)

    def compared(self, a: Value, b: Value | Number) -> float:
        """The sign of a - b; what it decides is free."""
        self._times(a, b)
        self.operations += 1
        return a.number - _number(b)

    def store(self, stored: Value | Number) -> Value:
        """The element that an array holds from now on."""
        (time,) = self._times(stored)
        self.floor = max(self.floor, time)
        return Value(self, _number(stored), time)

    def count_product(self, value: Value) -> None:
        """A product that is used by itself is an operation."""
        if value.ready is not None:
            value.ready = None
            self.operations += 1

    def _result(self, number: Number, latency: int, *operands: Value | Number) -> Value:
        self.operations += 1
        return Value(self, number, max(self._times(*operands)) + latency)

    def _times(self, *operands: Value | Number) -> list[int]:
        """When operands are there; products among them are not taken by a sum."""
        for operand in operands:
            if isinstance(operand, Value):
                self.count_product(operand)
        return [operand.time if isinstance(operand, Value) else 0 for operand in operands]

    def _once(
        self, what: tuple[object, ...], compute: Callable[[], Value], *operands: Value | Number
    ) -> Value:
        names = (id(x) if isinstance(x, Value) else ("constant", float(x)) for x in operands)
        key = (*what, *names)
        if key not in self.known:
            self.known[key] = compute(), operands
        return self.known[key][0]


def traced(kernel: vividc.KernelFunction, arguments: Sequence[object]) -> Trace:
    """The trace of a kernel on arguments, which it leaves as they are."""
    trace = Trace()
    given = [_given(trace, argument) for argument in arguments]
    function = kernel.py_func
    names = {**function.__globals__, **_functions(trace)}
    types.FunctionType(function.__code__, names, closure=function.__closure__)(*given)
    return trace


def _given(trace: Trace, argument: object) -> object:
    if isinstance(argument, np.ndarray):
        return Cells(trace, argument)
    return Value(trace, float(argument)) if isinstance(argument, np.floating) else int(argument)  # type: ignore[call-overload]


def _functions(trace: Trace) -> dict[str, object]:
    """What a kernel calls, on values."""

    def elementary(
        op: Opcode, function: Callable[[float], float]
    ) -> Callable[[Value | Number], Value | Number]:
        return lambda x: trace.apply(op, function, x) if isinstance(x, Value) else function(x)

    def extreme(choose: Callable[[Number, Number], Number]) -> Callable[..., Value]:
        return lambda a, b: trace.extreme(choose, a, b)

    return {
        "math": types.SimpleNamespace(
            sqrt=elementary(Opcode.SQRT, math.sqrt), exp=elementary(Opcode.EXP, math.exp)
        ),
        "np": types.SimpleNamespace(float32=lambda x: x if isinstance(x, Value) else np.float32(x)),
        "min": extreme(min),
        "max": extreme(max),
    }


def _quotient(a: float, b: float) -> float:
    return a / b


def _number(value: Value | Number) -> Number:
    return value.number if isinstance(value, Value) else value


def _is_product(value: Value | Number) -> bool:
    return isinstance(value, Value) and value.ready is not None


def _kind(a: Value | Number, b: Value | Number, floats: Opcode, integers: Opcode) -> Opcode:
    """Which operation it is by the type of its operands."""
    both = (_number(a), _number(b))
    return integers if all(isinstance(number, int) for number in both) else floats


@cache
def _latency(op: Opcode) -> int:
    return arch.load(FABRIC).latency(Node(0, op))


@cache
def paths(op: Opcode) -> tuple[int, ...]:
    """The longest path from each operand of an elementary function to its result, in cycles."""
    builder = GraphBuilder(op.value)
    arity = Node(0, op).info.arity
    operands = [builder.live_in(f"operand{port}") for port in range(arity)]
    result = builder.add(op, operands)
    builder.add_node(Node(0, Opcode.LIVE_OUT, name="%result"), [result])
    graph = optimize(builder.build())
    inputs = [f"operand{port}" for port in range(arity)]
    return tuple(_longest(graph, name) for name in inputs)


def _longest(graph: DFG, source: str) -> int:
    reached: dict[int, int] = {node.id: 0 for node in graph.nodes if node.name == source}
    for number in evaluation_order(graph):
        node = graph.by_id[number]
        before = [reached[edge.src] for edge in graph.in_edges[number] if edge.src in reached]
        if before:
            reached[number] = max(before) + (_latency_of(node) if node.uses_fu else 0)
    return max(reached.values())


def _latency_of(node: Node) -> int:
    return arch.load(FABRIC).latency(node)
