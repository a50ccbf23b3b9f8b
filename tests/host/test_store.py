"""Entries are what was written under their name, or they are not there; nothing stops the user."""

from __future__ import annotations

import errno
import os
import random
import signal
import stat
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import vividc
from tests.fuzz.entries import check_damaged
from vividc.errors import VividcWarning
from vividc.host import store
from vividc.host.store import Store

ANY = pytest.mark.filterwarnings("ignore::vividc.errors.VividcWarning")


@pytest.fixture(autouse=True)
def nothing_said_yet(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store, "warned", [])


@pytest.fixture
def kept(tmp_path: Path) -> Store:
    """An empty store, whose folder does not exist yet."""
    return Store(tmp_path / "home" / "entries", 1 << 20)


def the_file(kept: Store) -> Path:
    (file,) = kept.folder.iterdir()
    return file


def test_what_is_written_is_read(kept: Store) -> None:
    assert kept.read("a", "key") is None
    assert kept.write("a", "key", b"content")
    assert kept.read("a", "key") == b"content"
    assert kept.read("b", "key") is None
    assert kept.read("a", "other") is None
    assert kept.write("a", "key", b"")
    assert kept.read("a", "key") == b""
    assert stat.S_IMODE(kept.folder.stat().st_mode) == 0o700
    assert stat.S_IMODE(the_file(kept).stat().st_mode) == 0o600


def test_keys_may_be_anything(kept: Store) -> None:
    keys = ["", "../../x", "a" * 10_000, "\0", "ä\ud800", "A", "a"]
    for key in keys:
        assert kept.write("a", key, b"content")
    assert len(list(kept.folder.iterdir())) == len(keys)


@ANY
def test_what_is_damaged_at_random_is_never_read(kept: Store) -> None:
    """Hundreds of files: bits, lengths, pieces moved and repeated, other entries' content."""
    for seed in range(400):
        check_damaged(kept, random.Random(seed))


def test_one_warning_a_process_and_the_entry_is_made_again(kept: Store) -> None:
    for key in ("one", "two"):
        kept.write("a", key, b"content")
    for file in kept.folder.iterdir():
        file.write_bytes(file.read_bytes()[:-1])
    with pytest.warns(VividcWarning, match=r"a-\w+ is damaged; it is thrown away and made again"):
        assert kept.read("a", "one") is None
    assert kept.read("a", "two") is None
    assert not list(kept.folder.iterdir())
    kept.write("a", "one", b"content")
    assert kept.read("a", "one") == b"content"


def test_an_entry_under_another_name_is_not_used(kept: Store) -> None:
    kept.write("a", "one", b"content")
    one = the_file(kept)
    kept.write("a", "two", b"other")
    (two,) = {*kept.folder.iterdir()} - {one}
    two.write_bytes(one.read_bytes())
    with pytest.warns(VividcWarning, match="damaged"):
        assert kept.read("a", "two") is None
    assert kept.read("a", "one") == b"content"
    one.rename(kept.folder / one.name.replace("a-", "b-"))
    assert kept.read("b", "one") is None


def as_fifo(file: Path) -> None:
    file.unlink()
    os.mkfifo(file, 0o600)


def as_folder(file: Path) -> None:
    file.unlink()
    file.mkdir()


def as_link(file: Path) -> None:
    file.rename(file.parent.parent / "elsewhere")
    file.symlink_to(file.parent.parent / "elsewhere")


def as_hole(file: Path) -> None:
    os.truncate(file, 1 << 40)


STRANGE: dict[str, Callable[[Path], None]] = {
    "no regular file": as_fifo,
    "is no regular file": as_folder,
    "no regular": as_link,
    "too large": as_hole,
    "can be written by others": lambda file: file.chmod(0o620),
    "others": lambda file: file.chmod(0o602),
    "damaged": lambda file: file.write_bytes(b"") and None,
}


@pytest.mark.parametrize("reason", STRANGE)
def test_what_is_no_file_of_ours_is_neither_opened_nor_read(kept: Store, reason: str) -> None:
    """A FIFO would wait for ever for who writes it."""
    kept.write("a", "key", b"content")
    STRANGE[reason](the_file(kept))
    with pytest.warns(VividcWarning, match=reason):
        assert kept.read("a", "key") is None
    assert kept.write("a", "key", b"new")
    assert kept.read("a", "key") == b"new"


