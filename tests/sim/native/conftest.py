"""These tests name their engines, and keep no machine code."""

from __future__ import annotations

import pytest


@pytest.fixture(autouse=True)
def engine() -> None:
    """Instead of the simulator's tests' fixture of this name."""


@pytest.fixture(autouse=True)
def no_cache(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VIVIDC_CACHE_DIR", "")
