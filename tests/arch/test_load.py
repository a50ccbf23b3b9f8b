"""YAML becomes a fabric, or one message with every mistake and its line."""

import contextlib
import re
from pathlib import Path
from typing import get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vividc.arch import accelerator_names, load, load_text, preset_names
from vividc.arch.yaml import schema
from vividc.arch.yaml.load_machine import ShippedAccelerator, ShippedTile
from vividc.dfg.ir import Node
from vividc.errors import ArchError
from vividc.machine.opcodes import LatencyClass, Opcode

DOCS = Path(__file__).parents[2] / "docs" / "fabric-yaml.md"


def message(text: str) -> str:
    with pytest.raises(ArchError) as caught:
        load_text(text, "f.yaml")
    return str(caught.value)


def yaml_examples() -> list[str]:
    return re.findall(r"```yaml\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)


@pytest.mark.parametrize("text", yaml_examples())
def test_examples_of_the_documentation_load(text):
    fabric = load_text(text, "example.yaml")
    assert load_text(fabric.source) == fabric


def test_documentation_names_every_key():
    text = DOCS.read_text(encoding="utf-8")
    models = [item for item in vars(schema).values() if isinstance(item, type)]
    models = [item for item in models if issubclass(item, schema.BaseModel)]
    keys = {field.alias or name for item in models for name, field in item.model_fields.items()}
    assert [key for key in sorted(keys) if not re.search(rf"\b{key}\b", text)] == []


def test_example_sets_what_it_says():
    fabric = load_text(yaml_examples()[1])
    by_position = {(pe.row, pe.col): pe for pe in fabric.pes}
    pairs = {(link.src, link.dst) for link in fabric.links}
    assert (0, 15) in pairs
    assert (15, 0) in pairs
    assert (5, 6) not in pairs
    assert (6, 5) in pairs
    assert by_position[0, 2].has_memory
    assert by_position[3, 0].has_memory
    assert by_position[3, 0].constants == 64
    assert not by_position[3, 3].has_memory
    assert LatencyClass.FMA not in by_position[1, 1].classes
    assert LatencyClass.FMA in by_position[3, 3].classes
    assert (by_position[1, 1].registers, by_position[1, 1].read_ports) == (16, 2)
    assert not any(LatencyClass.CONVERT in pe.classes for pe in fabric.pes)
    assert fabric.latencies[LatencyClass.FADD] == 4
    assert fabric.latencies[LatencyClass.LOAD] == 2
    assert fabric.latencies[LatencyClass.IMUL] == 1


def test_text_that_yaml_would_take_for_a_date_is_a_name():
    fabric = load_text("extends: vivid-tile\nname: 2001-13-45")
    assert fabric.name == "2001-13-45"
    assert load_text(fabric.source) == fabric


def test_floating_point_variant_takes_two_lines():
    fabric = load_text("extends: vivid-tile\nlatencies: {float: 1}\n", "fast-fp.yaml")
    tile = load("vivid-tile")
    changed = {lat for lat, cycles in fabric.latencies.items() if cycles != tile.latencies[lat]}
    assert changed == {
        *(LatencyClass.FADD, LatencyClass.FMUL, LatencyClass.FMA, LatencyClass.DOT),
    }
    assert fabric.name == "fast-fp"
    assert (fabric.pes, fabric.links) == (tile.pes, tile.links)


def test_narrower_latency_wins_whatever_the_order():
    fabric = load_text("extends: vivid-tile\nlatencies: {fma: 5, float: 3, all: 2}")
    assert fabric.latencies[LatencyClass.FMA] == 5
    assert fabric.latencies[LatencyClass.FADD] == 3
    assert fabric.latencies[LatencyClass.INT] == 2


def test_overrides_and_links_add_to_those_of_the_base():
    text = """
extends: vivid-tile
overrides:
  - at: {rows: 3, cols: 3}
    memory: true
links:
  extra: [{from: [0, 0], to: [2, 2]}]
"""
    fabric = load_text(text)
    assert sum(pe.has_memory for pe in fabric.pes) == 8
    assert len(fabric.links) == 49
    assert (fabric.links[-1].src, fabric.links[-1].dst) == (0, 10)


def test_other_sizes_keep_the_overrides_of_the_base():
    fabric = load_text("extends: vivid-tile\nrows: 2\ncols: 6")
    assert (len(fabric.pes), sum(pe.has_memory for pe in fabric.pes)) == (12, 7)


def test_king_topology_has_eight_neighbours():
    fabric = load_text("extends: mesh-3x3\ntopology: king")
    assert len(fabric.links_from[4]) == 8
    assert len(fabric.links_from[0]) == 3


def test_no_topology_has_the_extra_links_only():
    text = "extends: mesh-2x2\ntopology: none\nlinks: {extra: [{from: [0, 0], to: [1, 1]}]}"
    assert [(link.src, link.dst) for link in load_text(text).links] == [(0, 3)]


def test_extends_a_file_beside_it(tmp_path):
    (tmp_path / "base.yaml").write_text("extends: mesh-2x3\nlatencies: {load: 3}")
    (tmp_path / "child.yaml").write_text("extends: base.yaml\nclock_ghz: 2")
    fabric = load(tmp_path / "child.yaml")
    assert (fabric.name, fabric.latencies[LatencyClass.LOAD], fabric.clock_ghz) == ("child", 3, 2.0)
    assert load_text(fabric.source, "moved.yaml") == fabric


def test_extends_in_a_circle_is_refused(tmp_path):
    (tmp_path / "a.yaml").write_text("extends: b.yaml")
    (tmp_path / "b.yaml").write_text("extends: a.yaml")
    with pytest.raises(ArchError, match=r"circle: a.yaml -> b.yaml -> a.yaml"):
        load(str(tmp_path / "a.yaml"))


def test_a_base_that_cannot_be_read_is_told_with_the_line_that_names_it(tmp_path):
    (tmp_path / "child.yaml").write_text("rows: 2\nextends: nope.yaml")
    with pytest.raises(ArchError, match=r"child\.yaml:2: `.*nope\.yaml`: cannot be read: No such"):
        load(tmp_path / "child.yaml")
    (tmp_path / "chip.yaml").write_text("extends: vivid\ntiles:\n  fabric: nope.yaml")
    with pytest.raises(ArchError, match=r"chip\.yaml:3: `.*nope\.yaml`: cannot be read: No such"):
        load(tmp_path / "chip.yaml")


def test_a_folder_or_a_file_without_ending_is_told(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine").mkdir()
    (tmp_path / "plain").write_text("extends: mesh-2x2")
    for name in ("mine", "./mine", tmp_path / "mine"):
        with pytest.raises(ArchError, match=r"a folder is not a fabric\nhint: name a YAML file"):
            load(name)
    with pytest.raises(ArchError, match=r"unknown fabric `plain`\nhint: .* write \./plain"):
        load("plain")
    assert load("./plain").rows == 2


def test_mistake_in_the_base_names_the_base(tmp_path):
    (tmp_path / "base.yaml").write_text("extends: mesh-2x3\nrows: none")
    (tmp_path / "child.yaml").write_text("extends: base.yaml")
    with pytest.raises(ArchError, match=r"base\.yaml:2: `rows`"):
        load(tmp_path / "child.yaml")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "f.yaml:1: a fabric is a YAML mapping"),
        ("- 1", "f.yaml:1: a fabric is a YAML mapping"),
        ("rows: [1", "f.yaml:1: not YAML"),
        ("rows: 1\n\tcols: 2", "f.yaml:2: not YAML"),
        ("rows: 1\ncols: \x07", "f.yaml:2: not YAML"),
        ("extends: vivid-tile\nrows: 2\nrows: 3", "f.yaml:3: the key `rows` is given twice"),
        ("extends: &a vivid-tile\nname: *a", "f.yaml:1: YAML aliases are refused"),
        ("extends: vivid-tile\n? [a]\n: 1", "f.yaml:2: a key must be text"),
        ("extends: nowhere", "f.yaml:1: unknown fabric `nowhere`"),
        ("extends: vivid-tile\nrow: 4", "f.yaml:2: unknown key `row`\nhint: did you mean `rows`?"),
        ("extends: vivid-tile\nrows: 0", "f.yaml:2: `rows` should be greater than or equal to 1"),
        ("extends: vivid-tile\nrows: '4'", "f.yaml:2: `rows` should be a valid integer, got '4'"),
        ("extends: vivid-tile\nrows: true", "f.yaml:2: `rows` should be a valid integer"),
        ("extends: vivid-tile\nlatencies:\n  fma: -1", "f.yaml:3: `latencies.fma` should be"),
        ("extends: vivid-tile\nlatencies:\n  fmaa: 1", "did you mean `fma`?"),
        ("extends: vivid-tile\nclock_ghz: .nan", "f.yaml:2: `clock_ghz`"),
        ("extends: vivid-tile\npe: {executes: [fma, fmo]}", "f.yaml:2: `pe.executes` should be"),
        ("extends: vivid-tile\nname: a b", "f.yaml:2: `name` should be up to 64 letters, digits"),
        ("extends: vivid-tile\nlatencies: 3", "f.yaml:2: `latencies` should be a mapping, got 3"),
        ("extends: vivid-tile\nrows: 0b_", "f.yaml:2: `0b_` is not a value"),
        (
            "extends: vivid-tile\noverrides:\n  - memory: true",
            "f.yaml:3: `overrides.0.at` is missing",
        ),
        (
            "extends: vivid-tile\noverrides:\n  - at: {rows: 1-2}",
            "f.yaml:3: `overrides.0.at.rows` should be `all`, an index",
        ),
        ("extends: vivid-tile\noverrides:\n- at: {cols: 0..4}", "f.yaml:3: `cols` names 4, but"),
        ("extends: vivid-tile\noverrides:\n- at: {cols: 3..2}", "f.yaml:3: `cols` names nothing"),
        (
            "extends: vivid-tile\nlinks:\n  extra:\n  - {from: [0, 0], to: [4, 0]}",
            "f.yaml:4: unknown PE [4, 0] in a link: the array has 4x4 PEs",
        ),
        (
            "extends: vivid-tile\nlinks:\n  extra:\n  - {from: [0, -1], to: [1, 0]}",
            "f.yaml:4: unknown PE [0, -1] in a link",
        ),
        (
            "extends: vivid-tile\nlinks: {extra: [{from: [0, 0], to: [0, 0]}]}",
            "f.yaml:2: the link [0, 0] -> [0, 0] joins a PE to itself",
        ),
        (
            "extends: vivid-tile\nlinks: {extra: [{from: [0, 0], to: [0, 1]}]}",
            "f.yaml:2: the link [0, 0] -> [0, 1] exists already",
        ),
        (
            "extends: vivid-tile\nlinks: {removed: [{from: [0, 0], to: [1, 1]}]}",
            "f.yaml:2: there is no link [0, 0] -> [1, 1] to remove",
        ),
        (
            "extends: vivid-tile\npe:\n  register_file: {registers: 0}",
            "f.yaml:3: PE [0, 0] has 0 registers with 2 read and 2 write ports",
        ),
        (
            "extends: vivid-tile\noverrides:\n- at: {rows: 2}\n  register_file: {write_ports: 0}",
            "f.yaml:4: PE [2, 0] has 8 registers with 2 read and 0 write ports",
        ),
        (
            "extends: vivid-tile\npe:\n  executes: [int, imul, compare, select, generic]",
            "f.yaml:3: no PE executes fadd, fmul, fma, convert",
        ),
        (
            "extends: mesh-2x2\npe: {memory: false}",
            "f.yaml:2: no PE has a load/store unit\nhint: give some PEs `memory: true`",
        ),
        ("extends: vivid-tile\nscratchpad: {size_bytes: 100}", "100 bytes are not a multiple of 8"),
        ("extends: vivid-tile\nscratchpad: {banks: 6}", "f.yaml:2: 6 banks: not a power of two"),
        ("rows: 2\ncols: 2", "f.yaml:1: `topology` is missing"),
    ],
)
def test_mistakes_name_their_line(text, expected):
    assert expected in message(text)


