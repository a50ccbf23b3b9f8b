"""Kernels are compiled for as long as a busy machine takes: what effort finds does not change."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import vividc


@pytest.fixture(autouse=True, scope="module")
def patience() -> Iterator[None]:
    with vividc.patient(20):
        yield
