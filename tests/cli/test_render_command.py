"""`vividc render`: pictures, figures and messages."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from PIL import Image

from vividc.cli import main
from vividc.render import Camera, Scene, read_views
from vividc.render.array import ArrayFrame, ArrayOptions, open_device
from vividc.render.array.device.launch import Launch, Move

MIC = Path(__file__).parents[2] / "scenes" / "mic"


def run(*args: object) -> Result:
    return CliRunner().invoke(main, ["render", *(str(arg) for arg in args)])


def figures(*args: object) -> dict[str, object]:
    done = run(*args, "--json")
    assert done.exit_code == 0, done.output
    assert done.stderr == ""
    return json.loads(done.stdout)


def test_a_view_is_rendered_and_compared(tmp_path: Path) -> None:
    path = tmp_path / "view.png"
    views = MIC / "ref_kilo.npz"
    body = figures(MIC / "mic_kilonerf.npz", "--views", views, "--size", "50x50", "-o", path)
    assert (body["schema"], body["method"]) == ("vividc.render/1", "kilonerf")
    assert (body["width"], body["height"], body["output"]) == (50, 50, str(path))
    assert body["psnr_truth_db"] > 24  # the mean of 4x4 pixels of the 200x200 render
    assert body["ssim_truth"] > 0.9
    counts = body["counts"]
    assert counts["colour_samples"] == counts["counted_samples"] < counts["density_samples"]
    truth = read_views(views)[0].truth_at(50, 50)
    error = np.asarray(Image.open(path)) / 255.0 - truth
    assert -10 * np.log10((error**2).mean()) == pytest.approx(body["psnr_truth_db"], abs=0.1)


@pytest.mark.parametrize("name", ["mic_3dgs_sh3.ply", "mic_ngp_hash.npz", "mic_tensorf_vm.npz"])
def test_lookahead_changes_the_work_but_not_the_picture(tmp_path: Path, name: str) -> None:
    on, off = tmp_path / "on.png", tmp_path / "off.png"
    size = ("--size", "24x16")
    early = figures(MIC / name, *size, "-o", on)
    late = figures(MIC / name, *size, "--lookahead", "off", "-o", off)
    assert on.read_bytes() == off.read_bytes()
    assert early["psnr_truth_db"] is None
    work = "exponentials" if name.endswith(".ply") else "colour_samples"
    assert 0 < early["counts"][work] < late["counts"][work]
    assert np.asarray(Image.open(on)).min() < 128


def test_a_table_for_people() -> None:
    done = run(MIC / "mic_kilonerf.npz", "--size", "8x8", "--azimuth", "200", "--up", "-z")
    assert done.exit_code == 0
    for text in ("kilonerf", "8x8", "a camera around the scene", "density samples"):
        assert text in done.stdout


def test_views_without_pictures_give_no_figures(tmp_path: Path) -> None:
    path = tmp_path / "transforms.json"
    pose = read_views(MIC / "ref_gs.npz")[0].camera.c2w.tolist()
    path.write_text(json.dumps({"camera_angle_x": 0.69, "frames": [{"transform_matrix": pose}]}))
    body = figures(MIC / "mic_3dgs_sh3.ply", "--views", path, "--size", "16x16")
    assert body["psnr_truth_db"] is None
    assert body["ssim_truth"] is None
    assert body["counts"]["blended"] > 0


@pytest.mark.parametrize(
    ("args", "text"),
    [
        (("absent.ply",), "absent.ply: cannot be read: No such file"),
        ((MIC / "ref_gs.npz",), "no scene: it holds c2w, focal, images"),
        ((MIC / "mic_kilonerf.npz", "--method", "3dgs"), "a scene of kilonerf, not 3dgs"),
        ((MIC / "mic_kilonerf.npz", "--view", "1"), "--view: there are no views"),
        (
            (MIC / "mic_kilonerf.npz", "--views", MIC / "ref_kilo.npz", "--view", "2"),
            "there is no view 2",
        ),
        (
            (MIC / "mic_kilonerf.npz", "--views", MIC / "ref_kilo.npz", "--size", "8x9"),
            "another aspect ratio",
        ),
        ((MIC / "mic_kilonerf.npz", "--blend", "a.vivid"), "only the array blends with it"),
        (
            (MIC / "mic_kilonerf.npz", "--engine", "array", "--blend", "a.vivid"),
            "only scenes of 3DGS are blended with it",
        ),
        ((MIC / "mic_kilonerf.npz", "--sample", "0.1"), "only the array is simulated"),
        ((MIC / "mic_kilonerf.npz", "--mode", "gpu"), "only networks on the array have one"),
        (
            ("--engine", "array", MIC / "mic_kilonerf.npz", "--mode", "tpu-unified"),
            "--mode: only the networks of Instant-NGP and TensoRF have one",
        ),
        (
            ("--engine", "array", MIC / "mic_ngp_hash.npz", "--mode", "gpu", "--precision", "fp8"),
            "--mode: layers of fp8 numbers run in the TPU-like modes only",
        ),
        (
            (MIC / "mic_kilonerf.npz", "--engine", "array", "--sample", "nan", "--size", "8x8"),
            "a share of nan of the blocks cannot be simulated",
        ),
        (
            (MIC / "mic_kilonerf.npz", "--engine", "array", "--fabric", "vivid-tile"),
            "vivid-tile",
        ),
        (
            (MIC / "mic_3dgs_sh3.ply", "--engine", "array", "--blend", "absent.vivid"),
            "absent.vivid",
        ),
        (
            ("--engine", "array", MIC / "mic_3dgs_sh3.ply", "--blend", "a.vivid", "--sample", ".5"),
            "with --blend all is simulated",
        ),
        ((MIC / "mic_ngp_hash.npz", "--precision", "fp8"), "--precision: the reference is in fp32"),
        (
            ("--engine", "array", MIC / "mic_3dgs_sh3.ply", "--blend", "a", "--precision", "fp8"),
            "with --blend its program decides",
        ),
        ((MIC / "mic_kilonerf.npz", "--size", "8"), "8 is not a size like 800x800"),
        ((MIC / "mic_kilonerf.npz", "--size", "0x8"), "sides are 1 to 8192 pixels"),
        ((MIC / "mic_kilonerf.npz", "--elevation", "90"), "no camera at azimuth"),
        ((MIC / "mic_kilonerf.npz", "--exponent-margin", "nan"), "not a finite number"),
        (
            (MIC / "mic_kilonerf.npz", "--size", "4x4", "--weight-min", "1"),
            "--weight-min: a sample's weight cannot be wanted above 1",
        ),
        ((MIC / "mic_kilonerf.npz", "-o", "a.jpg"), "-o: `a.jpg` does not end in .png"),
        ((MIC / "mic_kilonerf.npz", "-o", "absent/a.png"), "the folder `absent` does not exist"),
        ((MIC / "mic_kilonerf.npz", "--views", "absent.json"), "cannot be read"),
    ],
)
def test_mistakes_are_messages(args: tuple[object, ...], text: str) -> None:
    done = run(*args)
    assert done.exit_code == 2
    assert text in done.stderr
    assert done.stdout == ""


def test_a_frame_of_the_array_is_told_stage_by_stage(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vividc.cli.commands.render.render_array", drawn)
    args = (MIC / "mic_kilonerf.npz", "--engine", "array", "--size", "16x16", "--sample", "0.5")
    printed = run(*args, "--json")
    assert (printed.exit_code, printed.stderr) == (0, "compiling saxpy\n")
    whole = json.loads(printed.stdout)
    assert [whole[name] for name in ("engine", "lookahead", "precision", "mode")] == [
        *("array", "on", "fp32", "auto")
    ]
    body = whole["frame"]
    assert (body["fabric"], body["sampled"]) == ("vivid", 0.5)
    assert body["stopped_by_clock"] == ["saxpy: the search was stopped by the clock"]
    assert body["avoided"] == {"colour_path": 0.75}
    (stage,) = body["stages"]
    assert (stage["name"], stage["mode"], stage["jobs"]) == ("colour network", "gpu", 1)
    assert stage["cycles"] == body["cycles"] > 0
    # The program is loaded once for the whole frame, the rest is twice as much.
    assert body["cycles"] < stage["predicted_cycles"] < 2 * body["cycles"]
    assert body["frames_per_second"] == pytest.approx(1e9 / stage["predicted_cycles"], rel=1e-3)
    assert body["energy_pj"] == stage["energy_pj"]
    assert set(body["energy_pj"]) == {"pe_array", "sram", "control", "dram"}
    done = run(*args)
    told = ("50.0 % of the blocks", "colour network", "avoided of colour path: 75.0 %", "uJ")
    for text in (*told, "by the clock"):
        assert text in done.stdout


def drawn(scene: Scene, camera: Camera, options: ArrayOptions, *tell: object) -> ArrayFrame:
    """A frame of one job, half of it simulated."""
    tell[1]("compiling saxpy")
    device = open_device(options.fabric)
    y = np.zeros(8, np.float32)
    parts = {"x": (Move(y.copy()),), "y": (Move(y),)}
    launch = Launch({"x": (8,), "y": (8,)}, parts, scalars={"a": 1.0, "n": 8})
    device.run("colour network", "saxpy:saxpy", [launch])
    ledger = device.settle()
    ledger.count(colour_samples=1, density_samples=4)
    image = np.ones((camera.height, camera.width, 3), np.float32)
    seen = np.zeros((camera.height, camera.width), np.bool_)
    seen[:8] = True
    stages = tuple(ledger.stages.values())
    late = ("saxpy: the search was stopped by the clock",)
    return ArrayFrame(image, stages, ledger.counts, 1.0, options.sample, 1.0, seen, late)
