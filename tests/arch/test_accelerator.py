"""Accelerators: presets, YAML in layers, faults with their lines, mirrored tiles."""

from __future__ import annotations

from pathlib import Path

import pytest

from vividc import arch
from vividc.errors import ArchError


def test_preset_has_sixteen_tiles_by_place_in_their_cluster() -> None:
    machine = arch.load_accelerator("vivid")
    assert (machine.rows, machine.cols, len(machine.tiles)) == (4, 4, 16)
    corners = [machine.orientation(tile) for tile in range(8)]
    assert corners == ["nw", "ne", "nw", "ne", "sw", "se", "sw", "se"]
    for tile, corner in enumerate(corners):
        assert machine.tiles[tile].pes == arch.load_tile(f"vivid-tile-{corner}").pes


def test_load_gives_a_tile_or_an_accelerator() -> None:
    assert isinstance(arch.load("vivid"), arch.Accelerator)
    assert isinstance(arch.load("vivid-tile"), arch.Fabric)
    assert arch.load_accelerator("vivid-unit").fabric.name == "vivid-tile-unit"


def test_a_file_extends_a_preset_and_round_trips(tmp_path: Path) -> None:
    file = tmp_path / "wide.yaml"
    file.write_text("extends: vivid\ndram: {bytes_per_cycle: 64}\n")
    machine = arch.load(file)
    assert isinstance(machine, arch.Accelerator)
    assert (machine.name, machine.dram.bytes_per_cycle, machine.dram.latency) == ("wide", 64, 100)
    assert arch.load_accelerator_text(machine.source) == machine
    wider = tmp_path / "wider.yaml"
    wider.write_text("extends: wide.yaml\ntiles: {rows: 1, cols: 1}\n")
    smaller = arch.load_accelerator(wider)
    assert (len(smaller.tiles), smaller.dram.bytes_per_cycle) == (1, 64)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("extends: vivid\ndram: {bytes_per_cycle: 0}\n", "a.yaml:2"),
        ("extends: vivid\ndram: {granule_bytes: 48}\n", "not a power of two"),
        ("extends: vivid\ndma:\n  burst_bytes: 100\n", "a.yaml:3: a burst of 100"),
        ("extends: vivid\nnoise: 1\n", "a.yaml:2"),
        ("tiles: {rows: 1, cols: 1, fabric: vivid-tile}\n", "dram"),
        ("extends: vivid\ntiles: {fabric: nothing}\n", "unknown fabric"),
        ("extends: vivid-tile\ntiles: {rows: 1}\n", "not an accelerator"),
    ],
)
def test_faults_name_their_line(text: str, says: str) -> None:
    with pytest.raises(ArchError) as error:
        arch.load_accelerator_text(text, "a.yaml")
    assert says in str(error.value)


def test_a_circle_of_files_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text("extends: b.yaml\ntiles: {rows: 1}\n")
    (tmp_path / "b.yaml").write_text("extends: a.yaml\n")
    with pytest.raises(ArchError, match="circle"):
        arch.load(tmp_path / "a.yaml")


def test_a_tile_is_no_accelerator() -> None:
    with pytest.raises(ArchError, match="single tile"):
        arch.load_accelerator("vivid-tile")


@pytest.mark.parametrize("corner", ["nw", "ne", "sw", "se"])
@pytest.mark.parametrize("name", ["vivid-tile", "torus-4x4", "mesh-2x3"])
def test_a_mirrored_tile_is_isomorphic(name: str, corner: arch.Orientation) -> None:
    fabric = arch.load_tile(name)
    places = arch.reflection(fabric, corner)
    assert arch.is_isomorphism(fabric, arch.reflected(fabric, corner), places)


def test_an_isomorphism_keeps_parts_and_links() -> None:
    fabric = arch.load_tile("vivid-tile")
    east = arch.load_tile("vivid-tile-ne")
    assert not arch.is_isomorphism(fabric, east, tuple(range(16)))
    swapped = (1, 0, *range(2, 16))
    assert not arch.is_isomorphism(fabric, fabric, swapped)
    assert not arch.is_isomorphism(fabric, arch.load_tile("vivid-tile-unit"), tuple(range(16)))


def test_extra_links_and_overrides_are_mirrored() -> None:
    fabric = arch.load_text(
        "extends: mesh-3x3\nname: odd\n"
        "links: {extra: [{from: [0, 0], to: [2, 1]}], removed: [{from: [0, 0], to: [0, 1]}]}\n"
        "overrides: [{at: {rows: 0..1, cols: 0}, constants: 5}]\n"
    )
    mirror = arch.reflected(fabric, "se")
    assert {(2, 2)} == {(p.row, p.col) for p in mirror.pes if p.constants == 5} - {(1, 2)}
    pairs = {(link.src, link.dst) for link in mirror.links}
    assert (8, 1) in pairs
    assert (8, 7) not in pairs
