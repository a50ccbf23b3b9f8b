"""Lists of fixed length: `np.array([a, b])` and `for w in [1, 2, 4]`, whose lists become tuples,
and `v = [0.0, 0.0]` with elements that are assigned to, which become arrays.

A list lies on numba's heap, which the array has not. One that is written out as the argument of
`np.array`, or whose elements are constants of one type and that is only read, is no different from
the tuple of its elements: numba unifies both to one type. One of constants whose elements are read
and written, and which is copied to arrays, is no different from an array. Others stay lists.
"""

from __future__ import annotations

import functools
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, Final

import numpy as np
from numba.core import ir, rewrites, types
from numba.core.ir_utils import find_callname, find_const, get_definition, guard
from numba.extending import overload

_overload: Callable[..., Callable[..., Any]] = functools.partial(overload, target="vividc")
_ARRAYS: Final = {("array", "numpy"), ("asarray", "numpy")}
_READERS: Final = {("len", "builtins"), ("enumerate", "builtins"), ("reversed", "builtins")}
_READS: Final = frozenset({"getiter", "getitem", "static_getitem"})
_ours: ContextVar[bool] = ContextVar("lists_are_tuples", default=False)


@contextmanager
def lists_are_tuples() -> Iterator[None]:
    """What numba types meanwhile is for the array."""
    before = _ours.set(True)
    try:
        yield
    finally:
        _ours.reset(before)


def for_the_array() -> bool:
    """Whether what numba compiles now is for the array."""
    return _ours.get()


@rewrites.register_rewrite("before-inference")
class _Tuples(rewrites.Rewrite):  # type: ignore[misc]
    """Makes tuples of the lists of a block."""

    def match(self, func_ir: Any, block: Any, *_: Any) -> bool:
        """Whether the block makes lists that may be tuples."""
        self._block = block
        made = (
            {s.target.name: s.value for s in block.body if _is_list(s)} if for_the_array() else {}
        )
        self._found = _fixed(func_ir, made) if made else set()
        self._arrays = {
            name
            for name in made.keys() - self._found
            if _are_alike(func_ir, made[name]) and _is_array(func_ir, name)
        }
        return bool(self._found | self._arrays)

    def apply(self) -> Any:
        """The block with tuples and arrays."""
        changed = self._block.copy()
        changed.body = []
        for s in self._block.body:
            if _is_list(s) and s.target.name in self._found | self._arrays:
                made = ir.Expr.build_tuple(s.value.items, s.value.loc)
                if s.target.name in self._arrays:
                    made = self._array_of(made, changed)
                changed.body.append(ir.Assign(made, s.target, s.loc))
            else:
                changed.body.append(s)
        return changed

    def _array_of(self, tuple_: Any, block: Any) -> Any:
        """A call of `np.array`; what it is made of is added to the block."""
        items = block.scope.redefine("$items", tuple_.loc)
        function = block.scope.redefine("$array", tuple_.loc)
        block.append(ir.Assign(tuple_, items, tuple_.loc))
        numpys = ir.Global("array", np.array, tuple_.loc)
        block.append(ir.Assign(numpys, function, tuple_.loc))
        return ir.Expr.call(function, [items], (), tuple_.loc)


def _is_list(statement: Any) -> bool:
    value: Any = getattr(statement, "value", None)
    is_made = isinstance(statement, ir.Assign) and isinstance(value, ir.Expr)
    return is_made and value.op == "build_list" and bool(value.items)


def _fixed(func_ir: Any, made: dict[str, Any]) -> set[str]:
    """Names of the lists that may be tuples."""
    uses: dict[str, list[Any]] = defaultdict(list)
    targets: dict[str, int] = defaultdict(int)
    for block in func_ir.blocks.values():
        for statement in block.body:
            if isinstance(statement, ir.Assign):
                targets[statement.target.name] += 1
            for name in _read(statement):
                uses[name].append(statement)
    found = {name for name in made if targets[name] == 1}
    while True:
        kept = {n for n in found if _is_read_only(func_ir, n, made[n], uses, found)}
        if kept == found:
            return found
        found = kept


def _read(statement: Any) -> Iterable[str]:
    if isinstance(statement, ir.Del):
        return ()
    names = {var.name for var in statement.list_vars()}
    if isinstance(statement, ir.Assign):
        value = statement.value
        read = {value.name} if isinstance(value, ir.Var) else set()
        if isinstance(value, ir.Expr):
            read = {var.name for var in value.list_vars()}
        names = (names - {statement.target.name}) | read
    return names


