"""Subscripts recovered from flat indices."""

from __future__ import annotations

import pytest

from tests.ssa.polyhedral import dependence_kernels as k
from vividc.frontend import KernelFunction
from vividc.ssa.ir import Function, Phi, Ref, Value
from vividc.ssa.polyhedral.subscripts import subscripts_of


def names(function: Function) -> dict[Value, str]:
    """Phis by their lines: the outer loop's is i, the inner one's j."""
    phis = (item for block in function.blocks for item in block.items if isinstance(item, Phi))
    return {Ref(phi.id): name for phi, name in zip(phis, "ij", strict=False)}


def found(kernel: KernelFunction) -> set[str]:
    """The subscripts of `a`, with the symbols of loops by name."""
    function = kernel.lower()
    known = names(function)
    result = set()
    for block in function.blocks:
        for instr in block.instrs:
            parts = subscripts_of(function).of(instr) if instr.array == "a" else None
            if parts is not None:
                result.add(
                    ", ".join(
                        " + ".join(
                            f"{factor} {' '.join(known.get(v, '?') for v in monomial)}".strip()
                            for monomial, factor in sorted(part.terms.items(), key=repr)
                        )
                        for part in parts
                    )
                )
    return result


def test_rows_and_columns() -> None:
    assert found(k.rows) == {"1 i, 1 j", "1 + 1 i, 1 j"}
    assert found(k.triangle) == {"1 i, 1 j", "1 j, 1 i"}


@pytest.mark.parametrize("kernel", [k.at_the_edge])
def test_a_subscript_that_equals_the_pitch_is_no_row(kernel: KernelFunction) -> None:
    """LLVM puts the number of columns in j's place, which is not the pitch to it."""
    assert not any(text.startswith("2") or text[-4:] == ", -1" for text in found(kernel))
    assert all(text.split(", ")[0] in ("1 i", "1 + 1 i") for text in found(kernel))


def test_a_flat_index_is_one_subscript() -> None:
    assert {text.count(",") for text in found(k.flat)} == {0, 1}
