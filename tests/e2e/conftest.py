"""Kernels are compiled for as long as a busy machine takes: what effort finds does not change.

Tests that ask for no cycles and no II compile with `effort="fast"`: the first good mapping is as
right as the best one, and every one is verified.
"""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import vividc


@pytest.fixture(autouse=True, scope="module")
def patience() -> Iterator[None]:
    with vividc.patient(20):
        yield
