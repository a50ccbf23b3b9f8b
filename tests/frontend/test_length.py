"""What no array holds is refused before time is spent on it."""

from __future__ import annotations

from types import FunctionType

import numpy as np
import pytest

import vividc
from vividc.errors import SourceLoc
from vividc.frontend.refused import length


def _long(statements: int) -> FunctionType:
    lines = "\n".join(f"    a += x[{i}]" for i in range(statements))
    space: dict[str, FunctionType] = {}
    exec(f"def long(x):\n    a = 0\n{lines}\n    return a\n", space)
    return space["long"]


def test_a_python_function_of_too_many_instructions_is_refused_before_numba_sees_it() -> None:
    length.refuse_long_code(_long(1_000), SourceLoc("long.py", 1))
    with pytest.raises(vividc.VividcError, match="Python instructions, where 65536 are the most"):
        length.refuse_long_code(_long(20_000), SourceLoc("long.py", 1))


@vividc.kernel("int32(int32[::1])")
def sums(x):  # type: ignore[no-untyped-def]
    return np.int32(x[0] * x[1] + x[2] * x[3] + x[4] * x[5])


def test_a_kernel_of_too_many_operations_is_refused_with_its_line(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(length, "MAX_INSTRUCTIONS", 5)
    with pytest.raises(vividc.VividcError, match=r"test_length.py:\d+: a function of \d+ instr"):
        sums.lower()
