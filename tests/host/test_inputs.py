"""What a file promises is checked before its data is read; the messages name limit and way out."""

from __future__ import annotations

import importlib.util
import io
import json
import os
import zipfile
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

import vividc
from tests.fuzz.file_kinds import KERNEL
from vividc import arch, dfg, load_ll, program
from vividc.arch.cost.tables import load_costs
from vividc.cli.commands.verify import read_json
from vividc.cli.kernels import load_kernel
from vividc.errors import VividcError
from vividc.host.files import write_whole
from vividc.host.inputs import ARGUMENT_BYTES, VARIABLE, limit, read_bytes
from vividc.host.npz import read_npz
from vividc.program.bundle import SCHEMA
from vividc.render import load_cameras, read_scene, read_views
from vividc.render.views import read_picture


def npy(shape: str, data: bytes = b"", descr: str = "<f4") -> bytes:
    """An npy file whose header says what it likes."""
    text = f"{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text + data


def archive(path: Path, member: bytes, method: int = zipfile.ZIP_DEFLATED) -> Path:
    with zipfile.ZipFile(path, "w", method) as file:
        file.writestr("x.npy", member)
    return path


@pytest.mark.parametrize(
    ("member", "reason"),
    [
        (npy("(4398046511104,)"), "promises 16 TiB, and there are 0 bytes"),
        (npy("(2,)", bytes(4)), "promises 8 bytes, and there are 4 bytes"),
        (npy("(-1,)"), "no usable shape"),
        (npy("(True,)", bytes(4)), "no usable shape"),
        (npy("(1,)", bytes(8), "|O"), "not plain numbers"),
        (npy("(1,)", b"", "<U0"), "not plain numbers"),
        (npy("((" * 200), "malformed"),
        (npy("(1,)", bytes(4), "<q9"), "no usable dtype"),
        (b"\x93NUMPY\x09\x00", "does not begin as an npy file"),
        (b"", "ends early"),
    ],
)
def test_a_header_that_lies_is_refused(tmp_path: Path, member: bytes, reason: str) -> None:
    path = archive(tmp_path / "in.npz", member)
    with pytest.raises(VividcError, match=f"not a usable npz file: .*{reason}"):
        read_npz(path, ARGUMENT_BYTES, VividcError)


def test_what_unpacks_to_more_than_the_limit_is_refused_unread(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = archive(tmp_path / "bomb.npz", npy("(1048576,)", bytes(4 << 20)))
    assert path.stat().st_size < 10_000
    with pytest.raises(VividcError, match=rf"4 MiB unpacked: the limit is 1 MiB\n.*{VARIABLE}"):
        read_npz(path, 1 << 20, VividcError)
    monkeypatch.setenv(VARIABLE, "8MiB")
    assert read_npz(path, 1 << 20, VividcError)["x"].shape == (1048576,)


def test_a_method_without_a_bound_is_refused(tmp_path: Path) -> None:
    path = archive(tmp_path / "in.npz", npy("(1,)", bytes(4)), zipfile.ZIP_LZMA)
    with pytest.raises(VividcError, match="packed in a way"):
        read_npz(path, ARGUMENT_BYTES, VividcError)


def test_arrays_come_back_as_they_were(tmp_path: Path) -> None:
    given = {
        "f": np.asfortranarray(np.arange(6.0).reshape(2, 3)),
        "s": np.float32(2.5),
        "e": np.zeros((0, 3), np.int32),
        "b": np.array([[[True]]]),
    }
    np.savez_compressed(tmp_path / "in.npz", **given)
    found = read_npz(tmp_path / "in.npz", ARGUMENT_BYTES, VividcError)
    assert found.keys() == given.keys()
    for name, array in given.items():
        assert found[name].dtype == array.dtype
        np.testing.assert_array_equal(found[name], array)


def test_each_flipped_bit_is_read_or_refused(tmp_path: Path) -> None:
    data = io.BytesIO()
    np.savez(data, x=np.arange(3))
    whole, path = data.getvalue(), tmp_path / "in.npz"
    for at in range(len(whole)):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ (1 << at % 8)]) + whole[at + 1 :])
        with suppress(VividcError):  # and nothing else
            read_npz(path, ARGUMENT_BYTES, VividcError)


READERS = {
    "p.vivid": program.load,
    "g.json": dfg.load,
    "f.yaml": arch.load,
    "a.yaml": arch.load_accelerator,
    "c.yaml": load_costs,
    "s.ply": read_scene,
    "s.npz": read_scene,
    "s": read_scene,
    "v.json": read_views,
    "v.npz": read_views,
    "cameras.npz": load_cameras,
    "k.py": lambda path: load_kernel(str(path)),
    "k.ll": lambda path: load_ll(path, "f"),
    "m.json": read_json,
    "p.png": read_picture,
    "in.npz": lambda path: read_npz(path, ARGUMENT_BYTES, VividcError),
}
"""By names that their files may have."""


