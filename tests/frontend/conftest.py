"""Tests of the frontend run numba: what an earlier run kept is not taken."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests import kept


@pytest.fixture(autouse=True)
def numba_runs() -> Iterator[None]:
    with kept.made_anew():
        yield
