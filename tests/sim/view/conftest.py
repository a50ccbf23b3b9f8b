"""Compiled kernels, once for all tests of the views."""

from __future__ import annotations

import pytest

import vividc
from tests.sim.view import small_kernels
from vividc.program import Program


@pytest.fixture(autouse=True)
def engine() -> None:
    """Instead of the simulator's tests' fixture of this name: these tests name their engines."""


@pytest.fixture(scope="session")
def programs() -> dict[str, Program]:
    """Each small kernel, compiled for `vivid-tile`."""
    kernels = (small_kernels.total, small_kernels.strided, small_kernels.find)
    return {kernel.name: vividc.compile(kernel, time_limit_s=30) for kernel in kernels}
