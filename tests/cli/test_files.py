"""Output files appear whole or not at all."""

import os
import stat

import pytest

from vividc.cli.files import check_apart, check_output, write_whole
from vividc.errors import VividcError


class Broken(Exception):
    pass


def test_writes_and_replaces(tmp_path):
    path = tmp_path / "out.bin"
    write_whole(path, lambda file: file.write(b"one"))
    write_whole(path, lambda file: file.write(b"two"))
    assert path.read_bytes() == b"two"
    assert os.listdir(tmp_path) == ["out.bin"]


def test_failure_leaves_the_old_file_and_no_litter(tmp_path):
    path = tmp_path / "out.bin"
    path.write_bytes(b"old")

    def write(file):
        file.write(b"half")
        raise Broken

    with pytest.raises(Broken):
        write_whole(path, write)
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["out.bin"]


def test_permissions_are_those_of_an_ordinary_file(tmp_path):
    ordinary, written = tmp_path / "ordinary", tmp_path / "written"
    ordinary.write_bytes(b"")
    write_whole(written, lambda file: file.write(b""))
    assert stat.S_IMODE(written.stat().st_mode) == stat.S_IMODE(ordinary.stat().st_mode)


def test_replacing_keeps_permissions(tmp_path):
    path = tmp_path / "out"
    path.write_bytes(b"")
    path.chmod(0o640)
    write_whole(path, lambda file: file.write(b"x"))
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


def test_missing_folder_is_refused_with_the_option(tmp_path):
    with pytest.raises(VividcError, match=r"--output: the folder .* does not exist"):
        check_output(tmp_path / "missing" / "out", "--output")
    with pytest.raises(VividcError, match="is a folder"):
        check_output(tmp_path, "--output")
    check_output(tmp_path / "out", "--output")


def test_error_of_the_system_is_a_user_error(tmp_path):
    with pytest.raises(VividcError, match="cannot be written"):
        write_whole(tmp_path / "missing" / "out", lambda file: file.write(b""))


def test_outputs_are_apart_from_inputs_and_each_other(tmp_path):
    read, written = tmp_path / "in.npz", tmp_path / "out.npz"
    check_apart({"--outputs": written, "--trace": tmp_path / "t.json"}, [read])
    linked = tmp_path / "link.npz"
    linked.symlink_to(read)
    for same in (read, tmp_path / "." / "in.npz", linked):
        with pytest.raises(VividcError, match=r"--outputs: .* is an input"):
            check_apart({"--outputs": same}, [read])
    with pytest.raises(VividcError, match=r"--trace: .* is also what --outputs writes"):
        check_apart({"--outputs": written, "--trace": written}, [read])
