"""Every method's file is told from the others, and every broken one is named with its field."""

from __future__ import annotations

from pathlib import Path
from zipfile import ZIP_STORED, ZipFile

import numpy as np
import pytest

from vividc.render import Camera, SceneError, orbit_camera, read_scene, render_reference
from vividc.render.arrays import frozen_float32

MIC = Path(__file__).parents[2] / "scenes" / "mic"
METHODS = {
    "mic_3dgs_sh3.ply": "3dgs",
    "mic_kilonerf.npz": "kilonerf",
    "mic_ngp_hash.npz": "instant-ngp",
    "mic_tensorf_vm.npz": "tensorf",
}
GAUSSIANS = {
    "means": np.zeros((2, 3), dtype=np.float32),
    "log_scales": np.full((2, 3), -2, dtype=np.float16),
    "quats_wxyz": np.array([[2, 0, 0, 0], [0, 1, 0, 0]], dtype=np.float16),
    "opacity": np.array([0.5, 1.0], dtype=np.float16),
    "sh": np.zeros((2, 9, 3), dtype=np.float16),
}


def changed(folder: Path, source: dict[str, np.ndarray], **changes: object) -> Path:
    arrays = {**source, **changes}
    path = folder / "scene.npz"
    np.savez(path, **{name: array for name, array in arrays.items() if array is not None})
    return path


@pytest.mark.parametrize("name", METHODS)
def test_the_method_is_told_by_the_file(name: str) -> None:
    assert read_scene(MIC / name)[0] == METHODS[name]
    assert read_scene(MIC / name, METHODS[name])[0] == METHODS[name]
    other = next(method for method in METHODS.values() if method != METHODS[name])
    with pytest.raises(SceneError, match=f"a scene of {METHODS[name]}, not {other}"):
        read_scene(MIC / name, other)


@pytest.mark.parametrize(
    ("name", "changes", "text"),
    [
        ("kilonerf", {"w3": None}, "`w3` is missing"),
        ("kilonerf", {"b4": np.zeros((274, 31))}, "`b4` has shape [274, 31], not [274, 32]"),
        ("kilonerf", {"net_index": np.full((2, 2, 2), 274)}, "networks outside the 274"),
        ("kilonerf", {"net_index": np.zeros((2, 2, 2))}, "`net_index` holds float64, not integers"),
        ("kilonerf", {"occ_bits": np.zeros(9, dtype=np.uint8)}, "holds 72 bits, fewer than"),
        ("kilonerf", {"occ_bits": np.full(283008, 256)}, "values that are no bytes"),
        ("kilonerf", {"occ_shape": np.array([0, 1, 1])}, "occ_shape [0, 1, 1] is not positive"),
        ("kilonerf", {"step": np.float32(0)}, "step is 0, not above 0"),
        ("kilonerf", {"n_samples": np.float32(0.5)}, "n_samples is 0.5, not a whole number"),
        ("kilonerf", {"n_samples": np.array([2**31 - 1])}, "a ray has at most 8192"),
        ("kilonerf", {"far": np.float32(1)}, "far is 1, not above 2"),
        ("kilonerf", {"aabb": np.zeros((2, 3))}, "is not a lowest and a highest corner"),
        ("ngp_hash", {"table": np.zeros((5, 2))}, "leave the 5 table rows"),
        ("ngp_hash", {"level_dense": np.zeros(16, dtype=int)}, "is no power of two"),
        ("ngp_hash", {"rgb1": np.full((64, 64), np.nan)}, "rgb1[0, 0] is nan"),
        ("ngp_hash", {"rgb1": np.full((64, 64), 1e39)}, "not a finite float32 (4096 such values)"),
        ("ngp_hash", {"sigma0": np.zeros((64, 30))}, "not [any, 32]"),
        ("tensorf_vm", {"grid_res": np.array([1, 9, 9])}, "fewer than two nodes"),
        ("tensorf_vm", {"app_line_1": np.zeros((48, 12))}, "`app_line_1` has shape [48, 12]"),
        ("tensorf_vm", {"basis_w": np.zeros((27, 3))}, "not [27, 144]"),
        ("tensorf_vm", {"mlp_w0": np.zeros((128, 151))}, "not [128, 150]"),
    ],
)
def test_broken_models_are_named_with_their_field(
    tmp_path: Path, name: str, changes: dict[str, object], text: str
) -> None:
    with np.load(MIC / f"mic_{name}.npz", allow_pickle=False) as archive:
        path = changed(tmp_path, dict(archive), **changes)
    with pytest.raises(SceneError) as raised:
        read_scene(path)
    assert text in str(raised.value)
    assert str(path) in str(raised.value)
    assert "hint: " in str(raised.value)


def test_gaussians_of_an_archive(tmp_path: Path) -> None:
    method, scene = read_scene(changed(tmp_path, GAUSSIANS))
    assert (method, len(scene), scene.sh_degree) == ("3dgs", 2, 2)
    np.testing.assert_allclose(scene.scales, np.exp(-2), rtol=1e-6)
    np.testing.assert_array_equal(scene.rotations[0], [1, 0, 0, 0])


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"opacity": np.array([2.0, -3])}, "opacity leaves 0..1"),
        ({"sh": np.zeros((2, 5, 3))}, "5 coefficients a channel"),
        ({"quats_wxyz": np.zeros((2, 4))}, "quats_wxyz[0] is the zero quaternion"),
        ({"log_scales": np.zeros((3, 3))}, "`log_scales` has shape [3, 3], not [2, 3]"),
        ({"means": np.full((2, 3), np.inf)}, "means[0, 0] is inf"),
        ({"means": None}, "no scene: it holds log_scales, opacity, quats_wxyz, sh"),
    ],
)
def test_broken_gaussians(tmp_path: Path, changes: dict[str, object], text: str) -> None:
    with pytest.raises(SceneError) as raised:
        read_scene(changed(tmp_path, GAUSSIANS, **changes))
    assert text in str(raised.value)


