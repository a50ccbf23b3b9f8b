"""`a[1:-1] = b + c` without an array between: the loops of an array expression that is only
assigned to part of an array run where it is assigned, and store there.

Only where this cannot differ: nothing between the two statements reads or writes an array, and no
operand lies in the array that is assigned to, unless element by element at the same place
(`origins`).

`a[i:j] += x` stores the part to itself behind the addition: that is left out.
"""

from __future__ import annotations

import operator
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from typing import Any, Final

from numba.core import ir, types
from numba.core.ir_utils import find_callname, guard
from numba.core.lowering import Lower

from vividc.frontend.numba.expressions.origins import ITEMS, Origins, fit, index_of
from vividc.frontend.numba.expressions.views import views_of

_PURE: Final = frozenset({"getattr", "build_tuple", "build_slice", "cast"})


@dataclass
class Deferral:
    """Where `loops.ufunc_loops` leaves what it would do, in a statement that is computed later."""

    taken: list[Callable[[Any, Any, Any], None]] = field(default_factory=list)


Copy = Callable[[Any, Any, Any, Any, Any], Callable[[Any, Any, Any], None]]
"""Of numba's context and builder, a value, its type and what it selects, if that is known."""

deferral: ContextVar[Deferral | None] = ContextVar("deferral", default=None)
"""Set while an expression is lowered whose loops run later."""


@contextmanager
def assigned_in_place(py_func: Callable[..., Any], copied: Copy) -> Iterator[None]:
    """Lower the array expressions of `py_func` where they are assigned; `copied`: the loops that
    store an array or a number to a part of an array.
    """
    lower_inst = Lower.lower_inst
    plans: dict[Any, _Plan] = {}

    def lower(lowerer: Any, inst: Any) -> None:
        if lowerer.func_ir.func_id.func is not py_func:
            lower_inst(lowerer, inst)
            return
        if lowerer not in plans:
            plans[lowerer] = _Plan(lowerer)
        plan = plans[lowerer]
        if inst in plan.nothing:
            return
        if inst in plan.later:
            kept = deferral.set(Deferral())
            try:
                lower_inst(lowerer, inst)
                plan.kept[plan.later[inst]] = deferral.get()
            finally:
                deferral.reset(kept)
            return
        kept_loops = plan.kept.pop(inst, None)
        run = kept_loops.taken[0] if kept_loops is not None and kept_loops.taken else None
        if inst in plan.copies:
            run = plan.copy(inst, copied)
        if run is None:
            lower_inst(lowerer, inst)
            return
        lowerer.debuginfo.mark_location(lowerer.builder, lowerer.loc.line)
        run(*plan.view(inst), plan.selected(inst))

    Lower.lower_inst = lower
    try:
        yield
    finally:
        Lower.lower_inst = lower_inst


