"""Garbage is looked for less often inside, and as before afterwards."""

from __future__ import annotations

import gc
from collections.abc import Iterator

import numpy as np
import pytest

import vividc
from vividc.host.watch import seldom


@pytest.fixture(autouse=True)
def as_python_has_it() -> Iterator[None]:
    before = gc.get_threshold()
    gc.set_threshold(700, 10, 10)
    yield
    gc.set_threshold(*before)


def test_calls_inside_each_other_end_with_the_outermost() -> None:
    with seldom():
        with seldom():
            assert gc.get_threshold() == (50_000, 20, 20)
        assert gc.get_threshold() == (50_000, 20, 20)
    assert gc.get_threshold() == (700, 10, 10)


def test_an_error_ends_it() -> None:
    with pytest.raises(KeyError), seldom():
        raise KeyError
    assert gc.get_threshold() == (700, 10, 10)


def test_who_looks_less_often_goes_on() -> None:
    gc.set_threshold(100_000, 10, 30)
    with seldom():
        assert gc.get_threshold() == (100_000, 20, 30)
    assert gc.get_threshold() == (100_000, 10, 30)


def test_who_looks_for_none_goes_on() -> None:
    gc.set_threshold(0)
    with seldom():
        assert gc.get_threshold()[0] == 0


def test_a_kernel_is_compiled_so(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[tuple[int, int, int]] = []

    @vividc.kernel("void(float32[::1])")
    def doubled(a):
        for i in range(len(a)):
            a[i] = a[i] + a[i]

    program = vividc.compile(
        doubled,
        effort="fast",
        cache=False,
        time_limit_s=50.0,
        progress=lambda *_, **__: seen.append(gc.get_threshold()),
    )
    assert set(seen) == {(50_000, 20, 20)}
    assert gc.get_threshold() == (700, 10, 10)
    a = np.ones(4, np.float32)
    vividc.simulate(program, a)
    assert a.tolist() == [2, 2, 2, 2]