def test_all_mistakes_are_listed_in_the_order_of_their_lines():
    text = "extends: vivid-tile\nlatencies: {fma: 0, load: x}\nrows: 99\ncolour: red\n"
    lines = [line for line in message(text).splitlines() if line.startswith("f.yaml")]
    assert [line.split(":")[1] for line in lines] == ["2", "2", "3", "4"]


def test_a_class_may_be_absent_on_purpose():
    fabric = load_text("extends: vivid-tile\nabsent: [fma, memory]")
    assert not any(LatencyClass.FMA in pe.classes or pe.has_memory for pe in fabric.pes)


def test_missing_file_and_folder_and_binary_file(tmp_path):
    binary = tmp_path / "binary.yaml"
    binary.write_bytes(b"\xff\xfe\x00")
    for path in (tmp_path / "missing.yaml", tmp_path, binary):
        with pytest.raises(ArchError) as caught:
            load(path)
        assert str(caught.value).startswith(str(path))


def test_deep_nesting_is_an_error_and_not_a_crash():
    assert "nested too deeply" in message("rows: " + "[" * 100_000)


@given(st.text(max_size=60))
def test_any_text_is_a_fabric_or_an_arch_error(text):
    with contextlib.suppress(ArchError):
        assert load_text("extends: vivid-tile\n" + text).pes