@pytest.mark.parametrize("late", [as_fifo, as_folder, as_link, lambda file: file.chmod(0o622)])
def test_what_takes_an_entrys_place_before_it_is_opened_is_not_read(
    kept: Store, monkeypatch: pytest.MonkeyPatch, late: Callable[[Path], None]
) -> None:
    kept.write("a", "key", b"content")
    file, opened = the_file(kept), os.open

    def slow(path: Any, *more: Any, **at: Any) -> int:
        if path == file.name:
            late(file)
        return opened(path, *more, **at)

    monkeypatch.setattr(os, "open", slow)
    with pytest.warns(VividcWarning, match="thrown away"):
        assert kept.read("a", "key") is None


def test_a_fifo_is_not_opened(kept: Store) -> None:
    """A writer that waits at it would go on, and be killed."""
    kept.write("a", "key", b"content")
    as_fifo(the_file(kept))
    opened = os.open(the_file(kept), os.O_RDWR | os.O_NONBLOCK)
    os.write(opened, b"waiting")
    with pytest.warns(VividcWarning, match="is no regular file"):
        assert kept.read("a", "key") is None
    assert os.read(opened, 20) == b"waiting"
    os.close(opened)


def test_what_belongs_to_another_user_is_not_read(
    kept: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept.write("a", "key", b"content")
    stranger = os.geteuid() + 1
    monkeypatch.setattr(os, "geteuid", lambda: stranger)
    with pytest.warns(VividcWarning, match="entries is not used: it belongs to another user"):
        assert kept.read("a", "key") is None
    assert not kept.write("a", "key", b"new")


@pytest.mark.skipif(os.geteuid() != 0, reason="only root gives files away")
def test_a_file_of_another_user_in_our_folder_is_not_read(kept: Store) -> None:
    kept.write("a", "key", b"content")
    os.chown(the_file(kept), 12345, -1)
    with pytest.warns(VividcWarning, match="belongs to another user; it is thrown away"):
        assert kept.read("a", "key") is None


@pytest.mark.parametrize("mode", [0o770, 0o707, 0o1777])
def test_a_folder_that_others_may_write_is_not_used(kept: Store, mode: int) -> None:
    kept.write("a", "key", b"content")
    kept.folder.chmod(mode)
    with pytest.warns(VividcWarning, match="it can be written by others"):
        assert kept.read("a", "key") is None
    assert not kept.write("a", "more", b"content")
    assert len(list(kept.folder.iterdir())) == 1
    kept.folder.chmod(0o700)
    assert kept.read("a", "key") == b"content"


def test_a_linked_folder_is_not_used(kept: Store, tmp_path: Path) -> None:
    kept.write("a", "key", b"content")
    kept.folder.symlink_to(kept.folder.rename(tmp_path / "moved"))
    with pytest.warns(VividcWarning, match="entries is not used"):
        assert kept.read("a", "key") is None
    assert not kept.write("a", "key", b"new")


def test_a_folder_that_cannot_be_made_is_done_without(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    for place in (tmp_path / "file" / "entries", Path("/proc/none/entries")):
        assert not Store(place, 1000).write("a", "key", b"content")
        assert Store(place, 1000).read("a", "key") is None


@pytest.mark.parametrize("call", ["open", "write", "fsync", "replace", "mkdir"])
@pytest.mark.parametrize("fault", [errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EIO])
def test_a_full_disk_is_no_error(
    kept: Store, monkeypatch: pytest.MonkeyPatch, call: str, fault: int
) -> None:
    """Nor leaves it anything behind."""
    if call != "mkdir":
        kept.write("a", "key", b"content")

    def full(*_: object, **__: object) -> int:
        raise OSError(fault, os.strerror(fault))

    with monkeypatch.context() as patch, warnings.catch_warnings():
        warnings.simplefilter("ignore", VividcWarning)  # of a folder that cannot be opened
        patch.setattr(os, call, full)
        assert not kept.write("a", "key", b"new content")
    if call != "mkdir":
        assert kept.read("a", "key") == b"content"
        assert len(list(kept.folder.iterdir())) == 1


def test_a_disk_that_takes_a_part_is_asked_again(
    kept: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    written = os.write
    monkeypatch.setattr(os, "write", lambda file, data: written(file, data[:5]))
    assert kept.write("a", "key", b"content " * 4)
    assert kept.read("a", "key") == b"content " * 4


def test_what_was_not_used_for_long_goes(kept: Store) -> None:
    kept.limit = 5000
    for age, key in enumerate("abcd"):
        kept.write("a", key, bytes(1000))
        (new,) = (file for file in kept.folder.iterdir() if file.stat().st_mtime > 2000)
        os.utime(new, (1000 + age, 1000 + age))
    assert kept.read("a", "a") is not None  # it was used just now
    kept.write("a", "e", bytes(1000))
    assert [key for key in "abcde" if kept.read("a", key) is not None] == ["a", "d", "e"]
    assert not kept.write("a", "huge", bytes(5001))


def test_what_killed_processes_left_goes(kept: Store) -> None:
    kept.write("a", "key", b"content")
    old, new = f".1-{'0' * 16}", f".1-{'1' * 16}"
    for name, age in ((old, 7200), (new, 60)):
        (kept.folder / name).write_bytes(b"half")
        os.utime(kept.folder / name, (time.time() - age,) * 2)
    Store(kept.folder, kept.limit).write("a", "key", b"content")
    assert (kept.folder / new).exists()
    assert not (kept.folder / old).exists()


def test_files_that_are_no_entries_stay(kept: Store) -> None:
    """A folder of the same name may hold anything, such as a user's own `entries`."""
    kept.write("a", "key", b"content")
    others = (".gitignore", "thesis.tex", "a-backup", ".1-old", "A-" + "0" * 64)
    for name in others:
        (kept.folder / name).write_bytes(bytes(2 * kept.limit))
        os.utime(kept.folder / name, (1000, 1000))
    fresh = Store(kept.folder, kept.limit)
    fresh.write("a", "other", b"content")
    assert all((kept.folder / name).exists() for name in others)
    assert fresh.read("a", "key") == fresh.read("a", "other") == b"content"


def test_entries_of_a_clock_that_was_ahead_go_first(kept: Store) -> None:
    kept.limit = 5000
    for key in "abcd":
        kept.write("a", key, bytes(1000))
    for file in kept.folder.iterdir():
        os.utime(file, (time.time() + 10**9,) * 2)
    kept.write("a", "new", bytes(1000))
    assert kept.read("a", "new") is not None
    assert sum(kept.read("a", key) is not None for key in "abcd") <= 2


WRITER = """
import sys, types
from pathlib import Path
vividc = sys.modules["vividc"] = types.ModuleType("vividc")  # the whole takes seconds
vividc.__path__ = [sys.argv[2]]
from vividc.host.store import Store
kept = Store(Path(sys.argv[1]), 300_000)
print(flush=True)
for turn in range(10**9):
    key = str(turn % 7)
    kept.write("a", key, key.encode() * 20_000)
    found = kept.read("a", str((turn + 3) % 7))
    assert found is None or found == str((turn + 3) % 7).encode() * 20_000
"""


def test_processes_that_write_at_once_and_are_killed_leave_whole_entries(kept: Store) -> None:
    script = [sys.executable, "-c", WRITER, str(kept.folder), vividc.__path__[0]]
    writers = [
        subprocess.Popen(script, stdout=subprocess.PIPE, stderr=subprocess.PIPE) for _ in range(3)
    ]
    for writer in writers:
        assert writer.stdout is not None
        writer.stdout.readline()
    chance = random.Random(1)
    for writer in writers:
        time.sleep(chance.random() / 10)
        writer.send_signal(signal.SIGKILL)
        _, said = writer.communicate()
        assert not said
        assert writer.returncode == -signal.SIGKILL
    for key in map(str, range(7)):
        found = kept.read("a", key)  # a warning would be an error
        assert found is None or found == key.encode() * 20_000


@pytest.mark.skipif(sys.platform == "win32", reason="no flock")
def test_what_takes_long_is_made_by_one_at_a_time(kept: Store) -> None:
    """Each opens the file for itself, as processes do."""
    inside, most = [], []
    first_is_in, go_on = threading.Event(), threading.Event()

    def make(name: str) -> None:
        with Store(kept.folder, 1 << 20).alone("a"):
            inside.append(name)
            most.append(len(inside))
            first_is_in.set()
            go_on.wait(10)
            inside.remove(name)

    threads = [threading.Thread(target=make, args=(name,)) for name in "xyz"]
    for thread in threads:
        thread.start()
    assert first_is_in.wait(10)
    with kept.alone("b"):  # another kind does not wait
        go_on.set()
    for thread in threads:
        thread.join(10)
    assert most == [1, 1, 1]
    assert not list(kept.folder.iterdir())


def test_without_a_folder_nobody_waits(kept: Store) -> None:
    kept.folder.parent.write_text("a file in its place")
    with kept.alone("a"), kept.alone("a"):
        assert kept.read("a", "key") is None
