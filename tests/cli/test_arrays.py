"""Arguments in `.npz` files fit the kernel's parameters, or the message says what is expected."""

import numpy as np
import pytest

from vividc.cli.arrays import describe, read_arguments, write_results
from vividc.errors import ArgumentError
from vividc.machine.params import DType, Param

PARAMS = (Param("x", DType.F32, 1), Param("w", DType.I32, 2), Param("n", DType.I32))
GOOD = {"x": np.zeros(4, np.float32), "w": np.zeros((2, 3), np.int32), "n": np.int64(4)}


def message(path, arrays):
    np.savez(path, **arrays)
    with pytest.raises(ArgumentError) as caught:
        read_arguments(path, PARAMS)
    return str(caught.value)


def test_arguments_come_in_parameter_order(tmp_path):
    np.savez(tmp_path / "in.npz", n=4, w=GOOD["w"], x=GOOD["x"])
    arguments = read_arguments(tmp_path / "in.npz", PARAMS)
    assert list(arguments) == ["x", "w", "n"]
    assert arguments["n"].shape == ()


def test_fortran_order_is_brought_into_c_order(tmp_path):
    w = np.asfortranarray(np.arange(6, dtype=np.int32).reshape(2, 3))
    np.savez(tmp_path / "in.npz", **{**GOOD, "w": w})
    read = read_arguments(tmp_path / "in.npz", PARAMS)["w"]
    assert read.flags.c_contiguous
    np.testing.assert_array_equal(read, w)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"x": np.zeros(4)}, "`x` is float64[4], not float32[:]"),
        ({"x": np.zeros((2, 2), np.float32)}, "`x` is float32[2,2], not float32[:]"),
        ({"x": np.zeros(4, ">f4")}, "`x` is >f4[4], not float32[:]"),
        ({"w": np.zeros(4, np.int32)}, "`w` is int32[4], not int32[:,:]"),
        ({"n": np.zeros(1, np.int32)}, "`n` is int32[1], not int32"),
        ({"n": 2**31}, "`n` = np.int64(2147483648) is not a int32"),
        ({"n": 1.5}, "is not a int32"),
        ({"m": 3}, "`m` is not a parameter"),
    ],
)
def test_misfits_say_what_is_expected(tmp_path, change, expected):
    text = message(tmp_path / "in.npz", {**GOOD, **change})
    assert expected in text
    assert text.endswith("hint: expected: x: float32[:], w: int32[:,:], n: int32")


def test_all_misfits_are_listed(tmp_path):
    text = message(tmp_path / "in.npz", {"x": np.zeros(4), "y": np.zeros(4)})
    for part in ("`w` is missing", "`n` is missing", "`y` is not a parameter", "`x` is float64"):
        assert part in text


@pytest.mark.parametrize(
    "content", [b"", b"PK\x03\x04 cut off", b"not an archive", b"\x80\x04K\x01."]
)
def test_other_files_are_refused(tmp_path, content):
    path = tmp_path / "in.npz"
    path.write_bytes(content)
    with pytest.raises(ArgumentError, match=r"in\.npz"):
        read_arguments(path, PARAMS)


def test_damage_at_any_place_is_an_argument_error_or_harmless(tmp_path):
    path = tmp_path / "in.npz"
    np.savez(path, **GOOD)
    content = path.read_bytes()
    for place in range(0, len(content), 3):
        path.write_bytes(content[:place] + bytes([content[place] ^ 0xFF]) + content[place + 1 :])
        try:
            assert len(read_arguments(path, PARAMS)) == 3
        except ArgumentError as error:
            assert str(path) in str(error)  # noqa: PT017 - either outcome is right


def test_pickled_objects_and_plain_npy_are_refused(tmp_path):
    np.savez(tmp_path / "in.npz", x=np.array([{}], dtype=object))
    with pytest.raises(ArgumentError, match=r"not a usable npz file: an array holds"):
        read_arguments(tmp_path / "in.npz", PARAMS)
    np.save(tmp_path / "in.npy", GOOD["x"])
    with pytest.raises(ArgumentError, match="an npy file, not an npz"):
        read_arguments(tmp_path / "in.npy", PARAMS)


def test_missing_file(tmp_path):
    with pytest.raises(ArgumentError, match="cannot be read: No such file"):
        read_arguments(tmp_path / "missing.npz", PARAMS)


def test_results_hold_arrays_and_the_returned_value(tmp_path):
    arrays = {key: np.asarray(value) for key, value in GOOD.items()} | {"file": GOOD["x"]}
    write_results(tmp_path / "out.npz", arrays, np.float32(2.5))
    with np.load(tmp_path / "out.npz") as archive:
        assert sorted(archive.files) == ["file", "return", "w", "x"]
        assert archive["return"] == 2.5


def test_describe():
    assert [describe(param) for param in PARAMS] == ["x: float32[:]", "w: int32[:,:]", "n: int32"]