LINE = st.sampled_from(
    [
        "rows: 3",
        "cols: 0",
        "name: x",
        "topology: king",
        "latencies: {all: 2}",
        "latencies: [",
        "pe:",
        "pe: {memory: true}",
        "overrides:",
        "- at: {rows: 0}",
        "  constants: 4",
        "absent: [fma]",
        "- 1",
    ]
)


@given(st.lists(LINE, max_size=6))
def test_any_lines_are_a_fabric_or_an_arch_error(lines):
    try:
        fabric = load_text("\n".join(["extends: vivid-tile", *lines]))
    except ArchError:
        return
    assert load_text(fabric.source) == fabric


def test_slices_of_float_units_by_pe():
    assert all(pe.sliced for pe in load("vivid-tile").pes)
    assert not any(pe.sliced for pe in load("hycube-4x4").pes)
    text = "extends: vivid-tile\npe: {sliced: false}\noverrides: [{at: {rows: 1}, sliced: true}]\n"
    fabric = load_text(text, "some.yaml")
    assert [pe.sliced for pe in fabric.pes] == [pe.row == 1 for pe in fabric.pes]
    fma, plain = Node(0, Opcode.FMA_E4M3X4), Node(1, Opcode.FMA)
    assert [fabric.supports(pe.id, fma) for pe in fabric.pes] == [pe.sliced for pe in fabric.pes]
    assert all(fabric.supports(pe.id, plain) for pe in fabric.pes)
    assert [pe.executes(fma.info) for pe in fabric.pes] == [pe.sliced for pe in fabric.pes]
    assert all(fabric.supports(pe.id, Node(2, Opcode.SELECT_X4)) for pe in fabric.pes)