def _is_read_only(
    func_ir: Any, name: str, value: Any, uses: dict[str, list[Any]], found: set[str]
) -> bool:
    """Whether a list is an array's contents, or constants that are only read."""
    pending, names = [name], {name}
    alike = _are_alike(func_ir, value)
    while pending:
        one = pending.pop()
        for statement in uses[one]:
            used = getattr(statement, "value", None)
            if not isinstance(statement, ir.Assign) or one == statement.target.name:
                return False
            if isinstance(used, ir.Var) and _is_single(func_ir, statement.target.name):
                if statement.target.name not in names:
                    names.add(statement.target.name)
                    pending.append(statement.target.name)
            elif not _is_read(func_ir, one, used, found, alike=alike):
                return False
    return True


def _is_single(func_ir: Any, name: str) -> bool:
    return len(func_ir._definitions.get(name, ())) == 1


def _is_read(func_ir: Any, name: str, used: Any, found: set[str], *, alike: bool) -> bool:
    if not isinstance(used, ir.Expr):
        return False
    if used.op == "build_list":
        return any(
            isinstance(value, ir.Expr) and value is used and target in found
            for target in found
            for value in func_ir._definitions.get(target, ())
        )
    if used.op == "call":
        called = guard(find_callname, func_ir, used)
        if called == ("cross", "numpy") and not used.kws:
            return True
        is_first = bool(used.args) and used.args[0].name == name
        rest = [*used.args[1:], *(var for _, var in used.kws)]
        if not is_first or any(var.name == name for var in rest):
            return False
        return called in _ARRAYS or (alike and called in _READERS)
    return alike and used.op in _READS and used.value.name == name


def _are_alike(func_ir: Any, value: Any) -> bool:
    """Whether all elements are constants of one type."""
    constants = [guard(find_const, func_ir, item) for item in value.items]
    kinds = {type(one) for one in constants}
    return len(kinds) == 1 and kinds <= {int, float, bool, np.float32, np.int32}


def _copied(object: Any) -> Any:
    return np.copy(object)


@_overload(np.array)
def _overload_array(object: Any) -> Any:
    """A copy of an array, which numba makes of lists and tuples only."""
    return _copied if isinstance(object, types.Array) else None


def _is_array(func_ir: Any, name: str) -> bool:
    """Whether an array in place of a list is no different: its elements are read and assigned to,
    or copied to an array, or it is returned as one.
    """
    names = {name}
    while True:
        again = {
            s.target.name
            for block in func_ir.blocks.values()
            for s in block.body
            if isinstance(s, ir.Assign) and isinstance(s.value, ir.Var) and s.value.name in names
        }
        if again <= names:
            break
        names |= again
    if not all(_is_single(func_ir, one) for one in names):
        return False
    return all(
        _keeps_array(func_ir, block, at, names)
        for block in func_ir.blocks.values()
        for at in range(len(block.body))
        if names.intersection(_read(block.body[at]))
    )


def _keeps_array(func_ir: Any, block: Any, at: int, names: set[str]) -> bool:
    """Whether a statement with the list does the same with an array."""
    statement = block.body[at]
    used = getattr(statement, "value", None)
    if _is_set(statement):
        return statement.target.name in names and getattr(used, "name", None) not in names
    if not isinstance(statement, ir.Assign) or not isinstance(used, ir.Expr):
        return isinstance(statement, ir.Assign)
    if used.op in ("getitem", "static_getitem"):
        return used.value.name in names and not _is_slice(func_ir, used)
    called = guard(find_callname, func_ir, used) if used.op == "call" else None
    if called == ("asarray", "numpy"):  # no copy
        behind = block.body[at + 1 :]
        if not isinstance(behind[-1], ir.Return) or any(map(_is_set, behind)):
            return False
    is_copied = called in _ARRAYS or called == ("len", "builtins")
    return is_copied and len(used.args) == 1 and not used.kws


def _is_set(statement: Any) -> bool:
    return isinstance(statement, ir.SetItem | ir.StaticSetItem)


def _is_slice(func_ir: Any, item: Any) -> bool:
    index = item.index if item.op == "getitem" else item.index_var
    made = guard(get_definition, func_ir, index) if index is not None else None
    if isinstance(made, ir.Expr) and made.op == "call":
        return bool(guard(find_callname, func_ir, made) == ("slice", "builtins"))
    return isinstance(getattr(item, "index", None), slice)
