"""Subscripts of accesses by flat indices that prove to be of elements by row and column.

Where two such indices differ by a number of rows and some columns, no arithmetic tells that they
are of different elements without the rows: a row may be shorter than the columns are apart.
"""

from __future__ import annotations

from vividc.host.once import once_within
from vividc.ssa.analysis.order import Order
from vividc.ssa.analysis.polynomial import Polynomial
from vividc.ssa.ir import Function, Input, Instr, Value
from vividc.ssa.polyhedral.distances.maps import is_certain
from vividc.ssa.polyhedral.subscripts import FlatRows, Subscripts, subscripts_of


class InRows:
    """Subscripts of the accesses of one function, as `Subscripts` has them; all accesses of an
    array are by rows of one length.
    """

    def __init__(self, function: Function) -> None:
        self._function, self._order = function, Order(function)
        self._flat: Subscripts = subscripts_of(function)
        self._rows = FlatRows(function, self._order)
        self._found: dict[int, tuple[Polynomial, ...] | None] = {}

    def polynomial(self, value: Value) -> Polynomial:
        """Of any value."""
        return self._flat.polynomial(value)

    def of(self, access: Instr) -> tuple[Polynomial, ...] | None:
        """Row and column, or as many subscripts as the array has dimensions; None: they are not
        known.
        """
        if access.id not in self._found:
            self._found[access.id] = self._of(access)
        return self._found[access.id]

    def _of(self, access: Instr) -> tuple[Polynomial, ...] | None:
        known = self._flat.of(access)
        if known is not None and len(known) > 1:
            return known
        index = self._flat.polynomial(access.operands[1])
        if all(len(monomial) <= 1 for monomial in index.terms):
            return None
        return self._rows.taken_apart(access, index, self._is_in_row)

    def _is_in_row(self, column: Polynomial, length: Input, access: Instr) -> bool:
        """Whether a column proves to be from 0 to below the length of a row where the access is
        made, as its predicate says, too.
        """
        if any(len(monomial) > 1 for monomial in column.terms):
            return False
        order = self._order
        facts = order.facts(self._function.block_of[access.id])
        if not is_certain(access):
            facts = (*facts, *order.implied(access.operands[-1], True, facts))
        found = order.of_terms(column)
        ends = (found, order.sum_of(length).less(found, 1))
        return all(order.is_proved(one, facts) for one in ends)


@once_within
def in_rows_of(function: Function) -> InRows:
    """Those of a function, found once for it."""
    return InRows(function)
