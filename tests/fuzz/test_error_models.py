"""Programs that divide by zero: one in four has the error model "python", and must raise."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.fuzz import witnesses
from tests.fuzz.witnesses import judge

SOURCE = """
import numpy as np
from vividc.frontend import kernel
SHAPES = {'a': ('L',), 'b': ('L',)}
FIXED = True

@kernel('void(int32[::1], int32[::1], int32)')
def program(a, b, n):
    for i in range(len(a)):
        if i > 2:
            b[i] = a[i] // (i - 4)
        b[0] += a[i] % (n & 1)
"""


@pytest.mark.parametrize("seed", [3, 4])
def test_all_witnesses_do_as_numba_does(tmp_path: Path, seed: int) -> None:
    verdict = judge(SOURCE, seed, tmp_path, simulate="blocks")
    assert verdict.kind == "agrees", verdict.text


def test_a_witness_that_goes_on_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(witnesses, "run_regions", lambda *_: None)
    verdict = judge(SOURCE, 4, tmp_path)
    assert verdict.kind == "differs"
    assert "numba raises ZeroDivisionError" in verdict.text
