"""Texts of exceptions that say numbers, `raise ValueError(f"element {i} is {x[i]}")`: the array has
no strings, so that the run keeps the numbers, and the host writes the text.

Numba adds strings up before it raises; here their constant parts become one text with places.
"""

from __future__ import annotations

import operator
from collections.abc import Iterator
from typing import Any, Final

from numba.core import ir, rewrites
from numba.core.ir_utils import find_const, get_definition, guard
from numba.core.target_extension import current_target

from vividc.frontend.numba.expressions.inplace import TARGET_NAME
from vividc.ssa.results import PLACE

_ADDED: Final = (operator.add, operator.iadd)
_Parts = list[Any]
"""Of a text: strings and numba's variables."""


class Text(str):
    """A text that has `PLACE` for each number that it says."""

    __slots__ = ()


@rewrites.register_rewrite("before-inference")
class _Texts(rewrites.Rewrite):  # type: ignore[misc]
    """Makes of a raise one with a `Text` and the numbers."""

    def match(self, func_ir: Any, block: Any, *_: Any) -> bool:
        """Whether the block ends with a raise whose text says numbers, and nothing else uses it."""
        self._block, self._blocks = block, func_ir.blocks
        last = block.body[-1]
        if current_target() != TARGET_NAME or not isinstance(last, ir.Raise):
            return False
        made = guard(get_definition, func_ir, last.exception) if last.exception else None
        if not isinstance(made, ir.Expr) or made.op != "call" or made.kws or not made.args:
            return False
        self._kind = guard(find_const, func_ir, made.func)
        if not (isinstance(self._kind, type) and issubclass(self._kind, Exception)):
            return False
        self._gone = {last.exception.name, made.func.name}
        self._parts = self._said(func_ir, made.args)
        numbers = [part for part in self._parts if isinstance(part, ir.Var)]
        if not numbers or any(map(self._uses, self._statements())):
            return False
        return not any(self._is_changed(func_ir, number) for number in numbers)

    def _is_changed(self, func_ir: Any, number: Any) -> bool:
        """Whether a number may be another one at the raise than when the text was made."""
        if len(func_ir._definitions.get(number.name, ())) <= 1:
            return False
        body = self._block.body
        made = [at for at, s in enumerate(body) if self._is_gone(s)]
        if len(made) < sum(map(self._is_gone, self._statements())):  # in other blocks, too
            return True
        later = body[min(made) :]
        return any(isinstance(s, ir.Assign) and s.target.name == number.name for s in later)

    def _statements(self) -> Iterator[Any]:
        """All others."""
        for block in self._blocks.values():
            yield from (s for s in block.body if s is not self._block.body[-1])

    def _uses(self, statement: Any) -> bool:
        """Whether a statement that stays uses a piece of the text."""
        used = isinstance(statement, ir.Del) or self._is_gone(statement)
        return not used and any(var.name in self._gone for var in statement.list_vars())

    def _said(self, func_ir: Any, args: list[Any]) -> _Parts:
        """What Python would print of the exception."""
        if len(args) == 1:
            return self._pieces(func_ir, args[0])
        said: _Parts = ["("]
        for arg in args:
            constant = guard(find_const, func_ir, arg)
            said += [", "] * (len(said) > 1)
            said.append(arg if constant is None else repr(constant))
        return [*said, ")"]

    def _pieces(self, func_ir: Any, var: Any) -> _Parts:
        """The pieces of a string, or a variable that is none that is made here."""
        copies, made = _behind_copies(func_ir, var)
        constant = guard(find_const, func_ir, var)
        if isinstance(constant, str):
            self._gone.add(var.name)
            return [constant]
        if isinstance(made, ir.Expr) and made.op == "binop" and made.fn in _ADDED:
            pieces = [*self._pieces(func_ir, made.lhs), *self._pieces(func_ir, made.rhs)]
            if any(isinstance(piece, str) for piece in pieces):
                self._gone.update(copies)
                return pieces
        is_call = isinstance(made, ir.Expr) and made.op == "call" and len(made.args) == 1
        if is_call and guard(find_const, func_ir, made.func) is str:
            self._gone.update((*copies, made.func.name))
            return [made.args[0]]
        return [var]

    def apply(self) -> Any:
        """The block with it."""
        text = Text("".join(part if isinstance(part, str) else PLACE for part in self._parts))
        numbers = [part for part in self._parts if isinstance(part, ir.Var)]
        last = self._block.body[-1]
        changed = self._block.copy()
        for block in (*self._blocks.values(), changed):
            block.body = [s for s in block.body if not self._is_gone(s)]
        changed.body[-1] = ir.DynamicRaise(self._kind, (text, *numbers), last.loc)
        return changed

    def _is_gone(self, statement: Any) -> bool:
        return isinstance(statement, ir.Assign) and statement.target.name in self._gone


def _behind_copies(func_ir: Any, var: Any) -> tuple[list[str], Any]:
    """What a variable was made as, None if it was several times, and the variables on the way."""
    names = [var.name]
    while True:
        made = func_ir._definitions.get(names[-1], ())
        if len(made) != 1:
            return names, None
        if not isinstance(made[0], ir.Var):
            return names, made[0]
        names.append(made[0].name)
