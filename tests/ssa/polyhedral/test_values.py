"""Words as functions of iteration indices."""

from __future__ import annotations

import islpy as isl
import pytest

from vividc.ssa.ir import Block, Branch, Function, Input
from vividc.ssa.polyhedral.values import Expressions


@pytest.mark.parametrize("operations", [1, 10, 50])
def test_a_value_that_took_too_long_once_is_not_unknown_from_then_on(operations: int) -> None:
    values = Expressions(Function("f", (), (Block("b0", (), (), Branch()),)))
    length = Input("x.shape0")
    context = isl.DEFAULT_CONTEXT
    context.reset_operations()
    context.set_max_operations(operations)
    try:
        with pytest.raises(isl.Error):
            values.of(length)
    finally:
        context.set_max_operations(0)
    assert values.of(length) is not None
