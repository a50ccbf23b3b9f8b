"""Checks of output paths, before any work is done for them."""

import os

import pytest

from vividc.cli.files import check_apart, check_output
from vividc.errors import VividcError


def test_missing_folder_is_refused_with_the_option(tmp_path):
    with pytest.raises(VividcError, match=r"--output: the folder .* does not exist"):
        check_output(tmp_path / "missing" / "out", "--output")
    with pytest.raises(VividcError, match="is a folder"):
        check_output(tmp_path, "--output")
    check_output(tmp_path / "out", "--output")


def test_what_is_no_file_is_written_through_wherever_it_lies(tmp_path):
    """An ordinary user may write to /dev/null, and not into /dev."""
    fifo, link = tmp_path / "fifo", tmp_path / "link"
    os.mkfifo(fifo)
    link.symlink_to(tmp_path / "missing" / "out")
    check_output(fifo, "--output")
    with pytest.raises(VividcError, match=r"--output: the folder .*missing` does not exist"):
        check_output(link, "--output")
    check_apart({"--outputs": fifo, "--trace": fifo}, [fifo])


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
