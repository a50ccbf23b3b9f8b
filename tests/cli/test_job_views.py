"""`vividc simulate --fabric` with energy, a trace and a roofline; the area of an accelerator."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from vividc.arch.cost.tables import load_costs
from vividc.cli import main
from vividc.sim.cost import calibrate

KERNEL = """
import numpy as np
import vividc
from numba import prange

@vividc.kernel("void(int32[::1], int32[::1])")
def scale(x, y):
    for i in prange(x.shape[0]):
        y[i] = 3 * x[i]
"""
N = 9000


def run(*args):
    return CliRunner().invoke(main, [*map(str, args)])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("job")
    (folder / "k.py").write_text(KERNEL)
    options = ("--fabric", "vivid", "--no-transform", "-o", folder / "p.vivid")
    done = run("compile", folder / "k.py", *options)
    assert done.exit_code == 0, done.output
    np.savez(folder / "in.npz", x=np.arange(N, dtype=np.int32), y=np.zeros(N, np.int32))
    return folder


def simulate(folder, *options):
    arguments = ("--inputs", folder / "in.npz", "--fabric", "vivid")
    return run("simulate", folder / "p.vivid", *arguments, *options)


def test_energy_trace_and_roofline(folder, tmp_path):
    trace, roof = tmp_path / "t.json", tmp_path / "r.svg"
    options = ("--energy", "--trace", trace, "--roofline", roof, "--json")
    result = simulate(folder, *options)
    assert result.exit_code == 0, result.stderr
    out = json.loads(result.stdout)
    assert out["fabric"] == "vivid"
    moved, cycles = out["stats"]["bytes"], out["cycles"]
    items = {(item["part"], item["name"]): item for item in out["energy"]["items"]}
    rest = calibrate(load_costs())
    control = items["control", "standing, tile-cycles"]
    assert control["count"] == 16 * cycles
    assert control["total"] == pytest.approx(16 * cycles * rest.control_pj.value)
    dram = moved["dram_read"] + moved["dram_written"]
    assert dram >= 2 * 4 * N
    assert items["dram", "bytes"]["total"] == pytest.approx(108 * dram)
    # A load and a store an element, and as many words that DMA brings and takes.
    assert items["sram", "scratchpad_reads"]["count"] >= 2 * N
    assert items["sram", "scratchpad_writes"]["count"] >= 2 * N
    events = json.loads(trace.read_text())["traceEvents"]
    rows = {e["args"]["name"] for e in events if e["ph"] == "M" and e["name"] == "thread_name"}
    assert {f"tile {tile}" for tile in range(16)} <= rows
    assert {"dma 0", "configuration 0"} <= rows
    assert max(e["args"]["end_cycle"] for e in events if e["ph"] == "X") == cycles
    assert "DRAM: 32 bytes a cycle" in roof.read_text()


def test_for_people(folder):
    result = simulate(folder, "--energy")
    assert result.exit_code == 0, result.stderr
    assert "average power:" in result.stdout
    assert "dram" in result.stdout


@pytest.mark.parametrize("option", ["--vcd", "--plot"])
def test_one_tiles_views_are_refused(folder, tmp_path, option):
    result = simulate(folder, option, tmp_path / "t.svg")
    assert result.exit_code == 2
    assert "one tile, not --fabric's" in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_area_of_an_accelerator():
    whole = json.loads(run("area", "vivid", "--json").stdout)
    tiles = json.loads(run("area", "vivid-tile", "--tiles", "16", "--json").stdout)
    assert whole["tiles"] == 16
    assert whole["parts_mm2"] == pytest.approx(tiles["parts_mm2"])
    assert sum(whole["parts_mm2"].values()) - whole["parts_mm2"]["configuration"] == pytest.approx(
        9.77, rel=1e-4
    )
