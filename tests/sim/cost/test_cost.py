"""Energy and area: the calibration point as published, the rest by hand."""

from importlib import resources

import pytest

from vividc.arch import load, load_text
from vividc.arch.cost.node_scaling import area_factor, energy_factor
from vividc.arch.cost.tables import costs_from_text, load_costs
from vividc.errors import ArchError
from vividc.sim import Activity
from vividc.sim.cost import Work, area, calibrate, energy

TILES, PES, UNITS = 16, 256, 112
PUBLISHED_W = {"pe_array": 0.779, "sram": 0.178, "control": 0.043}
PUBLISHED_MM2 = {"pe_array": 0.745, "sram": 0.226, "control": 0.029}


@pytest.fixture
def engine():
    """Instead of the simulator's tests' fixture of this name: nothing is run here."""


@pytest.fixture(scope="module")
def table():
    return load_costs()


@pytest.fixture(scope="module")
def tile():
    return load("vivid-tile")


def test_full_use_takes_the_published_power(table, tile):
    """Figure 6: 3.94 W, of which 77.9, 17.8 and 4.3 %."""
    cycles = 1000
    words = PES * cycles
    moved = Activity(words, words, words, words, 0, UNITS * cycles, 0)
    report = energy(Work(cycles, {"fma": words}, moved, tiles=TILES), tile, table)
    assert report["power_w"] == pytest.approx(3.94, rel=1e-9)
    assert {p: e / report["chip_pj"] for p, e in report["parts_pj"].items()} == pytest.approx(
        PUBLISHED_W
    )


def test_the_published_area(table, tile):
    """Figure 6: 9.77 mm2, of which 74.5, 22.6 and 2.9 %; what 512 contexts take beyond it is a part
    of its own.
    """
    parts = area(tile, table, tiles=TILES)["parts_mm2"]
    beyond = parts.pop("configuration")
    assert sum(parts.values()) == pytest.approx(9.77, rel=1e-4)
    for part, share in PUBLISHED_MM2.items():
        assert parts[part] == pytest.approx(9.77 * share, rel=1e-4)
    # 150 bits an entry; 4 KB take 0.0132 mm2; the published area has room for 5027 bits a PE.
    assert beyond == pytest.approx(PES * (512 * 150 - 5027) * 0.0132 / 32768, rel=1e-6)


def test_an_idle_tile_takes_what_every_cycle_costs(table, tile):
    """0.779 * 3940 pJ a cycle over 16 tiles, less 16 PEs at 4.6 + 0.147 + 2 * 0.196 + 0.784."""
    rest = calibrate(table)
    assert rest.pe_array_pj.value == pytest.approx(0.779 * 3940 / 16 - 16 * 5.923)
    assert rest.sram_pj.value == pytest.approx(0.178 * 3940 / 16 - 7 * 2.54)
    assert rest.control_pj.value == pytest.approx(0.043 * 3940 / 16)
    report = energy(Work(10, {}, Activity()), tile, table)
    expected = 10 * (rest.pe_array_pj.value + rest.sram_pj.value + rest.control_pj.value)
    assert report["total_pj"] == pytest.approx(expected)
    assert all("standing" in item["name"] for item in report["items"])


def test_activity_by_hand(table, tile):
    idle = energy(Work(10, {}, Activity()), tile, table)["total_pj"]
    operations = {"fma": 2, "add": 3, "mul": 1, "load": 4, "fsub": 1}
    moved = Activity(
        link_words=5,
        register_reads=1,
        register_writes=2,
        constant_reads=1,
        constant_writes=1,
        scratchpad_reads=4,
        scratchpad_writes=1,
    )
    report = energy(Work(10, operations, moved, dram_bytes=100), tile, table)
    fus = 2 * 4.6 + 3 * 0.1 + 3.1 + 4 * 0.2 + 0.9
    moves = 5 * 0.147 + 3 * 0.196 + 2 * 0.784
    accesses = 4 * 2.54 + 3.15
    assert report["chip_pj"] - idle == pytest.approx(fus + moves + accesses)
    assert report["total_pj"] - report["chip_pj"] == pytest.approx(10800)
    assert report["operations_pj"] == pytest.approx(
        {"fadd.f32": 0.9, "fma.f32": 9.2, "imul.i32": 3.1, "int.i32": 0.3, "load.word": 0.8}
    )
    assert report["power_w"] == pytest.approx(report["chip_pj"] * 1e-12 / 10e-9)
    assert all(item["source"] for item in report["items"])


