"""How far long work is: on a terminal, in a notebook, in a log; whoever does the work tells it."""

from __future__ import annotations

import io
import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

import vividc
from vividc.errors import VividcError
from vividc.host import progress as shows


@vividc.jit(effort="fast")
def doubled(a):
    for i in range(a.shape[0]):
        a[i] *= np.float32(2)


class Place:
    """What a notebook shows below a cell."""

    def __init__(self) -> None:
        self.texts: list[str] = []

    def update(self, data: dict[str, str], raw: bool) -> None:
        assert raw
        self.texts.append(data["text/plain"])


@pytest.fixture
def place(monkeypatch: pytest.MonkeyPatch) -> Place:
    """As IPython is loaded where it runs for a notebook."""
    place = Place()

    def display(data: dict[str, str], raw: bool, display_id: bool) -> Place:
        assert display_id
        place.update(data, raw)
        return place

    ipython, displays = ModuleType("IPython"), ModuleType("IPython.display")
    vars(ipython)["get_ipython"] = lambda: SimpleNamespace(kernel=object())
    vars(displays)["display"] = display
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    monkeypatch.setitem(sys.modules, "IPython.display", displays)
    return place


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten seconds pass each time that somebody looks."""
    times = iter(range(0, 100_000, 10))
    monkeypatch.setattr(shows, "time", SimpleNamespace(monotonic=lambda: next(times)))


@pytest.mark.usefixtures("clock")
def test_a_notebook_shows_it_below_the_cell(place: Place) -> None:
    with vividc.progress("doubling"):
        doubled(np.ones(8, np.float32))
    first, *between, last = place.texts
    assert first == "doubling ..."
    assert any("loop1" in text for text in between)
    assert last.endswith("s: done")


def test_a_notebook_says_that_it_stopped(place: Place) -> None:
    with pytest.raises(KeyboardInterrupt), vividc.progress():
        raise KeyboardInterrupt
    assert place.texts[-1].startswith("working, ")
    assert place.texts[-1].endswith("s: stopped")


@pytest.mark.usefixtures("clock")
def test_a_log_has_a_line_at_intervals(capsys: pytest.CaptureFixture[str]) -> None:
    with vividc.progress("a frame\n") as tell:
        for state in (("mapping",), (1234567,), (0.25,), ("loop1:", 8)):
            tell(*state)
    assert capsys.readouterr().err.splitlines() == [
        r"a frame\n, 20 s: 1,234,567 cycles",
        r"a frame\n, 40 s: loop1: 8 cycles",
    ]


def test_a_terminal_shows_it_in_place(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv("TERM", "xterm")
    with vividc.progress("doubling") as tell:
        tell("[bold]nearly")
    assert "[bold]nearly" in terminal.getvalue()


def test_who_is_given_somebody_to_tell_tells_him(place: Place) -> None:
    told: list[str] = []
    with vividc.progress("doubling"):
        vividc.compile(doubled.kernel(np.ones(8, np.float32)), effort="fast", progress=told.append)
    assert told
    assert len(place.texts) == 2


def test_outside_nobody_is_told(capsys: pytest.CaptureFixture[str], place: Place) -> None:
    with vividc.progress("doubling"):
        pass
    doubled(np.ones(8, np.float32))
    assert len(place.texts) == 2
    assert capsys.readouterr().err == ""


def test_a_title_is_text() -> None:
    with pytest.raises(VividcError, match="the title"), vividc.progress(3):
        pass
