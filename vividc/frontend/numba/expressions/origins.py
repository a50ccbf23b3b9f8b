"""Where arrays come from: which parts of arrays cannot overlap, and which are the same.

Arrays are told apart by that: parameters of a kernel do not overlap (the launch refuses that), and
what the kernel makes lies beside all others.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, Final

from numba.core import ir, types
from numba.core.ir_utils import build_definitions, find_callname, guard

ITEMS: Final = ("getitem", "static_getitem")
_VIEWS: Final = frozenset({"T", "real", "imag"})
_METHODS: Final = frozenset({"reshape", "transpose", "ravel", "view"})
_MADE: Final = frozenset(
    {"zeros", "ones", "empty", "full", "arange", "zeros_like", "ones_like", "empty_like"}
    | {"full_like", "copy", "linspace", "eye", "dot", "outer", "sum"}
)
_COMPUTED: Final = ("arrayexpr", "binop", "unary")
"""Operators, whose results are arrays of their own."""

_PARTS: Final = frozenset({"call", "build_tuple", "build_slice"})
"""What indices are made of."""

_DEEPEST: Final = 32
"""Views of views that are looked through."""


class Origins:
    """What numba's statements of a function say of its arrays.

    Attributes
    ----------
    here
        Variables that are assigned in the block of a store, before it: what others were made of
        may be of an earlier iteration.
    """

    def __init__(self, func_ir: Any, typeof: Callable[[str], Any]) -> None:
        self._ir = func_ir
        self._typeof = typeof
        self._definitions = build_definitions(func_ir.blocks)
        self.here: set[str] = set()

    def is_apart(self, operand: Any, store: Any) -> bool:
        """Whether an operand cannot change before all loops have read it."""
        if not isinstance(self._typeof(operand.name), types.Array):
            return True
        if self.is_same_part(operand, store):
            return True
        mine, theirs = self._root(operand), self._root(store.target)
        return mine is not None and theirs is not None and mine != theirs

    def _root(self, var: Any) -> object:
        """What an array is part of: a parameter, or where it is made; None if it is not known."""
        for _ in range(_DEEPEST):
            value = self.only(var.name)
            if isinstance(value, ir.Arg):
                return value.index
            if self._is_made(value):
                return var.name
            var = self._copied(var) or self._viewed(value)
            if var is None:
                return None
        return None

    def _is_made(self, value: Any) -> bool:
        """Whether an expression is an array of its own."""
        if not isinstance(value, ir.Expr) or value.op != "call":
            return isinstance(value, ir.Expr) and value.op in _COMPUTED
        called = guard(find_callname, self._ir, value)
        return called is not None and called[1] == "numpy" and called[0] in _MADE

    def _viewed(self, value: Any) -> Any:
        """The array that an expression is a view of; None: it may be none."""
        if not isinstance(value, ir.Expr):
            return None
        if value.op in ITEMS or (value.op == "getattr" and value.attr in _VIEWS):
            return value.value
        method = self.only(value.func.name) if value.op == "call" else None
        if not isinstance(method, ir.Expr) or getattr(method, "attr", "") not in _METHODS:
            return None
        is_array = isinstance(self._typeof(method.value.name), types.Array)
        return method.value if is_array else None

    def is_same_part(self, var: Any, store: Any) -> bool:
        """Whether an array is the part that is assigned to, element by element."""
        value, other = self.only(var.name), self._copied(var)
        if other is not None:
            return self.is_same_part(other, store)
        if self.only(self._alias(store.target)) is None:
            return False
        whole = isinstance(store, ir.StaticSetItem) and store.index == slice(None)
        if whole and self._alias(var) == self._alias(store.target):
            return True  # of a part, too, that the store goes to as a variable
        if isinstance(value, ir.Expr) and value.op in ITEMS:
            if var.name not in self.here:
                return False  # perhaps of an earlier iteration, where its index was another
            index = value.index if value.op == "getitem" else value.index_var
            base = self._alias(value.value)
            return base == self._alias(store.target) and self._same(index, index_of(store))
        return False

    def _alias(self, var: Any) -> str:
        """The variable that another is a copy of."""
        copied = self._copied(var)
        return str(var.name) if copied is None else self._alias(copied)

    def _copied(self, var: Any) -> Any:
        """The variable whose value another has: also of `a *= 2` on an array, which is a itself."""
        return copied(self.only(var.name), self._typeof(var.name), self._typeof)

    def _same(self, one: Any, other: Any) -> bool:
        """Whether two indices are equal for sure."""
        if one is None or other is None:
            return False
        mine, theirs = (self.only(self._alias(var)) for var in (one, other))
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

    def only(self, name: str) -> Any:
        """The only definition of a variable; None if there are several."""
        made = self._definitions.get(name, ())
        return made[0] if len(made) == 1 else None


def copied(value: Any, kind: Any, typeof: Callable[[str], Any]) -> Any:
    """The variable that a value of this type is; None: it is no variable's."""
    if isinstance(value, ir.Var):
        return value
    if not isinstance(value, ir.Expr) or value.op != "inplace_binop":
        return None
    same = isinstance(kind, types.Array) and typeof(value.lhs.name) == kind
    return value.lhs if same else None


def index_of(store: Any) -> Any:
    """The variable that a store has as its index."""
    return store.index_var if isinstance(store, ir.StaticSetItem) else store.index


def fit(kinds: Iterable[Any], ndim: int) -> bool:
    """Whether all types are of numbers and of arrays of no more dimensions than this."""
    return all(
        isinstance(one, types.Number | types.Boolean)
        or (isinstance(one, types.Array) and one.ndim <= ndim)
        for one in map(types.unliteral, kinds)
    )
