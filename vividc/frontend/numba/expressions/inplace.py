"""`B += A * 2` on arrays as `B[:] = B + A * 2`, whose loops need no array between (`assign`).

Only where both compute the same: sums, differences, products and quotients of floats, and what
integers of 32 bits and more wrap alike. Only where no operand may overlap B at another place, or
the array between would be of all operands' shape, not of A's. `B += A` stays as it is: numba adds
in the order of the elements, also where A overlaps B.
"""

from __future__ import annotations

import operator
from typing import Any, Final

from numba.core import ir, types
from numba.core.rewrites import Rewrite, register_rewrite
from numba.core.typing.npydecl import supported_array_operators

from vividc.frontend.numba.expressions.origins import Origins, fit

TARGET_NAME = "vividc"
_FLOAT: Final = frozenset({operator.add, operator.sub, operator.mul, operator.truediv})
_INTEGER: Final = frozenset(
    {operator.add, operator.sub, operator.mul, operator.and_, operator.or_, operator.xor}
)
_WHOLE_BITS: Final = 32


@register_rewrite("after-inference")
class ExpressionsInPlace(Rewrite):  # type: ignore[misc]
    """Numba's interface to a change of its typed statements; of our target's only."""

    def __init__(self, state: Any) -> None:
        super().__init__(state)
        context = state.targetctx
        self._is_ours = getattr(context, "target_name", "") == TARGET_NAME
        self._typing = state.typingctx

    def match(self, func_ir: Any, block: Any, typemap: Any, calltypes: Any) -> bool:
        """Whether there is a statement to change; the first one is changed."""
        self._ir, self._block, self._types, self._calls = func_ir, block, typemap, calltypes
        if not self._is_ours:
            return False
        self._at = next((n for n, one in enumerate(block.body) if self._fits(one, n)), -1)
        return self._at >= 0

    def apply(self) -> Any:
        """The block with an array expression, a store of it and a copy instead."""
        body, at = self._block.body, self._at
        made, loc = body[at].value, body[at].loc
        first = self._expression(made.rhs, at)
        assert first is not None
        kind, operands = self._kind(made), [made.lhs, _tree_of(body[first].value)]
        expr = ir.Expr("arrayexpr", loc, expr=(made.immutable_fn, operands), ty=kind)
        result = self._new("$inplace", kind, expr, loc)
        whole = self._whole(loc)
        index = whole[-1].target
        store = ir.StaticSetItem(made.lhs, slice(None), index, result.target, loc)
        into, by = self._types[made.lhs.name], self._types[index.name]
        self._calls[store] = self._typing.resolve_setitem(into, by, kind)
        copy = ir.Assign(made.lhs, body[at].target, loc)
        dropped = body[first].target.name
        rest = [
            one for one in body[at + 1 :] if not (isinstance(one, ir.Del) and one.value == dropped)
        ]
        block = self._block.copy()
        between = body[first + 1 : at]
        block.body = [*body[:first], *whole, result, store, copy, *between, *rest]
        return block

    def _whole(self, loc: Any) -> list[Any]:
        """Statements that make `slice(None, None)`, the last one of it."""
        nothing = self._new("$none", types.none, ir.Const(None, loc), loc)
        kind = self._typing.resolve_value_type(slice)
        called = self._new("$slice", kind, ir.Global("slice", slice, loc), loc)
        bounds = (nothing.target, nothing.target)
        call = ir.Expr.call(called.target, bounds, (), loc)
        self._calls[call] = kind.get_call_type(self._typing, (types.none, types.none), {})
        return [nothing, called, self._new("$whole", types.slice2_type, call, loc)]

    def _new(self, name: str, kind: Any, made: Any, loc: Any) -> Any:
        """The assignment of a new variable."""
        var = self._block.scope.redefine(name, loc)
        self._types[var.name] = kind
        self._ir._definitions[var.name].append(made)
        return ir.Assign(made, var, loc)

    def _fits(self, inst: Any, at: int) -> bool:
        made = inst.value if isinstance(inst, ir.Assign) else None
        if not isinstance(made, ir.Expr) or made.op != "inplace_binop":
            return False
        kind = self._kind(made) if isinstance(self._types[made.lhs.name], types.Array) else None
        first = None if kind is None else self._expression(made.rhs, at)
        if kind is None or first is None:
            return False
        if not self._is_computed_there(made, self._block.body[first].value):
            return False
        mine, theirs = self._types[made.lhs.name].dtype, kind.dtype
        if isinstance(mine, types.Float | types.Complex):
            return isinstance(theirs, type(mine)) and made.immutable_fn in _FLOAT
        whole = isinstance(mine, types.Integer) and mine.bitwidth >= _WHOLE_BITS
        return whole and isinstance(theirs, types.Integer) and made.immutable_fn in _INTEGER

    def _is_computed_there(self, made: Any, expression: Any) -> bool:
        """Whether the expression needs no array between."""
        operands, types_ = expression.list_vars(), self._types
        if not fit((types_[var.name] for var in operands), types_[made.lhs.name].ndim):
            return False
        origins = Origins(self._ir, types_.__getitem__)
        store = ir.StaticSetItem(made.lhs, slice(None), made.lhs, made.lhs, made.loc)
        return all(origins.is_apart(operand, store) for operand in operands)

    def _kind(self, made: Any) -> Any:
        """The type of the expression; None if it is no array of as many dimensions."""
        mine, theirs = self._types[made.lhs.name], self._types[made.rhs.name]
        if not isinstance(theirs, types.Array):
            return None
        function = self._typing.resolve_value_type(made.immutable_fn)
        signature = function.get_call_type(self._typing, (mine, theirs), {})
        found = None if signature is None else signature.return_type
        return found if isinstance(found, types.Array) and found.ndim == mine.ndim else None

    def _expression(self, var: Any, at: int) -> int | None:
        """Where the array expression is computed that is only added, just before."""
        body = self._block.body
        for place in reversed(range(at)):
            one = body[place]
            if isinstance(one, ir.Assign) and one.target.name == var.name:
                return place if self._is_expression(one) else None
            if not isinstance(one, ir.Del):
                return None
        return None

    def _is_expression(self, one: Any) -> bool:
        return one.target.is_temp and _tree_of(one.value) is not None


def _tree_of(made: Any) -> Any:
    """The operations of an expression of arrays, as numba has them of several; None: it is none."""
    if not isinstance(made, ir.Expr) or made.op not in ("arrayexpr", "binop", "unary"):
        return None
    if made.op == "arrayexpr":
        return made.expr
    if made.fn not in supported_array_operators:
        return None
    return made.fn, [made.lhs, made.rhs] if made.op == "binop" else [made.value]
