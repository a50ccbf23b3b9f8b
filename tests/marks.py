"""Marks of tests that share a parameter."""

from __future__ import annotations

from collections.abc import Container, Iterable

import pytest


def with_slow(values: Iterable[object], slow: Container[object]) -> list[object]:
    """Parameters of a test, of which the slow run alone has those in `slow`."""
    marks = pytest.mark.slow
    return [pytest.param(one, marks=marks) if one in slow else one for one in values]
