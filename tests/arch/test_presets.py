"""Shipped fabrics are the machines that the documents promise."""

import itertools

import pytest

from vividc.arch import Fabric, Routing, family_names, load, load_text, preset_names
from vividc.errors import ArchError
from vividc.machine.opcodes import LatencyClass

PARAMETRISED = (
    *("mesh-1x1", "mesh-3x5", "torus-2x2", "torus-4x4", "mesh-8x8", "king-3x3"),
    *("openedge-4x4", "openedge-1x1", "hycube-4x4", "hycube-1x3", "adres-8x8", "adres-2x2"),
)


def memory_pes(fabric: Fabric) -> set[tuple[int, int]]:
    return {(pe.row, pe.col) for pe in fabric.pes if pe.has_memory}


def test_vivid_tile_has_the_stated_parameters():
    fabric = load("vivid-tile")
    assert (fabric.name, fabric.rows, fabric.cols, fabric.clock_ghz) == ("vivid-tile", 4, 4, 1.0)
    one = ("int", "compare", "select", "store", "generic")
    four = ("fadd", "fmul", "fma", "dot")
    expected = dict.fromkeys(one, 1) | dict.fromkeys(four, 4) | {"imul": 2, "convert": 2, "load": 2}
    expected |= {"source": 0, "sink": 0}
    assert {lat.value: cycles for lat, cycles in fabric.latencies.items()} == expected
    for pe in fabric.pes:
        assert (pe.registers, pe.read_ports, pe.write_ports, pe.constants) == (8, 2, 2, 32)
    assert (fabric.scratchpad.size_bytes, fabric.scratchpad.banks) == (32768, 8)
    controller = fabric.controller
    assert (controller.contexts, controller.control_latency) == (512, 1)
    assert (controller.switch_cycles, controller.max_stages) == (1, 64)


def test_vivid_tile_is_a_mesh_of_single_links():
    fabric = load("vivid-tile")
    assert len(fabric.links) == 48
    pairs = {(link.src, link.dst) for link in fabric.links}
    assert len(pairs) == 48
    for src, dst in pairs:
        a, b = fabric.pes[src], fabric.pes[dst]
        assert abs(a.row - b.row) + abs(a.col - b.col) == 1
    assert [link.id for link in fabric.links] == list(range(48))
    assert [pe.id for pe in fabric.pes] == [pe.row * 4 + pe.col for pe in fabric.pes]


@pytest.mark.parametrize(
    ("name", "row", "col"),
    [
        ("vivid-tile", 0, 0),
        ("vivid-tile-nw", 0, 0),
        ("vivid-tile-ne", 0, 3),
        ("vivid-tile-sw", 3, 0),
        ("vivid-tile-se", 3, 3),
    ],
)
def test_load_store_units_lie_on_the_two_outer_edges(name, row, col):
    positions = itertools.product(range(4), range(4))
    edges = {(r, c) for r, c in positions if r == row or c == col}
    assert memory_pes(load(name)) == edges
    assert len(edges) == 7


def test_unit_tile_differs_only_in_latencies():
    unit, tile = load("vivid-tile-unit"), load("vivid-tile")
    sources = (LatencyClass.SOURCE, LatencyClass.SINK)
    assert {cycles for lat, cycles in unit.latencies.items() if lat not in sources} == {1}
    assert [unit.latencies[lat] for lat in sources] == [0, 0]
    assert (unit.pes, unit.links, unit.controller) == (tile.pes, tile.links, tile.controller)
    assert unit.scratchpad == tile.scratchpad


def test_uniform_arrays_execute_everything_everywhere():
    fabric = load("mesh-3x5")
    assert (fabric.rows, fabric.cols, len(fabric.pes)) == (3, 5, 15)
    everything = set(LatencyClass) - {LatencyClass.SOURCE, LatencyClass.SINK}
    assert all(pe.classes == everything for pe in fabric.pes)
    assert fabric.scratchpad.banks >= 15


@pytest.mark.parametrize(
    ("name", "links"),
    [("mesh-1x1", 0), ("mesh-1x4", 6), ("mesh-4x4", 48), ("torus-4x4", 64), ("torus-2x2", 8),
     ("torus-1x3", 6), ("torus-1x1", 0), ("torus-2x3", 18), ("torus-32x32", 4096)],
)  # fmt: skip
def test_number_of_links(name, links):
    assert len(load(name).links) == links


def test_every_fabric_is_connected_both_ways():
    for name in (*preset_names(), *PARAMETRISED):
        pairs = {(link.src, link.dst) for link in load(name).links}
        assert pairs == {(dst, src) for src, dst in pairs}


@pytest.mark.parametrize("name", [*preset_names(), *PARAMETRISED])
def test_source_rebuilds_the_same_fabric(name):
    fabric = load(name)
    assert fabric.name == name
    assert load_text(fabric.source, "elsewhere.yaml") == fabric


def test_openedge_is_the_array_of_sat_mapit():
    fabric = load("openedge-4x4")
    assert len(fabric.links) == 64
    assert fabric.routing == Routing(hops=0, holds=True, shared=True, moves=True)
    assert memory_pes(fabric) == set(itertools.product(range(4), range(4)))
    assert all(pe.registers == 10 and pe.written_by_fu and not pe.rotating for pe in fabric.pes)
    assert sorted(fabric.outputs_seen_by[0]) == [0, 1, 3, 4, 12]


def test_hycube_passes_several_links_and_has_memory_in_the_first_column():
    fabric = load("hycube-4x4")
    assert len(fabric.links) == 48
    assert fabric.routing == Routing(hops=4)
    assert memory_pes(fabric) == {(row, 0) for row in range(4)}
    assert fabric.outputs_seen_by[5] == (5,)


def test_adres_has_rotating_files_and_memory_in_the_first_row():
    fabric = load("adres-4x4")
    assert all(pe.rotating for pe in fabric.pes)
    assert memory_pes(fabric) == {(0, col) for col in range(4)}
    assert len(fabric.links) == 48 + 2 * 16
    assert fabric.routing == Routing()


@pytest.mark.parametrize("name", ["vivid-tile", "mesh-4x4", "torus-3x3", "king-4x4"])
def test_arrays_that_programs_are_made_for_are_plain(name):
    assert load(name).is_plain


@pytest.mark.parametrize("name", ["openedge-4x4", "hycube-4x4", "adres-4x4"])
def test_published_arrays_are_not(name):
    assert not load(name).is_plain


def test_preset_names_hide_what_is_not_public():
    assert "vivid-tile" in preset_names()
    assert not [name for name in preset_names() if name.startswith("_")]
    assert list(preset_names()) == sorted(preset_names())


def test_latencies_are_read_only():
    with pytest.raises(TypeError):
        load("vivid-tile").latencies[LatencyClass.INT] = 2


@pytest.mark.parametrize("name", ["mesh-0x4", "mesh-33x1", "torus-4x100"])
def test_sizes_out_of_range_are_refused(name):
    with pytest.raises(ArchError, match="1x1 to 32x32"):
        load(name)


def test_unknown_name_lists_the_known_ones():
    with pytest.raises(ArchError) as caught:
        load("vivid-tiel")
    assert "unknown fabric `vivid-tiel`" in str(caught.value)
    assert "did you mean `vivid-tile`?" in str(caught.value)
    for name in (*preset_names(), *family_names()):
        assert name in str(caught.value)
