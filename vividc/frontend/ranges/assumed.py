"""Formulas with what a phi of a loop is assumed to be at most, for proofs by induction."""

from __future__ import annotations

from vividc.machine.params import Formula

_Bound = tuple[bool, Formula]
"""Whether the unknown may be greatest, and what else may be; () for nothing."""


def assumed(phi: int) -> str:
    """The unknown in formulas that a phi is assumed not to be more than."""
    return f"s:%{phi}"


def no_more(formula: Formula, unknown: str) -> Formula | None:
    """A formula without the unknown, so that the number is at most the greater of both; (): it is
    at most the unknown. None: that is not known.
    """
    stack: list[_Bound | None] = []
    for item in formula:
        if item not in ("+", "*", "//", "max", "min"):
            stack.append((True, ()) if item == unknown else (False, (item,)))
            continue
        right, left = stack.pop(), stack.pop()
        known = left is not None and right is not None
        stack.append(_joined(str(item), left, right) if left and right and known else None)
    found = stack.pop()
    return None if found is None else found[1]


def _joined(operator: str, left: _Bound, right: _Bound) -> _Bound | None:
    if not left[0] and not right[0]:
        return False, (*left[1], *right[1], operator)
    if operator == "max":
        rest = (*left[1], *right[1], "max") if left[1] and right[1] else left[1] or right[1]
        return True, rest
    if operator == "min":
        return left if left[0] else right
    if operator == "//":
        return _divided(left, right)
    one, other = (left, right) if left[0] else (right, left)
    if other[0] or len(other[1]) != 1 or not isinstance(other[1][0], int):
        return None
    constant = other[1][0]
    kept = constant <= 0 if operator == "+" else constant == 1
    return one if kept else None


def _divided(left: _Bound, right: _Bound) -> _Bound | None:
    """By a positive constant: no more, unless it is negative."""
    if right[0] or len(right[1]) != 1 or not isinstance(right[1][0], int) or right[1][0] < 1:
        return None
    return True, (*left[1], 0, "max") if left[1] else (0,)
