"""Files for a user appear whole or not at all; what is no file is written to."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from vividc.errors import BundleError, VividcError
from vividc.host.files import is_written_through, write_whole


def test_writes_and_replaces(tmp_path: Path) -> None:
    path = tmp_path / "out.bin"
    write_whole(path, b"one")
    write_whole(path, b"two")
    assert path.read_bytes() == b"two"
    assert os.listdir(tmp_path) == ["out.bin"]


def test_failure_leaves_the_old_file_and_no_litter(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    path = tmp_path / "out.bin"
    path.write_bytes(b"old")
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(VividcError, match=r"out\.bin: cannot be written: No space left on device"):
        write_whole(path, b"new")
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["out.bin"]


def test_permissions_are_those_of_an_ordinary_file(tmp_path: Path) -> None:
    ordinary, written = tmp_path / "ordinary", tmp_path / "written"
    ordinary.write_bytes(b"")
    write_whole(written, b"")
    assert stat.S_IMODE(written.stat().st_mode) == stat.S_IMODE(ordinary.stat().st_mode)


def test_replacing_keeps_permissions(tmp_path: Path) -> None:
    path = tmp_path / "out"
    path.write_bytes(b"")
    path.chmod(0o640)
    write_whole(path, b"x")
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


def test_an_error_of_the_system_is_a_user_error(tmp_path: Path) -> None:
    with pytest.raises(BundleError, match="cannot be written: No such file"):
        write_whole(tmp_path / "missing" / "out", b"", BundleError)
    with pytest.raises(VividcError, match="cannot be written: Is a directory"):
        write_whole(tmp_path, b"")


def test_a_link_stays_and_its_target_is_replaced(tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    target, link = folder / "target.json", tmp_path / "link.json"
    target.write_bytes(b"old")
    target.chmod(0o604)
    link.symlink_to(target)
    write_whole(link, b"new")
    assert link.is_symlink()
    assert target.read_bytes() == b"new"
    assert stat.S_IMODE(target.stat().st_mode) == 0o604
    target.unlink()
    write_whole(link, b"again")
    assert (link.is_symlink(), target.read_bytes()) == (True, b"again")


def test_a_fifo_is_written_to(tmp_path: Path) -> None:
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    writer = threading.Thread(target=write_whole, args=(fifo, b"through"))
    writer.start()
    assert fifo.read_bytes() == b"through"
    writer.join()
    assert stat.S_ISFIFO(fifo.stat().st_mode)


@pytest.mark.skipif(os.geteuid() != 0, reason="only root makes devices")
@pytest.mark.parametrize(("minor", "fails"), [(3, False), (7, True)])
def test_a_device_is_written_to(minor: int, fails: bool, tmp_path: Path) -> None:
    """Nodes of the kind of /dev/null and /dev/full."""
    device = tmp_path / "device"
    try:
        os.mknod(device, 0o666 | stat.S_IFCHR, os.makedev(1, minor))
        device.open("rb").close()
    except PermissionError:
        pytest.skip("devices are not allowed here")
    assert is_written_through(device)
    if fails:
        with pytest.raises(VividcError, match="cannot be written: No space left on device"):
            write_whole(device, b"x")
    else:
        write_whole(device, b"x")
    assert stat.S_ISCHR(device.stat().st_mode)


@pytest.mark.parametrize("redirected", [False, True])
def test_the_process_s_own_output_is_written_in_turn(redirected: bool, tmp_path: Path) -> None:
    code = (
        "from pathlib import Path; from vividc.host.files import write_whole; print('a');"
        "write_whole(Path('/dev/stdout'), b'b'); print('c')"
    )
    path = tmp_path / "out"
    if redirected:
        with path.open("wb") as out:
            subprocess.run([sys.executable, "-c", code], stdout=out, check=True)
    else:
        path.write_bytes(subprocess.check_output([sys.executable, "-c", code]))
    assert path.read_bytes() == b"a\nbc\n"
