"""Expressions of compiled functions."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from types import FunctionType, ModuleType
from typing import Any, Final, Protocol

from vividc.host.machine_code.body import Body, Value, constant
from vividc.host.machine_code.types import (
    FLOAT,
    INT,
    TRUTH,
    Array,
    Number,
    Record,
    Type,
    parts,
    type_of,
)


class Callee(Protocol):
    """A function that compiled ones call."""

    @property
    def symbol(self) -> str:
        """Its name in the module."""

    @property
    def parameters(self) -> dict[str, Type]:
        """Types by name."""

    @property
    def result(self) -> Type:
        """What it returns."""


_INTEGER: Final = {
    ast.Add: "add",
    ast.Sub: "sub",
    ast.Mult: "mul",
    ast.LShift: "shl",
    ast.RShift: "ashr",
    ast.BitAnd: "and",
    ast.BitOr: "or",
    ast.BitXor: "xor",
}
_FLOATING: Final = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}
_FOLDED: Final[dict[type, Callable[[Any, Any], Any]]] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.LShift: lambda a, b: a << b,
    ast.Div: lambda a, b: a / b,
}
_COMPARED: Final = {
    ast.Eq: ("eq", "oeq"),
    ast.NotEq: ("ne", "une"),
    ast.Lt: ("slt", "olt"),
    ast.LtE: ("sle", "ole"),
    ast.Gt: ("sgt", "ogt"),
    ast.GtE: ("sge", "oge"),
}
_INTRINSICS: Final = {math.log: "llvm.log.f64", math.exp: "llvm.exp.f64"}
_OF_PYTHON: Final[dict[str, object]] = {
    "range": range,
    "min": min,
    "max": max,
    "len": len,
    "int": int,
    "float": float,
    "bool": bool,
}


class Expressions:
    """Writes expressions into a body.

    Parameters
    ----------
    function
        Where names are looked up that are no variables.
    callee
        The compiled function behind one of Python's, or None.
    """

    def __init__(
        self, function: FunctionType, callee: Callable[[FunctionType], Callee | None], body: Body
    ) -> None:
        self.body = body
        self.variables: dict[str, tuple[Type, tuple[str, ...]]] = {}
        self.given: dict[str, Value] = {}
        self._function, self._callee = function, callee

    def value(self, node: ast.expr) -> Value:
        """What an expression computes.

        Raises
        ------
        TypeError
            It is none of those that are compiled.
        """
        write = getattr(self, f"_{type(node).__name__.lower()}", None)
        if write is None:
            raise TypeError(f"{type(node).__name__} is not compiled")
        found: Value = write(node)
        return found

    def truth(self, node: ast.expr) -> str:
        """Whether an expression is true, as i1."""
        if isinstance(node, ast.BoolOp):
            return self._boolop(node).text
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            return self.body.new(f"xor i1 {self.truth(node.operand)}, true")
        return self.true(self.value(node))

    def true(self, value: Value) -> str:
        """Whether a number is not 0."""
        if value.type == TRUTH:
            return value.text
        return self._compared(ast.NotEq(), value, constant(0)).text

    # --- names ---

    def static(self, node: ast.expr) -> Any:
        """What a name means that is no variable; None: it is one, or no name."""
        if isinstance(node, ast.Name) and not self._is_variable(node.id):
            return self._function.__globals__.get(node.id, _OF_PYTHON.get(node.id))
        if isinstance(node, ast.Attribute):
            owner = self.static(node.value)
            return getattr(owner, node.attr) if isinstance(owner, ModuleType) else None
        return None

    def _is_variable(self, name: str) -> bool:
        return name in self.variables or name in self.given

    def _name(self, node: ast.Name) -> Value:
        if node.id in self.given:
            return self.given[node.id]
        if node.id in self.variables:
            kind, places = self.variables[node.id]
            return self.load(kind, places)
        return constant(self.static(node))

    def load(self, kind: Type, places: tuple[str, ...]) -> Value:
        """A local variable."""
        pairs = zip(parts(kind), places, strict=True)
        return Value(kind, tuple(self.body.new(f"load {llvm}, ptr {at}") for llvm, at in pairs))

    def _attribute(self, node: ast.Attribute) -> Value:
        known = self.static(node)
        if known is not None:
            return constant(known)
        owner = self.value(node.value)
        if not isinstance(owner.type, Record) or node.attr not in owner.type.names:
            raise TypeError(f"{node.attr} of {owner.type}")
        return self.body.item(owner, owner.type.names.index(node.attr))

    # --- values ---

    def _constant(self, node: ast.Constant) -> Value:
        return constant(node.value)  # type: ignore[arg-type]

    def _tuple(self, node: ast.Tuple) -> Value:
        return self._grouped([self.value(item) for item in node.elts])

    def _grouped(self, items: list[Value]) -> Value:
        kind = Record(("",) * len(items), tuple(item.type for item in items))
        if kind.is_stored:
            raise TypeError("a tuple with arrays is made by Python only")
        return Value(kind, tuple(part for item in items for part in item.parts))

    def indices(self, node: ast.Subscript) -> list[Value]:
        """The indices of an element."""
        items = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        return [self.value(item) for item in items]

    def _subscript(self, node: ast.Subscript) -> Value:
        if isinstance(node.value, ast.Attribute) and node.value.attr == "shape":
            array, which = self.value(node.value.value), self.value(node.slice)
            return Value(INT, (array.parts[1 + int(which.number or 0)],))
        owner = self.value(node.value)
        if isinstance(owner.type, Record):
            return self.body.item(owner, int(self.indices(node)[0].number or 0))
        return self.element(owner, self.indices(node))

    def element(self, array: Value, indices: list[Value]) -> Value:
        """An element of an array, or a row of it."""
        if not isinstance(array.type, Array) or len(indices) > array.type.rank:
            raise TypeError(f"{len(indices)} indices of {array.type}")
        address, left = self.body.element(array, indices), array.type.rank - len(indices)
        if not left:
            return self.body.read(array.type.dtype, address)
        return Value(Array(array.type.dtype, left), (address, *array.parts[1 + len(indices) :]))

    def _ifexp(self, node: ast.IfExp) -> Value:
        body = self.body
        yes, no, after = body.labels("then", "else", "both")
        body.branch(self.truth(node.test), yes, no)
        body.start(yes)
        one, one_end = self.value(node.body), body.block
        body.go(after)
        body.start(no)
        other, other_end = self.value(node.orelse), body.block
        body.start(after)
        if one.type != other.type or not isinstance(one.type, Number):
            raise TypeError(f"{one.type} or {other.type}")
        phi = f"phi {one.type.llvm} [ {one.text}, %{one_end} ], [ {other.text}, %{other_end} ]"
        return Value(one.type, (body.new(phi),))

    def _boolop(self, node: ast.BoolOp) -> Value:
        body = self.body
        (after,) = body.labels("known")
        is_and = isinstance(node.op, ast.And)
        ends = []
        for item in node.values[:-1]:
            truth = self.truth(item)
            ends.append(f"[ {'false' if is_and else 'true'}, %{body.block} ]")
            (more,) = body.labels("more")
            body.branch(truth, *((more, after) if is_and else (after, more)))
            body.start(more)
        last = self.truth(node.values[-1])
        ends.append(f"[ {last}, %{body.block} ]")
        body.start(after)
        return Value(TRUTH, (body.new(f"phi i1 {', '.join(ends)}"),))

    # --- arithmetic ---

    def _unaryop(self, node: ast.UnaryOp) -> Value:
        if isinstance(node.op, ast.Not):
            return Value(TRUTH, (self.truth(node),))
        if not isinstance(node.op, ast.USub):
            raise TypeError(f"{type(node.op).__name__} is not compiled")
        value = self.value(node.operand)
        if value.number is not None:
            return constant(-value.number)
        if value.type in (INT, TRUTH):
            return self.computed(ast.Sub(), constant(0), value)
        assert isinstance(value.type, Number)
        return Value(value.type, (self.body.new(f"fneg {value.type.llvm} {value.text}"),))

    def _binop(self, node: ast.BinOp) -> Value:
        return self.computed(node.op, self.value(node.left), self.value(node.right))

    def computed(self, op: ast.operator, a: Value, b: Value) -> Value:
        """An operation on two numbers."""
        kind = type(op)
        if a.number is not None and b.number is not None and kind in _FOLDED:
            return constant(_FOLDED[kind](a.number, b.number))
        if kind is ast.Div and FLOAT not in (a.type, b.type):
            a, b = self.body.converted(a, FLOAT), self.body.converted(b, FLOAT)
        a, b = self._alike(a, b)
        if a.type == INT and kind in (ast.FloorDiv, ast.Mod):
            return self._divided(a, b, remainder=kind is ast.Mod)
        name = (_INTEGER if a.type == INT else _FLOATING).get(kind)
        if name is None:
            raise TypeError(f"{kind.__name__} of {a.type}")
        assert isinstance(a.type, Number)
        return Value(a.type, (self.body.new(f"{name} {a.type.llvm} {a.text}, {b.text}"),))

    def _alike(self, a: Value, b: Value) -> tuple[Value, Value]:
        """Two numbers as those of one type, at least integers."""
        if FLOAT in (a.type, b.type):
            return self.body.converted(a, FLOAT), self.body.converted(b, FLOAT)
        if a.type == b.type and a.type != TRUTH:
            return a, b
        return self.body.converted(a, INT), self.body.converted(b, INT)

    def _divided(self, a: Value, b: Value, *, remainder: bool) -> Value:
        """Quotient or remainder, rounded down; nothing is divided by 0."""
        body, by = self.body, b.number
        if isinstance(by, int) and by > 0 and not by & (by - 1):
            text = f"and i64 {a.text}, {by - 1}"
            if not remainder:
                text = f"ashr i64 {a.text}, {by.bit_length() - 1}"
            return Value(INT, (body.new(text),))
        rest = body.new(f"srem i64 {a.text}, {b.text}")
        mixed = body.new(f"xor i64 {rest}, {b.text}")
        opposed = body.new(f"icmp slt i64 {mixed}, 0")
        some = body.new(f"icmp ne i64 {rest}, 0")
        below = body.new(f"and i1 {some}, {opposed}")
        if remainder:
            more = body.new(f"add i64 {rest}, {b.text}")
            return Value(INT, (body.new(f"select i1 {below}, i64 {more}, i64 {rest}"),))
        whole = body.new(f"sdiv i64 {a.text}, {b.text}")
        less = body.new(f"sext i1 {below} to i64")
        return Value(INT, (body.new(f"add i64 {whole}, {less}"),))

    def _compare(self, node: ast.Compare) -> Value:
        """One comparison, or a chain of them: all operands are numbers, which cost nothing."""
        items = [self.value(item) for item in (node.left, *node.comparators)]
        found = [
            self._compared(op, a, b)
            for op, a, b in zip(node.ops, items[:-1], items[1:], strict=True)
        ]
        both = found[0].text
        for other in found[1:]:
            both = self.body.new(f"and i1 {both}, {other.text}")
        return Value(TRUTH, (both,))

    def _compared(self, op: ast.cmpop, a: Value, b: Value) -> Value:
        integer, floating = _COMPARED[type(op)]
        a, b = self._alike(a, b)
        how = f"icmp {integer}" if a.type == INT else f"fcmp {floating}"
        assert isinstance(a.type, Number)
        return Value(TRUTH, (self.body.new(f"{how} {a.type.llvm} {a.text}, {b.text}"),))

    # --- calls ---

    def _call(self, node: ast.Call) -> Value:
        if isinstance(node.func, ast.Attribute) and node.func.attr == "bit_length":
            return self._bit_length(self.value(node.func.value))
        called = self.static(node.func)
        if isinstance(called, type) and hasattr(called, "_fields"):
            record = type_of(called)
            assert isinstance(record, Record)
            given = self._arguments(node, dict(zip(record.names, record.fields, strict=True)))
            return Value(record, tuple(part for value in given for part in value.parts))
        callee = self._callee(called) if isinstance(called, FunctionType) else None
        callee = callee or self._callee(getattr(called, "py_func", None))  # type: ignore[arg-type]
        if callee is not None:
            return self._calls(callee, self._arguments(node, callee.parameters))
        return self._builtin(called, [self.value(item) for item in node.args])

    def _arguments(self, node: ast.Call, parameters: dict[str, Type]) -> list[Value]:
        named = dict(zip(parameters, node.args, strict=False))
        named |= {keyword.arg or "": keyword.value for keyword in node.keywords}
        if named.keys() != parameters.keys():
            raise TypeError(f"arguments {', '.join(named)} for {', '.join(parameters)}")
        values = {name: self.value(item) for name, item in named.items()}
        return [self.body.converted(values[name], kind) for name, kind in parameters.items()]

    def _calls(self, callee: Callee, given: list[Value]) -> Value:
        texts = [
            f"{llvm} {part}"
            for value in given
            for llvm, part in zip(parts(value.type), value.parts, strict=True)
        ]
        returned = parts(callee.result)
        call = f'@"{callee.symbol}"({", ".join(texts)})'
        if not returned:
            self.body.do(f"call void {call}")
            return Value(callee.result, ())
        if len(returned) == 1:
            return Value(callee.result, (self.body.new(f"call {returned[0]} {call}"),))
        struct = f"{{ {', '.join(returned)} }}"
        made = self.body.new(f"call {struct} {call}")
        items = [
            self.body.new(f"extractvalue {struct} {made}, {place}")
            for place in range(len(returned))
        ]
        return Value(callee.result, tuple(items))

    def _builtin(self, called: object, given: list[Value]) -> Value:
        if called in (min, max):
            return self._chosen(given, ast.Lt() if called is min else ast.Gt())
        (value,) = given
        if called in _INTRINSICS:
            text = self.body.converted(value, FLOAT).text
            call = f"call double @{_INTRINSICS[called]}(double {text})"
            return Value(FLOAT, (self.body.new(call),))
        if called is len and isinstance(value.type, Array):
            return Value(INT, (value.parts[1],))
        if called is bool:
            return Value(TRUTH, (self.true(value),))
        if called is float:
            return self.body.converted(value, FLOAT)
        if called is int:
            return self.body.converted(value, INT)
        raise TypeError(f"a call of {called!r}")

    def _bit_length(self, value: Value) -> Value:
        """Bits of an integer without its sign."""
        text = self.body.converted(value, INT).text
        size = self.body.new(f"call i64 @llvm.abs.i64(i64 {text}, i1 false)")
        free = self.body.new(f"call i64 @llvm.ctlz.i64(i64 {size}, i1 false)")
        return Value(INT, (self.body.new(f"sub i64 64, {free}"),))

    def _chosen(self, given: list[Value], op: ast.cmpop) -> Value:
        """The first of the least or greatest."""
        best = given[0]
        for other in given[1:]:
            one, two = self._alike(best, other)
            better = self._compared(op, two, one).text
            assert isinstance(one.type, Number)
            llvm = one.type.llvm
            text = f"select i1 {better}, {llvm} {two.text}, {llvm} {one.text}"
            best = Value(one.type, (self.body.new(text),))
        return best
