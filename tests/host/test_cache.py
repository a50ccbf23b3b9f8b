"""Where the cache is, how large it may be, and that doing without it is no error."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from vividc.errors import VividcWarning
from vividc.host import cache, store


@pytest.fixture(autouse=True)
def homes(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A user who has a home and has set nothing."""
    for variable in (cache.VARIABLE, cache.SIZE_VARIABLE, "XDG_CACHE_HOME"):
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    cache.complain.cache_clear()


def test_where_it_is(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    assert cache.folder() == tmp_path / ".cache" / "vividc" / "entries"
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")  # to be ignored, says the specification
    assert cache.folder() == tmp_path / ".cache" / "vividc" / "entries"
    monkeypatch.setenv("XDG_CACHE_HOME", "/xdg")
    assert cache.folder() == Path("/xdg/vividc/entries")
    monkeypatch.setenv(cache.VARIABLE, "/own")
    assert cache.folder() == Path("/own/entries")


def test_an_empty_variable_switches_it_off(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv(cache.VARIABLE, "")
    assert not cache.write("a", "key", b"content")
    assert cache.read("a", "key") is None
    cache.discard("a", "key", "is gone")
    assert not list(tmp_path.iterdir())


def test_relative_folders_are_ignored(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The current folder may hold what someone else packed."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(cache.VARIABLE, "own")
    with pytest.warns(VividcWarning, match="VIVIDC_CACHE_DIR is 'own', which is no absolute path"):
        assert cache.write("a", "key", b"content")
    assert cache.read("a", "key") == b"content"
    assert not (tmp_path / "own").exists()
    monkeypatch.setenv("HOME", "here")
    assert cache.folder() is None


def test_without_a_home_of_ones_own_there_is_none(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Under `sudo` with the user's HOME, files of root's would be in the user's way."""
    monkeypatch.setattr(os, "geteuid", lambda: 54321)
    assert cache.folder() is None
    assert not cache.write("a", "key", b"content")
    monkeypatch.setenv("HOME", str(tmp_path / "absent"))
    assert cache.folder() is None


def test_it_is_kept_below_a_size(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv(cache.SIZE_VARIABLE, "1")
    for key in range(12):
        assert cache.write("a", str(key), bytes(100_000))
    entries = list((tmp_path / ".cache" / "vividc" / "entries").iterdir())
    assert sum(entry.stat().st_size for entry in entries) <= 1 << 20
    assert cache.read("a", "11") is not None
    monkeypatch.setenv(cache.SIZE_VARIABLE, "0")
    assert not cache.write("a", "key", b"content")


@pytest.mark.parametrize("text", ["much", "-1", "1.5", "1 GB", "\u0665"])
def test_a_size_that_is_none_is_said(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    monkeypatch.setenv(cache.SIZE_VARIABLE, text)
    with pytest.warns(VividcWarning, match="which is not a number of MiB: using 256"):
        assert cache.write("a", "key", b"content")


def test_who_is_inside_does_not_wait_for_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    """Numba compiles what a function calls while it compiles the function."""
    monkeypatch.setattr(store, "sleep", pytest.fail)
    with cache.alone("a"):
        with cache.alone("a"), cache.alone("b"):
            cache.write("a", "key", b"content")
        assert cache.read("a", "key") == b"content"
    with cache.alone("a"):
        assert cache.read("a", "key") == b"content"
