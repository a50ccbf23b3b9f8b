"""Tests of the frontend see what it makes of kernels, not what it made in an earlier run."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests import kept


@pytest.fixture(autouse=True)
def made_anew() -> Iterator[None]:
    with kept.modules_made_anew():
        yield