def test_dot_follows_fma_unless_a_layer_says():
    assert load_text("extends: vivid-tile\nlatencies: {fma: 7}").latencies[LatencyClass.DOT] == 7
    fabric = load_text("extends: vivid-tile\nlatencies: {dot: 9}")
    assert fabric.latencies[LatencyClass.DOT] == 9
    assert fabric.latencies[LatencyClass.FMA] == 4
    some = load_text("extends: mesh-1x2\noverrides: [{at: {cols: 0}, executes: [int, fadd]}]")
    assert [LatencyClass.DOT in pe.classes for pe in some.pes] == [False, True]
    none = load_text("extends: mesh-1x2\nabsent: [fma]")
    assert not any(LatencyClass.DOT in pe.classes for pe in none.pes)


def test_a_fabric_for_mapping_says_its_size_and_its_links():
    """What it leaves out is as in `mesh-RxC`; `dot` is as `fma`, as ever."""
    fabric, mesh = load_text("rows: 3\ncols: 3\ntopology: mesh\n"), load("mesh-3x3")
    for part in ("pes", "links", "latencies", "scratchpad", "controller", "routing"):
        assert getattr(fabric, part) == getattr(mesh, part)
    text = "rows: 2\ncols: 2\ntopology: torus\npe: {constants: 4}\nlatencies: {fma: 3, load: 2}\n"
    fabric = load_text(text)
    assert {pe.constants for pe in fabric.pes} == {4}
    assert {pe.registers for pe in fabric.pes} == {8}
    cycles = {lat.value: fabric.latencies[lat] for lat in fabric.latencies}
    assert (cycles["fma"], cycles["dot"], cycles["load"], cycles["fadd"]) == (3, 3, 2, 1)
    assert load_text(fabric.source, fabric.name) == fabric


def test_a_type_checker_knows_the_shipped_names():
    assert get_args(ShippedTile) == preset_names()
    assert get_args(ShippedAccelerator) == accelerator_names()