def test_a_smaller_node_scales_the_chip_and_not_the_dram(table, tile):
    work = Work(10, {"fma": 7}, Activity(link_words=3, scratchpad_reads=2), dram_bytes=10)
    here, there = energy(work, tile, table), energy(work, tile, table, node_nm=16)
    assert there["chip_pj"] == pytest.approx(energy_factor(16) * here["chip_pj"])
    assert there["parts_pj"]["dram"] == here["parts_pj"]["dram"] == 1080
    mm2 = area(tile, table)["total_mm2"]
    assert area(tile, table, node_nm=7)["total_mm2"] == pytest.approx(area_factor(7) * mm2)


def test_standing_energy_follows_the_fabric(table, tile):
    """Without multipliers and floats the array is smaller; with half the banks less leaks."""
    small = load_text(
        "extends: vivid-tile\npe: {executes: [int, compare, select]}\n"
        "absent: [imul, fadd, fmul, fma, convert, generic]\n"
        "scratchpad: {size_bytes: 16384, banks: 4}\n"
    )
    idle = Work(10, {}, Activity())
    parts, whole = energy(idle, small, table)["parts_pj"], energy(idle, tile, table)["parts_pj"]
    arrays = [area(f, table)["parts_mm2"]["pe_array"] for f in (small, tile)]
    assert parts["pe_array"] / whole["pe_array"] == pytest.approx(arrays[0] / arrays[1])
    gone = 16 * (3371 + 14251) * 1e-6
    assert arrays[1] - arrays[0] == pytest.approx(gone)
    assert parts["sram"] == pytest.approx(whole["sram"] / 2)
    assert parts["control"] == whole["control"]


def test_few_contexts_need_no_room_beyond(table):
    fabric = load_text("extends: vivid-tile\ncontroller: {contexts: 32}\n")
    assert "configuration" not in area(fabric, table)["parts_mm2"]


@pytest.mark.parametrize("name", ["mesh-1x1", "mesh-8x8", "hycube-4x4", "vivid-tile-unit"])
def test_other_fabrics_have_an_area(table, name):
    report = area(load(name), table)
    assert report["total_mm2"] == pytest.approx(sum(report["parts_mm2"].values()))
    assert all(item["total"] > 0 for item in report["items"])


def shipped_text():
    folder = resources.files("vividc.arch") / "cost_tables"
    return (folder / "vivid-45nm.yaml").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("fma.f32: {value: 4.6", "fma.f32: {value: 46.0", "energies of the pe array"),
        ("float: {value: 14251", "float: {value: 34251", "areas of a PE's logic"),
        ("fabric: vivid-tile", "fabric: vivid-tiles", "unknown fabric"),
    ],
)
def test_a_table_that_contradicts_its_calibration_is_refused(tile, old, new, message):
    broken = costs_from_text(shipped_text().replace(old, new, 1), "mine.yaml")
    with pytest.raises(ArchError, match=message) as caught:
        energy(Work(1, {}, Activity()), tile, broken)
    assert "mine.yaml:" in str(caught.value)


def test_nothing_takes_nothing(table, tile):
    report = energy(Work(0, {}, Activity()), tile, table)
    assert (report["total_pj"], report["power_w"], report["items"]) == (0, 0, [])


def test_an_issue_on_lanes_costs_by_its_format(table, tile):
    """Two FP16 lanes take less than an FP32 multiply-add, four FP8 lanes less than those."""
    counts = {"fma": 10, "fma.f16x2": 10, "fma.e4m3x4": 10, "fma.e5m2x4": 10, "dot.f16x2": 10}
    found = energy(Work(100, counts, Activity()), tile, table)["operations_pj"]
    assert found["fma.f32"] > found["fma.f16"] > found["fma.e4m3"] > found["fma.e5m2"]
    assert found["dot.f16"] == pytest.approx(10 * (2 * 1.1 + 2 * 0.9))


def test_a_float_unit_without_slices_is_smaller(table, tile):
    """14251 um2 of slices of all formats against 6854 um2 of an FP32 unit."""
    plain = load_text("extends: vivid-tile\npe: {sliced: false}\n")
    saved = area(tile, table)["total_mm2"] - area(plain, table)["total_mm2"]
    assert saved == pytest.approx(16 * (14251 - 6854) * 1e-6)