@pytest.mark.parametrize("name", READERS)
def test_an_endless_device_is_no_input(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.symlink_to("/dev/zero")
    with pytest.raises(VividcError, match=rf"{name}: "):
        READERS[name](path)


@pytest.mark.parametrize("name", READERS)
@pytest.mark.parametrize("odd", ["is a folder", "a\0b", "\ud800", "is not there"])
def test_what_is_no_file_is_a_message(tmp_path: Path, name: str, odd: str) -> None:
    path = tmp_path / odd / name
    if odd == "is a folder":
        path.mkdir(parents=True)
    with pytest.raises(VividcError) as raised:
        READERS[name](path)
    assert name in str(raised.value)
    assert "\0" not in str(raised.value)


@pytest.mark.parametrize("path", ["a\0b", "\ud800", "no/such/folder"])
def test_what_can_be_no_file_cannot_be_written(path: str) -> None:
    with pytest.raises(VividcError, match="cannot be written: "):
        write_whole(Path(path), b"")


def test_kernels_of_paths_that_are_not_utf8_are_refused_by_name(tmp_path: Path) -> None:
    folder = tmp_path / os.fsdecode(b"\xff")
    folder.mkdir()
    (folder / "k.py").write_text(KERNEL)
    (folder / "k.ll").write_text("define void @f() { ret void }")
    spec = importlib.util.spec_from_file_location("k", folder / "k.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    for refused in (lambda: vividc.compile(module.sums), lambda: load_ll(folder / "k.ll", "f")):
        with pytest.raises(VividcError, match="must be UTF-8\nhint: rename it"):
            refused()


def test_extends_runs_through_few_files(tmp_path: Path) -> None:
    for number in range(40):
        (tmp_path / f"{number}.yaml").write_text(f"extends: {number + 1}.yaml\n")
    for read in (arch.load, arch.load_accelerator):
        with pytest.raises(VividcError, match="`extends` runs through more than 8 files"):
            read(tmp_path / "0.yaml")


def test_a_source_of_half_a_character_is_no_source(tmp_path: Path) -> None:
    text = json.dumps({"schema": SCHEMA, "provenance": {"kernel_file": "\ud800"}})
    (tmp_path / "p.vivid").write_bytes(bundle_of(text))
    with pytest.raises(VividcError, match=r"not a complete \.vivid file"):
        program.load(tmp_path / "p.vivid")


def test_a_limit_that_is_no_size_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "lots")
    with pytest.raises(VividcError, match=f"{VARIABLE}: `lots` is not a size"):
        limit(1)


def test_a_path_with_a_nul_cannot_be_read() -> None:
    with pytest.raises(VividcError, match="cannot be read: embedded null byte"):
        read_bytes(Path("a\0b"), 1)


MANY = '{"nodes": [' + "[]," * 600_000 + "[]]}"


def bundle_of(text: str) -> bytes:
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as file:
        for name in ("program.json", "words.npy", "images.npy", "images_set.npy"):
            file.writestr(name, text if name == "program.json" else "")
    return data.getvalue()


@pytest.mark.parametrize(("read", "name"), [(dfg.load, "g.json"), (read_views, "v.json")])
def test_json_of_too_many_values_is_refused_before_it_is_parsed(
    tmp_path: Path, read: object, name: str
) -> None:
    path = tmp_path / name
    path.write_text(MANY)
    assert callable(read)
    with pytest.raises(
        VividcError, match=f"more than 1,048,576 values of JSON\nhint: .*{VARIABLE}"
    ):
        read(path)


@pytest.mark.parametrize(
    ("name", "text", "what"),
    [
        ("g.dot", "digraph {" + "a;" * 300_000 + "}", "words and marks of DOT"),
        ("g.xml", "<DFG>" + "<a/>" * 600_000, "tags of XML"),
        ("g.dfg", 'dfg "a"\n' + "\n" * 600_000, "lines"),
    ],
)
def test_graphs_of_too_many_parts_are_refused(
    tmp_path: Path, name: str, text: str, what: str
) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(VividcError, match=f"{name}: more than 524,288 {what}\nhint: "):
        dfg.load(tmp_path / name)


def test_a_program_of_too_many_values_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vividc.program.bundle.BUNDLE_BYTES", 4 << 20)
    (tmp_path / "p.vivid").write_bytes(bundle_of(MANY))
    with pytest.raises(VividcError, match="more than 131,072 values of JSON"):
        program.load(tmp_path / "p.vivid")


def test_yaml_has_limits_of_size_and_depth(tmp_path: Path) -> None:
    path = tmp_path / "f.yaml"
    for text, reason in (
        ("rows: [" + "1," * 140_000 + "1]", "a file of 273.4 KiB: the limit is 256 KiB"),
        ("rows: " + "[" * 40 + "]" * 40, "f.yaml:1: nested too deeply"),
        ("rows: " + "[" * 100_000, "f.yaml: nested too deeply"),
        ('rows: "\\ud800"', "is no text of Unicode characters"),
        ('"\\udcff": 1', "is no text of Unicode characters"),
    ):
        path.write_text(text)
        with pytest.raises(VividcError, match=reason):
            arch.load(path)
