"""`vividc simulate` with energy, traces, dumps and pictures, and `vividc area`."""

import io
import json

import numpy as np
import pytest
from click.testing import CliRunner
from rich.console import Console

import vividc
from tests.sim.view import small_kernels
from vividc.cli import main
from vividc.cli.reports.cycle_progress import cycle_progress, rate


def run(*args):
    return CliRunner().invoke(main, [*map(str, args)])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Programs and inputs; nothing writes to their files."""
    folder = tmp_path_factory.mktemp("views")
    vividc.compile(small_kernels.total, time_limit_s=30).save(folder / "total.vivid")
    vividc.compile(small_kernels.find, time_limit_s=30).save(folder / "find.vivid")
    np.savez(folder / "total.npz", x=np.arange(40, dtype=np.int32), n=40)
    np.savez(folder / "lost.npz", x=np.arange(40, dtype=np.int32), wanted=99)
    return folder


def simulate(folder, *options, name="total", inputs="total"):
    program = folder / f"{name}.vivid"
    return run("simulate", program, "--inputs", folder / f"{inputs}.npz", *options)


def test_every_file_at_once(folder, tmp_path):
    files = {
        "trace": tmp_path / "t.json",
        "vcd": tmp_path / "t.vcd",
        "plot": tmp_path / "heat.svg",
        "roofline": tmp_path / "roof.png",
    }
    options = [item for name, path in files.items() for item in (f"--{name}", path)]
    result = simulate(folder, *options, "--energy", "--json")
    assert result.exit_code == 0, result.stderr
    out = json.loads(result.stdout)
    assert out["value"] == 780
    assert out["views"] == {name: str(path) for name, path in files.items()}
    energy = out["energy"]
    assert energy["table"] == "vivid-45nm"
    assert energy["total_pj"] == pytest.approx(sum(energy["parts_pj"].values()))
    assert energy["total_pj"] == pytest.approx(sum(item["total"] for item in energy["items"]))
    assert {item["name"] for item in energy["items"]} >= {"load.word", "scratchpad_reads"}
    assert json.loads(files["trace"].read_text())["traceEvents"]
    assert files["vcd"].read_text().startswith("$comment total on vivid-tile")
    assert "<svg" in files["plot"].read_text()
    assert files["roofline"].read_bytes().startswith(b"\x89PNG")


def test_for_people(folder, tmp_path):
    result = simulate(folder, "--energy", "--node", "7", "--vcd", tmp_path / "t.vcd")
    assert result.exit_code == 0, result.stderr
    for text in ("energy by vivid-45nm, 7 nm", "average power:", "calibrated", "note: standing"):
        assert text in result.stdout
    assert f"written: {tmp_path / 't.vcd'}" in result.stdout


def test_figures_of_each_item_are_on_the_right():
    lines = run("area", "vivid-tile").stdout.splitlines()
    rows = [line.split("│") for line in lines if line.startswith("│")]
    assert len(rows) > 5
    assert all(cell == cell.rstrip() + " " for row in rows for cell in row[3:6])


def test_without_options_there_is_no_energy(folder):
    out = json.loads(simulate(folder, "--json").stdout)
    assert out["energy"] is None
    assert out["views"] == {}


def test_a_window(folder, tmp_path):
    result = simulate(folder, "--vcd", tmp_path / "t.vcd", "--window", "5:9")
    assert result.exit_code == 0, result.stderr
    times = [x for x in (tmp_path / "t.vcd").read_text().splitlines() if x.startswith("#")]
    assert (times[0], times[-1]) == ("#5", "#9")


def test_a_window_after_the_run_is_refused(folder, tmp_path):
    path = tmp_path / "p.png"
    result = simulate(folder, "--plot", path, "--window", "5000:6000")
    assert result.exit_code == 2
    assert "--window: the run ends before cycle 5,000" in result.stderr
    assert not path.exists()


def test_what_led_to_an_error_is_written(folder, tmp_path):
    options = ("--vcd", tmp_path / "t.vcd", "--plot", tmp_path / "p.png")
    result = simulate(folder, *options, name="find", inputs="lost")
    assert result.exit_code == 2
    assert "out-of-bounds" in result.stderr
    assert "$comment stopped: an out-of-bounds access" in (tmp_path / "t.vcd").read_text()
    assert (tmp_path / "p.png").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--node", "16"), "--costs and --node need --energy"),
        (("--costs", "vivid-45nm"), "--costs and --node need --energy"),
        (("--energy", "--node", "3"), "3.0 is not a node from 7 to 45 nm"),
        (("--energy", "--node", "nan"), "nan is not a node"),
        (("--energy", "--costs", "vivid"), "unknown cost table `vivid`"),
        (("--plot", "heat.gif"), "names no picture format"),
        (("--roofline", "roof"), "names no picture format"),
        (("--trace", "nowhere/t.json"), "the folder `nowhere` does not exist"),
        (("--vcd", "t.vcd", "--window", "9"), "'9' is not FIRST:END"),
        (("--vcd", "t.vcd", "--window", "9:3"), "'9:3' is not FIRST:END"),
        (("--vcd", "t.vcd", "--window", "0:200000"), "more than --vcd takes, 100,000"),
        (("--plot", "p.svg", "--window", "0:3000000"), "more than --plot takes"),
    ],
)
def test_wrong_options(folder, tmp_path, monkeypatch, options, message):
    monkeypatch.chdir(tmp_path)
    result = simulate(folder, *options)
    assert result.exit_code == 2
    assert message in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_area():
    out = json.loads(run("area", "vivid-tile", "--tiles", "16", "--json").stdout)
    assert out["schema"] == "vividc.area/1"
    assert out["parts_mm2"]["pe_array"] == pytest.approx(0.745 * 9.77)
    shown = run("area", "mesh-4x4", "--node", "28").stdout
    assert "area of mesh-4x4 by vivid-45nm, 28 nm" in shown
    assert "no room for the part `configuration`" in shown
    wrong = run("area", "vivid-tiles")
    assert wrong.exit_code == 2
    assert "unknown fabric" in wrong.stderr


def test_progress_shows_cycles_and_their_rate(monkeypatch):
    monkeypatch.setenv("TERM", "xterm")  # rich draws nothing on a dumb one
    assert rate(3_000_000, 2.0) == "1,500,000 cycles/s"
    assert rate(0, 1.0) == rate(5, 0.0) == ""
    console = Console(file=io.StringIO(), force_terminal=True, width=120)
    with cycle_progress("simulating total", console) as show:
        assert show is not None
        show(1_234_567)
    text = console.file.getvalue()
    assert "simulating total" in text
    assert "1,234,567 cycles" in text
    assert "cycles/s" in text


def test_progress_is_for_terminals():
    with cycle_progress("simulating") as show:
        assert show is None
