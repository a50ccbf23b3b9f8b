"""Machine code is kept in a folder of the user's own, and nothing else is ever loaded."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from vividc.sim.native import cache

KEY = "0" * 64


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of the cache, which does not exist yet."""
    monkeypatch.setenv(cache.VARIABLE, str(tmp_path / "cache"))
    return tmp_path / "cache" / "native"


def test_what_is_written_is_read(place: Path) -> None:
    assert cache.read(KEY) is None
    cache.write(KEY, b"code")
    assert cache.read(KEY) == b"code"
    assert cache.read("1" * 64) is None
    assert [file.name for file in place.iterdir()] == [f"{KEY}.o"]
    assert stat.S_IMODE(place.stat().st_mode) == 0o700
    assert stat.S_IMODE((place / f"{KEY}.o").stat().st_mode) == 0o600


def test_what_others_may_write_is_not_loaded(place: Path) -> None:
    cache.write(KEY, b"code")
    file = place / f"{KEY}.o"
    file.chmod(0o620)
    assert cache.read(KEY) is None
    file.chmod(0o600)
    place.chmod(0o770)
    assert cache.read(KEY) is None
    cache.write("1" * 64, b"more")
    assert len(list(place.iterdir())) == 1
    place.chmod(0o700)
    assert cache.read(KEY) == b"code"


def test_what_belongs_to_others_is_not_loaded(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache.write(KEY, b"code")
    stranger = os.getuid() + 1
    monkeypatch.setattr(os, "getuid", lambda: stranger)
    assert cache.read(KEY) is None


def test_links_are_not_followed(place: Path, tmp_path: Path) -> None:
    cache.write(KEY, b"code")
    file = place / f"{KEY}.o"
    elsewhere = tmp_path / "elsewhere.o"
    file.rename(elsewhere)
    file.symlink_to(elsewhere)
    assert cache.read(KEY) is None
    moved = place.rename(tmp_path / "moved")
    place.symlink_to(moved)
    elsewhere.rename(moved / f"{KEY}.o")
    assert cache.read(KEY) is None


@pytest.mark.parametrize("damage", [b"", b"short", bytes(40)])
def test_damaged_files_are_not_loaded(place: Path, damage: bytes) -> None:
    cache.write(KEY, b"code")
    (place / f"{KEY}.o").write_bytes(damage)
    assert cache.read(KEY) is None
    cache.write(KEY, b"code")
    assert cache.read(KEY) == b"code"


def test_what_was_not_used_for_long_goes(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cache, "KEPT", 4)
    keys = [f"{k:064}" for k in range(5)]
    for age, key in enumerate(keys[:4]):
        cache.write(key, b"code")
        os.utime(place / f"{key}.o", (1000 + age, 1000 + age))
    assert cache.read(keys[0]) == b"code"  # it was used just now
    cache.write(keys[4], b"code")
    assert [key for key in keys if cache.read(key)] == [keys[0], keys[3], keys[4]]


def test_a_folder_that_cannot_be_made_is_done_without(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv(cache.VARIABLE, str(tmp_path / "file"))
    cache.write(KEY, b"code")
    assert cache.read(KEY) is None


def test_where_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(cache.VARIABLE, "")
    assert cache.folder() is None
    monkeypatch.delenv(cache.VARIABLE)
    monkeypatch.setenv("XDG_CACHE_HOME", "/xdg")
    assert cache.folder() == Path("/xdg/vividc/native")
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")  # to be ignored, says the specification
    monkeypatch.setenv("HOME", "/home/u")
    assert cache.folder() == Path("/home/u/.cache/vividc/native")
