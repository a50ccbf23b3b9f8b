"""Statements of compiled functions, and a function as a whole."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from typing import Final

from vividc.host.machine_code.body import Value, constant
from vividc.host.machine_code.expressions import Expressions
from vividc.host.machine_code.types import INT, Array, Type, parts


class Statements(Expressions):
    """Writes statements into a body."""

    result: Type
    _loops: list[tuple[str, str]]
    """Of each loop around: where `continue` and `break` go."""

    def write(self, parameters: dict[str, Type], result: Type, code: Sequence[ast.stmt]) -> None:
        """Write a whole function: parameters are `%name.0` and so on."""
        self.result, self._loops = result, []
        changed = {
            node.id
            for node in ast.walk(ast.Module([*code], []))
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
        }
        for name, kind in parameters.items():
            value = Value(kind, tuple(f"%{name}.{k}" for k in range(len(parts(kind)))))
            if name in changed:
                self._set(name, value)
            else:
                self.given[name] = value
        self._block(code)
        if not parts(result):
            self.body.end("ret void")
        self.body.end("unreachable")

    def _block(self, code: Sequence[ast.stmt]) -> None:
        for node in code:
            if not self.body.is_open:
                return
            write = getattr(self, f"_{type(node).__name__.lower()}", None)
            if write is None:
                raise TypeError(f"line {node.lineno}: {type(node).__name__} is not compiled")
            try:
                write(node)
            except TypeError as fault:
                if str(fault).startswith("line "):
                    raise
                raise TypeError(f"line {node.lineno}: {fault}") from fault

    # --- variables ---

    def _set(self, name: str, value: Value) -> None:
        """Set a variable; its first value says its type."""
        if name not in self.variables:
            places = tuple(map(self.body.local, parts(value.type)))
            self.variables[name] = value.type, places
        kind, places = self.variables[name]
        value = self.body.converted(value, kind)
        for llvm, part, place in zip(parts(kind), value.parts, places, strict=True):
            self.body.do(f"store {llvm} {part}, ptr {place}")

    def _assign(self, node: ast.Assign) -> None:
        (target,) = node.targets
        self._give(target, self._many(node.value, target))

    def _many(self, node: ast.expr, target: ast.expr) -> Value | list[Value]:
        """What is assigned: of a tuple for a tuple its items, of whatever types."""
        if isinstance(node, ast.Tuple) and isinstance(target, ast.Tuple):
            return [self.value(item) for item in node.elts]
        return self.value(node)

    def _give(self, target: ast.expr, value: Value | list[Value]) -> None:
        if isinstance(target, ast.Tuple):
            items = value if isinstance(value, list) else self.body.items(value)
            for part, item in zip(target.elts, items, strict=True):
                self._give(part, item)
            return
        assert isinstance(value, Value)
        if isinstance(target, ast.Name):
            self._set(target.id, value)
        elif isinstance(target, ast.Subscript):
            dtype, address = self._place(target)
            self.body.write(dtype, address, value)
        else:
            raise TypeError(f"{type(target).__name__} cannot be assigned to")

    def _place(self, target: ast.Subscript) -> tuple[str, str]:
        """Elements and address of what is assigned to."""
        array, indices = self.value(target.value), self.indices(target)
        if not isinstance(array.type, Array) or len(indices) != array.type.rank:
            raise TypeError(f"{len(indices)} indices of {array.type}")
        return array.type.dtype, self.body.element(array, indices)

    def _augassign(self, node: ast.AugAssign) -> None:
        if isinstance(node.target, ast.Name):
            old = self._name(node.target)
            self._set(node.target.id, self.computed(node.op, old, self.value(node.value)))
        elif isinstance(node.target, ast.Subscript):
            dtype, address = self._place(node.target)
            old = self.body.read(dtype, address)
            self.body.write(dtype, address, self.computed(node.op, old, self.value(node.value)))
        else:
            raise TypeError(f"{type(node.target).__name__} cannot be assigned to")

    # --- control ---

    def _expr(self, node: ast.Expr) -> None:
        if not isinstance(node.value, ast.Constant):  # else documentation
            self.value(node.value)

    def _pass(self, _: ast.Pass) -> None:
        pass

    def _return(self, node: ast.Return) -> None:
        kinds = parts(self.result)
        if node.value is None or not kinds:
            self.body.end("ret void")
            return
        value = self.body.converted(self.value(node.value), self.result)
        if len(kinds) == 1:
            self.body.end(f"ret {kinds[0]} {value.text}")
            return
        struct, made = f"{{ {', '.join(kinds)} }}", "poison"
        for place, (kind, part) in enumerate(zip(kinds, value.parts, strict=True)):
            made = self.body.new(f"insertvalue {struct} {made}, {kind} {part}, {place}")
        self.body.end(f"ret {struct} {made}")

    def _if(self, node: ast.If) -> None:
        body = self.body
        yes, no, after = body.labels("then", "else", "endif")
        body.branch(self.truth(node.test), yes, no if node.orelse else after)
        body.start(yes)
        self._block(node.body)
        body.go(after)
        if node.orelse:
            body.start(no)
            self._block(node.orelse)
        body.start(after)

    def _while(self, node: ast.While) -> None:
        self._refuse_else(node.orelse)
        body = self.body
        test, inside, after = body.labels("test", "while", "endwhile")
        body.start(test)
        body.branch(self.truth(node.test), inside, after)
        body.start(inside)
        self._loop(node.body, test, after)
        body.go(test)
        body.start(after)

    def _for(self, node: ast.For) -> None:
        self._refuse_else(node.orelse)
        body = self.body
        first, end, step, array = self._range(node.iter)
        place = body.local("i64")
        body.do(f"store i64 {first}, ptr {place}")
        test, inside, next_, after = body.labels("test", "for", "next", "endfor")
        body.start(test)
        at = body.new(f"load i64, ptr {place}")
        body.branch(body.new(f"icmp {'slt' if step > 0 else 'sgt'} i64 {at}, {end}"), inside, after)
        body.start(inside)
        item = Value(INT, (at,))
        self._give(node.target, item if array is None else self.element(array, [item]))
        self._loop(node.body, next_, after)
        body.start(next_)
        body.do(f"store i64 {body.new(f'add nsw i64 {at}, {step}')}, ptr {place}")
        body.go(test)
        body.start(after)

    def _loop(self, code: Sequence[ast.stmt], again: str, after: str) -> None:
        self._loops.append((again, after))
        self._block(code)
        self._loops.pop()

    def _range(self, node: ast.expr) -> tuple[str, str, int, Value | None]:
        """First number, end, step, and the array whose items these number."""
        if isinstance(node, ast.Call) and self.static(node.func) is range:
            given = [self.value(item) for item in node.args]
            first, end = given[:2] if len(given) > 1 else (constant(0), given[0])
            step = given[2].number if len(given) > _WITHOUT_STEP else 1
            if not isinstance(step, int) or not step:
                raise TypeError("a step that is not known")
            ends = [self.body.converted(value, INT).text for value in (first, end)]
            return ends[0], ends[1], step, None
        array = self.value(node)
        if not isinstance(array.type, Array):
            raise TypeError(f"a loop over {array.type}")
        return "0", array.parts[1], 1, array

    @staticmethod
    def _refuse_else(code: Sequence[ast.stmt]) -> None:
        if code:
            raise TypeError("else of a loop is not compiled")

    def _continue(self, _: ast.Continue) -> None:
        self.body.go(self._loops[-1][0])

    def _break(self, _: ast.Break) -> None:
        self.body.go(self._loops[-1][1])

    def lines(self) -> Iterator[str]:
        """The function's body."""
        yield "entry:"
        yield from self.body.locals
        yield from self.body.lines


_WITHOUT_STEP: Final = 2
