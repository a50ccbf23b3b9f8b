"""Arguments fit their kernels, and what two runs left is compared bit for bit."""

from __future__ import annotations

import numpy as np
import pytest

from tests.fuzz.arguments import Difference, compare


@pytest.mark.parametrize("found", [[0.0, 1.0], [-0.0, 2.0]])
def test_floats_are_compared_with_their_sign(found: list[float]) -> None:
    expected = np.array([-0.0, 1.0], np.float32)
    compare("same", [expected.copy()], [expected])
    with pytest.raises(Difference):
        compare("other", [np.array(found, np.float32)], [expected])


def test_nan_is_nan() -> None:
    compare("same", [np.array([np.nan, 1.0])], [np.array([-np.nan, 1.0])])


def test_elementary_functions_may_differ_in_their_last_bits_only() -> None:
    one = np.float32(1.0)
    near, far = np.nextafter(one, np.float32(2.0)), np.float32(1.0001)
    compare("near", [near], [one], frozenset({0}))
    with pytest.raises(Difference):
        compare("far", [far], [one], frozenset({0}))
    with pytest.raises(Difference):
        compare("exact", [near], [one])
