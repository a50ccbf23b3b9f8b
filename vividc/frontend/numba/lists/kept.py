"""Lists that an iteration makes and the next one has: they are refused.

All lists that a line makes lie at one place (`growing`), so that an iteration's is gone when the
next makes its own. A list that is made before its loop, and one that no iteration hands on, is what
it is in Python.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

from numba.core import errors, ir, rewrites, types
from numba.core.analysis import compute_cfg_from_blocks

from vividc.frontend.numba.lists.fixed import for_the_array
from vividc.lang.formats import MISUSE

_REFUSED: Final = (
    f"{MISUSE}a list that an iteration makes is there in the next one: "
    "make it before the loop; empty it by clear(), and copy elements"
)
_SAME: Final = frozenset({"cast", "build_tuple", "static_getitem", "exhaust_iter"})
"""Expressions whose value is or has the list that they are given."""


@rewrites.register_rewrite("after-inference")
class _Kept(rewrites.Rewrite):  # type: ignore[misc]
    """Changes nothing."""

    def match(self, func_ir: Any, block: Any, typemap: Any, calltypes: Any) -> bool:
        """False.

        Raises
        ------
        errors.NumbaValueError
            A list that the block makes is kept for the next iteration of a loop around it.
        """
        made = [s for s in block.body if _is_made(s, typemap)] if for_the_array() else []
        if not made:
            return False
        here = next(label for label, one in func_ir.blocks.items() if one is block)
        flow = compute_cfg_from_blocks(func_ir.blocks)
        around = [loop for loop in flow.loops().values() if here in loop.body]
        latches = {
            label
            for loop in around
            for label in loop.body
            if any(following == loop.header for following, _ in flow.successors(label))
        }
        handed_on = [s for label in latches for s in _merges(func_ir, func_ir.blocks[label])]
        for statement in made if handed_on else ():
            names = _holding(func_ir, statement.target.name)
            if any(one.value.name in names for one in handed_on):
                raise errors.NumbaValueError(_REFUSED, loc=statement.loc)
        return False

    def apply(self) -> Any:
        """Never asked for: nothing matches."""
        raise NotImplementedError


def _is_made(statement: Any, typemap: Any) -> bool:
    """Whether a statement makes a list."""
    if not isinstance(statement, ir.Assign) or not isinstance(statement.value, ir.Expr):
        return False
    is_list = isinstance(typemap.get(statement.target.name), types.List)
    return is_list and statement.value.op not in _SAME | {"inplace_binop"}


def _holding(func_ir: Any, name: str) -> set[str]:
    """The variables that may have the list of a variable."""
    names = {name}
    while True:
        again = {
            s.target.name
            for block in func_ir.blocks.values()
            for s in block.body
            if isinstance(s, ir.Assign) and names.intersection(_read(s))
        }
        if again <= names:
            return names
        names |= again


def _read(statement: Any) -> set[str]:
    """Variables of which the target of an assignment may have the list."""
    value = statement.value
    if isinstance(value, ir.Var):
        return {value.name}
    if not isinstance(value, ir.Expr):
        return set()
    if value.op == "inplace_binop":
        return {value.lhs.name}
    return {var.name for var in value.list_vars()} if value.op in _SAME else set()


def _merges(func_ir: Any, block: Any) -> Iterator[Any]:
    """What a block assigns to variables that others assign to, too, which were phis."""
    for s in block.body:
        is_copy = isinstance(s, ir.Assign) and isinstance(s.value, ir.Var)
        if is_copy and len(_definitions(func_ir, s.target.name)) > 1:
            yield s


def _definitions(func_ir: Any, name: str) -> list[Any]:
    return [
        s
        for block in func_ir.blocks.values()
        for s in block.body
        if isinstance(s, ir.Assign) and s.target.name == name
    ]
