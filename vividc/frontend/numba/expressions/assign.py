"""`a[1:-1] = b + c` without an array between: the loops of an array expression that is only
assigned to part of an array run where it is assigned, and store there.

Only where this cannot differ: nothing between the two statements reads or writes an array, and no
operand lies in the array that is assigned to, unless element by element at the same place. Arrays
are told apart by where they come from: parameters of a kernel do not overlap (the launch refuses
that), and what the kernel makes lies beside all others.

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
from numba.core.ir_utils import build_definitions, find_callname, guard
from numba.core.lowering import Lower

from vividc.frontend.numba.expressions.views import views_of

_ITEMS: Final = ("getitem", "static_getitem")
_VIEWS: Final = frozenset({"T", "real", "imag"})
_METHODS: Final = frozenset({"reshape", "transpose", "ravel", "view"})
_MADE: Final = frozenset(
    {"zeros", "ones", "empty", "full", "arange", "zeros_like", "ones_like", "empty_like"}
    | {"full_like", "copy", "linspace", "eye"}
)
_PURE: Final = frozenset({"getattr", "build_tuple", "build_slice", "cast"})
_PARTS: Final = frozenset({"call", "build_tuple", "build_slice"})
"""What indices are made of."""


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
        self._definitions = build_definitions(self._ir.blocks)
        self.later: dict[Any, Any] = {}
        self.nothing: set[Any] = set()
        self.copies: set[Any] = set()
        self.kept: dict[Any, Any] = {}
        self._uses = _counted(self._ir)
        self._here: set[str] = set()
        for block in self._ir.blocks.values():
            for position, one in enumerate(block.body):
                if isinstance(one, ir.SetItem | ir.StaticSetItem):
                    self._plan(block.body[:position], one)

    def view(self, store: Any) -> tuple[Any, Any]:
        """The part of an array that is assigned to, and its type."""
        lowerer, index = self._lowerer, _index_of(store)
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
        return None if views is None else views.part(store.target.name, _index_of(store))

    def _signature(self, store: Any) -> Any:
        typing = self._lowerer.context.typing_context
        kinds = tuple(self._lowerer.typeof(v.name) for v in (store.target, _index_of(store)))
        function = typing.resolve_value_type(operator.getitem)
        return function.get_call_type(typing, kinds, {})

    def _plan(self, before: list[Any], store: Any) -> None:
        if not self._is_part(store):
            return
        self._here = {one.target.name for one in before if isinstance(one, ir.Assign)}
        if self._is_same_part(store.value, store):
            self.nothing.add(store)
            return
        if self._fits([store.value], store) and self._is_apart(store.value, store):
            self.copies.add(store)
        self._plan_expression(before, store)
        if store in self.nothing or store in self.later.values():
            self.copies.discard(store)

    def _plan_expression(self, before: list[Any], store: Any) -> None:
        value = self._only(store.value.name)
        if not isinstance(value, ir.Expr):
            return
        if value.op == "inplace_binop" and self._is_same_part(value.lhs, store):
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
            self._is_apart(operand, store) for operand in value.list_vars()
        ):
            self.later[made] = store

    def _is_part(self, store: Any) -> bool:
        """Whether a store is to a part of an array by slices."""
        index = _index_of(store)
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
        kinds = [types.unliteral(self._lowerer.typeof(var.name)) for var in operands]
        signature = self._signature(store)
        view = None if signature is None else signature.return_type
        return isinstance(view, types.Array) and all(
            isinstance(one, types.Number | types.Boolean)
            or (isinstance(one, types.Array) and one.ndim <= view.ndim)
            for one in kinds
        )

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
        return value.op in _PURE or (numbers and value.op in ("binop", "unary", *_ITEMS))

    def _is_apart(self, operand: Any, store: Any) -> bool:
        """Whether an operand cannot change before all loops have read it."""
        if not isinstance(self._lowerer.typeof(operand.name), types.Array):
            return True
        if self._is_same_part(operand, store):
            return True
        mine, theirs = self._root(operand), self._root(store.target)
        return mine is not None and theirs is not None and mine != theirs

    def _root(self, var: Any) -> object:
        """What an array is part of: a parameter, or where it is made; None if it is not known."""
        for _ in range(_DEEPEST):
            value = self._only(var.name)
            if isinstance(value, ir.Arg):
                return value.index
            if self._is_made(value):
                return var.name
            var = value if isinstance(value, ir.Var) else self._viewed(value)
            if var is None:
                return None
        return None

    def _is_made(self, value: Any) -> bool:
        """Whether an expression is an array of its own."""
        if not isinstance(value, ir.Expr) or value.op != "call":
            return isinstance(value, ir.Expr) and value.op == "arrayexpr"
        called = guard(find_callname, self._ir, value)
        return called is not None and called[1] == "numpy" and called[0] in _MADE

    def _viewed(self, value: Any) -> Any:
        """The array that an expression is a view of; None: it may be none."""
        if not isinstance(value, ir.Expr):
            return None
        if value.op in _ITEMS or (value.op == "getattr" and value.attr in _VIEWS):
            return value.value
        method = self._only(value.func.name) if value.op == "call" else None
        if not isinstance(method, ir.Expr) or getattr(method, "attr", "") not in _METHODS:
            return None
        is_array = isinstance(self._lowerer.typeof(method.value.name), types.Array)
        return method.value if is_array else None

    def _is_same_part(self, var: Any, store: Any) -> bool:
        """Whether an array is the part that is assigned to, element by element."""
        value = self._only(var.name)
        if isinstance(value, ir.Var):
            return self._is_same_part(value, store)
        if self._only(self._alias(store.target)) is None:
            return False
        if isinstance(value, ir.Expr) and value.op in _ITEMS:
            if var.name not in self._here:
                return False  # perhaps of an earlier iteration, where its index was another
            index = value.index if value.op == "getitem" else value.index_var
            base = self._alias(value.value)
            return base == self._alias(store.target) and self._same(index, _index_of(store))
        whole = isinstance(store, ir.StaticSetItem) and store.index == slice(None)
        return whole and self._alias(var) == self._alias(store.target)

    def _alias(self, var: Any) -> str:
        """The variable that another is a copy of."""
        value = self._only(var.name)
        return self._alias(value) if isinstance(value, ir.Var) else str(var.name)

    def _same(self, one: Any, other: Any) -> bool:
        """Whether two indices are equal for sure."""
        if one is None or other is None:
            return False
        mine, theirs = (self._only(self._alias(var)) for var in (one, other))
        if mine is not None and self._alias(one) == self._alias(other):
            return True
        kinds = ir.Const | ir.Global
        if isinstance(mine, kinds) and isinstance(theirs, kinds):
            return bool(mine.value == theirs.value) and type(mine.value) is type(theirs.value)
        if not isinstance(mine, ir.Expr) or not isinstance(theirs, ir.Expr):
            return False
        is_alike = mine.op == theirs.op and mine.op in _PARTS
        if mine.op == theirs.op == "call":
            slices = (guard(find_callname, self._ir, value) for value in (mine, theirs))
            is_alike = all(called == ("slice", "builtins") for called in slices)
        pairs = [*mine.list_vars()], [*theirs.list_vars()]
        return is_alike and len(pairs[0]) == len(pairs[1]) and all(map(self._same, *pairs))

    def _only(self, name: str) -> Any:
        """The only definition of a variable; None if there are several."""
        made = self._definitions.get(name, ())
        return made[0] if len(made) == 1 else None


_DEEPEST: Final = 32
"""Views of views that are looked through."""


def _index_of(store: Any) -> Any:
    return store.index_var if isinstance(store, ir.StaticSetItem) else store.index


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
