"""Reading 3DGS scenes: round trips through a writer of our own, and malformed files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vividc.render import Gaussians, SceneError, read_gaussians

COUNT = 5


def stored_values(degree: int, seed: int = 0) -> dict[str, np.ndarray]:
    """Return random stored (not activated) properties in the order of the INRIA layout."""
    rng = np.random.default_rng(seed)
    rest = 3 * ((degree + 1) ** 2 - 1)
    names = ["x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"]
    names += [f"f_rest_{i}" for i in range(rest)]
    names += ["opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"]
    return {name: rng.normal(size=COUNT).astype(np.float32) for name in names}


def ply_bytes(values: dict[str, np.ndarray], form: str = "binary_little_endian") -> bytes:
    count = len(next(iter(values.values())))
    header = ["ply", f"format {form} 1.0", "comment made by a test", f"element vertex {count}"]
    header += [f"property float {name}" for name in values]
    head = "\n".join([*header, "end_header\n"]).encode()
    table = np.stack(list(values.values()), axis=1)
    if form == "ascii":
        return head + "".join(" ".join(f"{v:.9g}" for v in row) + "\n" for row in table).encode()
    return head + table.astype("<f4").tobytes()


def write(tmp_path: Path, data: bytes) -> Path:
    path = tmp_path / "scene.ply"
    path.write_bytes(data)
    return path


def assert_holds(scene: Gaussians, values: dict[str, np.ndarray]) -> None:
    def columns(*names: str) -> np.ndarray:
        return np.stack([values[name] for name in names], axis=1)

    rotation = columns("rot_0", "rot_1", "rot_2", "rot_3")
    np.testing.assert_array_equal(scene.means, columns("x", "y", "z"))
    np.testing.assert_allclose(
        scene.scales, np.exp(columns("scale_0", "scale_1", "scale_2")), rtol=1e-6
    )
    np.testing.assert_allclose(
        scene.rotations, rotation / np.linalg.norm(rotation, axis=1)[:, None], rtol=1e-5
    )
    np.testing.assert_allclose(scene.opacity, 1 / (1 + np.exp(-values["opacity"])), rtol=1e-6)
    per_channel = scene.sh.shape[1] - 1
    for channel in range(3):
        np.testing.assert_array_equal(scene.sh[:, 0, channel], values[f"f_dc_{channel}"])
        for k in range(per_channel):
            stored = values[f"f_rest_{per_channel * channel + k}"]
            np.testing.assert_array_equal(scene.sh[:, k + 1, channel], stored)


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian"])
@pytest.mark.parametrize("degree", [0, 1, 2, 3])
def test_round_trip(tmp_path: Path, form: str, degree: int) -> None:
    values = stored_values(degree)
    scene = read_gaussians(write(tmp_path, ply_bytes(values, form)))
    assert len(scene) == COUNT
    assert scene.sh_degree == degree
    assert_holds(scene, values)


def test_properties_are_found_by_name_in_any_order(tmp_path: Path) -> None:
    values = stored_values(degree=1)
    shuffled = {name: values[name] for name in sorted(values, reverse=True)}
    assert_holds(read_gaussians(write(tmp_path, ply_bytes(shuffled))), values)


def test_property_types_are_read_from_the_header(tmp_path: Path) -> None:
    values = stored_values(degree=0)
    head, body = ply_bytes(values).split(b"end_header\n")
    wide = np.frombuffer(body, "<f4").astype("<f8").tobytes()
    data = head.replace(b"property float", b"property double") + b"end_header\n" + wide
    assert_holds(read_gaussians(write(tmp_path, data)), values)


def test_windows_line_ends_in_the_header(tmp_path: Path) -> None:
    values = stored_values(degree=0)
    head, body = ply_bytes(values).split(b"end_header\n")
    data = (head + b"end_header\n").replace(b"\n", b"\r\n") + body
    assert_holds(read_gaussians(write(tmp_path, data)), values)


def test_later_elements_are_ignored(tmp_path: Path) -> None:
    values = stored_values(degree=0)
    data = ply_bytes(values).replace(
        b"end_header\n", b"element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    )
    assert_holds(read_gaussians(write(tmp_path, data + b"\x03" + bytes(12))), values)


def test_a_scene_may_be_empty(tmp_path: Path) -> None:
    empty = {name: column[:0] for name, column in stored_values(degree=3).items()}
    assert len(read_gaussians(write(tmp_path, ply_bytes(empty)))) == 0
    assert len(read_gaussians(write(tmp_path, ply_bytes(empty, "ascii")))) == 0


def test_extreme_opacity_and_scale_stay_finite(tmp_path: Path) -> None:
    values = stored_values(degree=0)
    values["opacity"][:2] = -500, 500
    values["scale_0"][:2] = -500, 500
    scene = read_gaussians(write(tmp_path, ply_bytes(values)))
    np.testing.assert_array_equal(scene.opacity[:2], [0, 1])
    assert np.isfinite(scene.scales).all()


def test_arrays_are_read_only(mic: Gaussians) -> None:
    assert len(mic) == 15_933
    with pytest.raises(ValueError, match="read-only"):
        mic.means[0, 0] = 1


def without(values: dict[str, np.ndarray], name: str) -> dict[str, np.ndarray]:
    return {key: column for key, column in values.items() if key != name}


def with_value(name: str, value: float) -> dict[str, np.ndarray]:
    values = stored_values(degree=0)
    values[name][2] = value
    return values


def with_zero_rotation() -> dict[str, np.ndarray]:
    values = stored_values(degree=0)
    for i in range(4):
        values[f"rot_{i}"][3] = 0
    return values


GOOD = ply_bytes(stored_values(degree=0))
GOOD_ASCII = ply_bytes(stored_values(degree=0), "ascii")
MALFORMED = {
    "empty": (b"", "not a PLY file"),
    "png": (b"\x89PNG\r\n", "not a PLY file"),
    "no header end": (GOOD[:100], "no `end_header`"),
    "truncated": (GOOD[:-1], "truncated: 5 vertices need 340 bytes after the header"),
    "truncated ascii": (GOOD_ASCII[:-100], "truncated: 4 of 5"),
    "not a number": (GOOD_ASCII[:-2] + b"e\n", "not a number"),
    "big endian": (GOOD.replace(b"little", b"big"), "format binary_big_endian"),
    "no format": (GOOD.replace(b"format", b"comment"), r"format \(none given\)"),
    "no vertices": (GOOD.replace(b"element vertex 5\n", b""), "not `vertex`"),
    "vertices second": (
        GOOD.replace(b"element vertex", b"element face 0\nelement vertex"),
        "not `vertex`",
    ),
    "negative count": (GOOD.replace(b"vertex 5", b"vertex -5"), "vertex count -5"),
    "no count": (GOOD.replace(b"vertex 5", b"vertex"), "vertex count"),
    "list property": (GOOD.replace(b"float nx", b"list uchar int nx"), "list uchar int nx"),
    "same name twice": (GOOD.replace(b"float nx", b"float x"), "property float x"),
    "missing opacity": (
        ply_bytes(without(stored_values(degree=0), "opacity")),
        "missing vertex property opacity",
    ),
    "missing f_rest": (
        ply_bytes(without(stored_values(degree=2), "f_rest_7")),
        "23 properties f_rest",
    ),
    "nan": (ply_bytes(with_value("scale_1", np.nan)), "scale_1 holds a value that is not finite"),
    "zero rotation": (ply_bytes(with_zero_rotation()), "rotation of vertex 3"),
}


@pytest.mark.parametrize("name", MALFORMED)
def test_malformed_files_name_file_fault_and_way_out(tmp_path: Path, name: str) -> None:
    data, fault = MALFORMED[name]
    path = write(tmp_path, data)
    with pytest.raises(SceneError, match=fault) as raised:
        read_gaussians(path)
    assert str(path) in str(raised.value)
    assert "hint: " in str(raised.value)


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="No such file") as raised:
        read_gaussians(tmp_path / "absent.ply")
    assert "absent.ply" in str(raised.value)


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian"])
@pytest.mark.parametrize(
    ("count", "reason"),
    [
        ("999999999999", "truncated: "),
        ("9" * 30, "the vertex count 9999"),
        ("9" * 5000, "the vertex count 9999"),
    ],
)
def test_a_count_that_lies_asks_for_no_memory(
    tmp_path: Path, form: str, count: str, reason: str
) -> None:
    data = ply_bytes(stored_values(0), form).replace(b"vertex 5", f"vertex {count}".encode())
    with pytest.raises(SceneError, match=reason) as raised:
        read_gaussians(write(tmp_path, data))
    assert len(str(raised.value)) < 600


def test_a_header_without_an_end_is_not_searched_for_it(tmp_path: Path) -> None:
    data = b"ply\n" + b"comment x\n" * 20_000 + b"end_header\n"
    with pytest.raises(SceneError, match="no `end_header` line in its first 64 KiB"):
        read_gaussians(write(tmp_path, data))


def test_text_of_many_blocks_is_read_as_its_binary(tmp_path: Path) -> None:
    values = {name: np.resize(column, 10_000) for name, column in stored_values(1).items()}
    text, binary = (
        read_gaussians(write(tmp_path, ply_bytes(values, form)))
        for form in ("ascii", "binary_little_endian")
    )
    for name in ("means", "scales", "rotations", "opacity", "sh"):
        np.testing.assert_array_equal(getattr(text, name), getattr(binary, name))


def test_values_beyond_float32_are_refused(tmp_path: Path) -> None:
    data = ply_bytes(stored_values(0), "ascii")
    data = data.replace(b"property float x", b"property double x")
    head, mark, body = data.partition(b"end_header\n")
    data = head + mark + b"1e39" + body[body.index(b" ") :]
    with pytest.raises(SceneError, match="property x holds a value that is not finite in float32"):
        read_gaussians(write(tmp_path, data))