def test_files_that_are_no_archives(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="cannot be read: No such file"):
        read_scene(tmp_path / "absent.npz")
    with pytest.raises(SceneError, match="cannot be read: No such file"):
        read_scene(tmp_path / "absent")
    path = tmp_path / "scene.npz"
    for content in (b"", b"PK\3\4 not a zip", (MIC / "mic_ngp_hash.npz").read_bytes()[:100_000]):
        path.write_bytes(content)
        with pytest.raises(SceneError, match="not a usable npz file"):
            read_scene(path)
    np.save(tmp_path / "scene.npy", np.zeros(3))
    path.write_bytes((tmp_path / "scene.npy").read_bytes())
    with pytest.raises(SceneError, match="an npy file"):
        read_scene(path)
    changed(tmp_path, GAUSSIANS, means=np.array([{}], dtype=object))
    with pytest.raises(SceneError, match="not plain numbers"):
        read_scene(path)


def test_a_damaged_member_is_refused(tmp_path: Path) -> None:
    path = changed(tmp_path, GAUSSIANS)
    data = bytearray(path.read_bytes())
    with ZipFile(path) as archive:
        info = archive.getinfo("sh.npy")
        assert info.compress_type == ZIP_STORED
    data[info.header_offset + 250] ^= 255
    path.write_bytes(bytes(data))
    with pytest.raises(SceneError, match="not a usable npz file"):
        read_scene(path)


def test_a_ply_is_known_by_its_first_bytes(tmp_path: Path) -> None:
    (tmp_path / "scene").write_bytes((MIC / "mic_3dgs_sh3.ply").read_bytes())
    assert read_scene(tmp_path / "scene")[0] == "3dgs"


@pytest.mark.parametrize("up", ["+x", "-y", "+z"])
def test_the_orbit_camera_sees_the_scene(tmp_path: Path, up: str) -> None:
    scene = read_scene(changed(tmp_path, GAUSSIANS))[1]
    camera = orbit_camera(scene, 40, 10, up, 32, 24)
    rotation = camera.c2w[:3, :3]
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-6)
    assert np.linalg.det(rotation) == pytest.approx(1, abs=1e-6)
    towards = -rotation[:, 2] @ (np.zeros(3) - camera.position)
    assert towards == pytest.approx(np.linalg.norm(camera.position), rel=1e-5)
    axis = {"+x": [1, 0, 0], "-y": [0, -1, 0], "+z": [0, 0, 1]}[up]
    assert rotation[:, 1] @ np.array(axis) > 0.9
    assert (render_reference(scene, camera).image < 1).any()


def test_scenes_of_no_gaussian_are_white(tmp_path: Path) -> None:
    empty = {name: array[:0] for name, array in GAUSSIANS.items()}
    scene = read_scene(changed(tmp_path, empty))[1]
    picture = render_reference(scene, orbit_camera(scene, 0, 0, "+z", 20, 20))
    np.testing.assert_array_equal(picture.image, np.ones((20, 20, 3)))


def test_impossible_orbits(tmp_path: Path) -> None:
    scene = read_scene(changed(tmp_path, GAUSSIANS))[1]
    for azimuth, elevation in ((np.nan, 0), (0, 90), (0, np.nan)):
        with pytest.raises(SceneError, match="no camera at"):
            orbit_camera(scene, azimuth, elevation, "+z", 8, 8)


def test_everything_behind_the_camera_is_white(tmp_path: Path) -> None:
    scene = read_scene(changed(tmp_path, GAUSSIANS))[1]
    pose = np.eye(4)
    pose[2, 3] = -5
    picture = render_reference(scene, Camera(frozen_float32(pose), 20, 16, 16))
    np.testing.assert_array_equal(picture.image, np.ones((16, 16, 3)))
    assert picture.counts["visible_gaussians"] == 0


def test_a_scalar_may_have_an_axis_of_one(tmp_path: Path) -> None:
    with np.load(MIC / "mic_kilonerf.npz", allow_pickle=False) as archive:
        arrays = {**archive, "far": archive["far"].reshape(1)}
    np.savez(tmp_path / "scene.npz", **arrays)
    assert read_scene(tmp_path / "scene.npz")[1].march.far == 6.0


def test_a_picture_of_no_numbers_is_a_message(tmp_path: Path) -> None:
    sh = np.full((2, 9, 3), 3e38, dtype=np.float32)
    path = changed(tmp_path, GAUSSIANS, sh=sh, log_scales=np.zeros((2, 3)))
    camera = orbit_camera(scene := read_scene(path)[1], 30.0, 20.0, "+z", 8, 8)
    with pytest.raises(SceneError, match="pixels are not finite: values of the scene"):
        render_reference(scene, camera)
