"""Cost tables: every figure has a source, faults are told with their lines, scaling by hand."""

from importlib import resources

import pytest

from vividc.arch.cost.node_scaling import area_factor, energy_factor
from vividc.arch.cost.tables import DEFAULT_TABLE, cost_table_names, costs_from_text, load_costs
from vividc.errors import ArchError
from vividc.machine.kinds import KINDS


@pytest.fixture
def text():
    folder = resources.files("vividc.arch") / "cost_tables"
    return (folder / f"{DEFAULT_TABLE}.yaml").read_text(encoding="utf-8")


def line_of(text, part):
    return next(n for n, line in enumerate(text.splitlines(), start=1) if part in line)


@pytest.mark.parametrize("name", cost_table_names())
def test_every_figure_has_a_source(name):
    table = load_costs(name)
    figures = [
        *table.operations_pj.values(),
        *table.moves_pj.values(),
        *table.area_um2.values(),
        *table.banks,
        table.dram_pj_per_byte,
    ]
    assert set(table.operations_pj) == set(KINDS)
    for figure in figures:
        assert len(figure.source) > 10 or figure.kind == "assumed"
        assert figure.kind in ("published", "measured", "derived", "assumed")
    assert table.calibration.source
    assert table.calibration.activity_source


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("fma.f32: {value: 4.6", "fma.f32: {value: -1.0", "greater than or equal to 0"),
        ("  imul.i32:", "  imul.i33:", "names `imul.i33`"),
        ("kind: assumed, source", "kind: guessed, source", "'guessed'"),
        (', source: "LPDDR4, 13 to 14 pJ a bit, simulated, second-hand: 13.5"', "", "is missing"),
        ("node_nm: 45", "node_nm: 28", "28"),
        ("node_nm: 45", "node: 45", "unknown key `node`"),
        ("pe_array: 0.779", "pe_array: 0.5", "do not add up to 1"),
        ("size_bytes: 8192", "size_bytes: 2048", "ascending size"),
        ("per_pe: {operations: {fma.f32", "per_pe: {operations: {fma.f99", "names `fma.f99`"),
    ],
)
def test_faults_name_their_line(text, old, new, message):
    assert old in text
    broken = text.replace(old, new, 1)
    with pytest.raises(ArchError, match=r"mine\.yaml:\d+: ") as caught:
        costs_from_text(broken, "mine.yaml")
    assert message in str(caught.value)
    assert "extends" not in str(caught.value)


def test_a_missing_operation_is_named(text):
    line = text.splitlines()[line_of(text, "select.word") - 1]
    with pytest.raises(ArchError, match=r"lacks select\.word") as caught:
        costs_from_text(text.replace(line + "\n", ""), "mine.yaml")
    assert f"mine.yaml:{line_of(text, 'operations_pj')}" in str(caught.value)


def test_not_a_table():
    with pytest.raises(ArchError, match="a cost table is a YAML mapping"):
        costs_from_text("- 1", "mine.yaml")


def test_unknown_and_unreadable_tables(tmp_path):
    with pytest.raises(ArchError, match="did you mean `vivid-45nm`"):
        load_costs("vivid-45")
    with pytest.raises(ArchError, match="cannot be read"):
        load_costs(tmp_path / "none.yaml")
    (tmp_path / "binary.yaml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ArchError, match="not a text file"):
        load_costs(tmp_path / "binary.yaml")


def test_a_file_is_read(tmp_path, text):
    (tmp_path / "mine.yaml").write_text(text.replace("name: vivid-45nm", "name: mine"))
    assert load_costs(tmp_path / "mine.yaml").name == "mine"


def test_banks_between_and_below():
    table = load_costs()
    assert table.bank(8192).read_pj == 4.66
    # Half way between 8 and 16 KB.
    assert table.bank(12288).read_pj == pytest.approx((4.66 + 8.87) / 2)
    assert table.bank(12288).kind == "derived"
    # A quarter of the smallest: its energy, a quarter of its area and leakage.
    small = table.bank(1024)
    assert (small.read_pj, small.area_mm2) == (2.54, pytest.approx(0.0132 / 4))
    with pytest.raises(ArchError, match="larger than those of the cost table"):
        table.bank(65540)


def test_node_factors():
    """7 nm: (0.1776 * 0.81 - 0.09097 * 0.9 + 0.02447) / (1.103 * 0.81 - 0.362 * 0.9 + 0.2767);
    28 nm: a third of the way from 32 to 20.
    """
    assert (area_factor(45), energy_factor(45)) == (1, 1)
    assert area_factor(7) == 0.059
    assert energy_factor(7) == pytest.approx(0.086453 / 0.84433, rel=1e-4)
    assert area_factor(28) == pytest.approx(0.46 - (0.46 - 0.21) / 3)
    assert energy_factor(28) == pytest.approx(0.4277 / 0.8443, rel=1e-3)


@pytest.mark.parametrize("node", [5, 65, float("nan")])
def test_nodes_outside_the_tables(node):
    with pytest.raises(ArchError, match="no scaling to"):
        area_factor(node)
    with pytest.raises(ArchError, match="nodes from 7 to 45"):
        energy_factor(node)