class _Plan:
    """What of a function's statements is lowered elsewhere.

    `later`: assignments of expressions, and where each is stored; `nothing`: stores of what is
    there already; `copies`: stores of arrays that lie elsewhere, and of numbers; `kept`: the loops
    to run, by store.
    """

    def __init__(self, lowerer: Any) -> None:
        self._lowerer = lowerer
        self._ir = lowerer.func_ir
        self._origins = Origins(self._ir, lowerer.typeof)
        self.later: dict[Any, Any] = {}
        self.nothing: set[Any] = set()
        self.copies: set[Any] = set()
        self.kept: dict[Any, Any] = {}
        self._uses = _counted(self._ir)
        for block in self._ir.blocks.values():
            for position, one in enumerate(block.body):
                if isinstance(one, ir.SetItem | ir.StaticSetItem):
                    self._plan(block.body[:position], one)

    def view(self, store: Any) -> tuple[Any, Any]:
        """The part of an array that is assigned to, and its type."""
        lowerer, index = self._lowerer, index_of(store)
        signature = self._signature(store)
        function = lowerer.context.typing_context.resolve_value_type(operator.getitem)
        implementation = lowerer.context.get_function(function, signature)
        args = [lowerer.loadvar(var.name) for var in (store.target, index)]
        kinds = [lowerer.typeof(var.name) for var in (store.target, index)]
        args = [
            lowerer.context.cast(lowerer.builder, arg, kind, wanted)
            for arg, kind, wanted in zip(args, kinds, signature.args, strict=True)
        ]
        return implementation(lowerer.builder, args), signature.return_type

    def copy(self, store: Any, copied: Copy) -> Callable[[Any, Any, Any], None]:
        """The loops that store a value."""
        lowerer, name = self._lowerer, store.value.name
        views = views_of(lowerer)
        given = None if views is None else views.of(name)
        kind = types.unliteral(lowerer.typeof(name))
        return copied(lowerer.context, lowerer.builder, lowerer.loadvar(name), kind, given)

    def selected(self, store: Any) -> Any:
        """What is known of the part that is assigned to: a view, or None."""
        views = views_of(self._lowerer)
        return None if views is None else views.part(store.target.name, index_of(store))

    def _signature(self, store: Any) -> Any:
        typing = self._lowerer.context.typing_context
        kinds = tuple(self._lowerer.typeof(v.name) for v in (store.target, index_of(store)))
        function = typing.resolve_value_type(operator.getitem)
        return function.get_call_type(typing, kinds, {})

    def _plan(self, before: list[Any], store: Any) -> None:
        if not self._is_part(store):
            return
        self._origins.here = {one.target.name for one in before if isinstance(one, ir.Assign)}
        if self._origins.is_same_part(store.value, store):
            self.nothing.add(store)
            return
        if self._fits([store.value], store) and self._origins.is_apart(store.value, store):
            self.copies.add(store)
        self._plan_expression(before, store)
        if store in self.nothing or store in self.later.values():
            self.copies.discard(store)

    def _plan_expression(self, before: list[Any], store: Any) -> None:
        value = self._origins.only(store.value.name)
        if not isinstance(value, ir.Expr):
            return
        if value.op == "inplace_binop" and self._origins.is_same_part(value.lhs, store):
            self.nothing.add(store)
            return
        if value.op != "arrayexpr" or self._uses[store.value.name] != 1:
            return
        for made in reversed(before):
            if isinstance(made, ir.Assign) and made.value is value:
                break
            if not self._is_pure(made):
                return
        else:
            return
        if self._fits([*value.list_vars(), store.value], store) and all(
            self._origins.is_apart(operand, store) for operand in value.list_vars()
        ):
            self.later[made] = store

    def _is_part(self, store: Any) -> bool:
        """Whether a store is to a part of an array by slices."""
        index = index_of(store)
        if index is None or not isinstance(self._lowerer.typeof(store.target.name), types.Array):
            return False
        kind = self._lowerer.typeof(index.name)
        parts = tuple(kind) if isinstance(kind, types.BaseTuple) else (kind,)
        slices = (types.SliceType, types.EllipsisType)
        return any(isinstance(part, slices) for part in parts) and all(
            isinstance(part, (*slices, types.Integer)) for part in parts
        )

    def _fits(self, operands: list[Any], store: Any) -> bool:
        """Whether all operands are arrays and numbers, of no more dimensions than the part."""
        kinds = [self._lowerer.typeof(var.name) for var in operands]
        signature = self._signature(store)
        view = None if signature is None else signature.return_type
        return isinstance(view, types.Array) and fit(kinds, view.ndim)

    def _is_pure(self, statement: Any) -> bool:
        """Whether a statement leaves arrays alone, and what is computed from them."""
        if isinstance(statement, ir.Del):
            return True
        value = getattr(statement, "value", None)
        if not isinstance(statement, ir.Assign):
            return False
        if isinstance(value, ir.Const | ir.Global | ir.FreeVar | ir.Var):
            return True
        if not isinstance(value, ir.Expr):
            return False
        numbers = not isinstance(self._lowerer.typeof(statement.target.name), types.Array)
        if value.op == "call":
            return bool(guard(find_callname, self._ir, value) == ("slice", "builtins"))
        return value.op in _PURE or (numbers and value.op in ("binop", "unary", *ITEMS))


def _counted(func_ir: Any) -> dict[str, int]:
    """How often each variable is read."""
    uses: dict[str, int] = defaultdict(int)
    for block in func_ir.blocks.values():
        for one in block.body:
            if isinstance(one, ir.Del):
                continue
            for var in one.list_vars():
                uses[var.name] += 1
            if isinstance(one, ir.Assign):
                uses[one.target.name] -= 1
    return uses
