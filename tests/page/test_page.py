"""The page of `vividc view` as data: what it shows is the program's, and nothing in it can act."""

import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest

import vividc
from kernels.dot import dot as dot_kernel
from tests.sim.view import small_kernels
from vividc.arch import load_tile, preset_names
from vividc.page.regions import fabric_data
from vividc.page.write import as_script, page, page_data

HOSTILE = "</script><script>alert(1)</script><!--\u2028&"


class Page(HTMLParser):
    """Elements of a page, and the text of its scripts."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.scripts, self.open = [], [], None
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        self.open = tag
        if tag == "script":
            self.scripts.append("")

    def handle_endtag(self, tag):
        self.open = None

    def handle_data(self, data):
        if self.open == "script":
            self.scripts[-1] += data

    @property
    def ids(self):
        return {attrs["id"] for _, attrs in self.elements if "id" in attrs}

    @property
    def data(self):
        return json.loads(self.scripts[0])


@pytest.fixture(scope="module")
def strided():
    return vividc.compile(small_kernels.strided, time_limit_s=30)


@pytest.fixture(scope="module")
def dot():
    """II 4: a sum of floats is a recurrence."""
    return vividc.compile(dot_kernel, time_limit_s=30)


def arguments():
    return (np.arange(640, dtype=np.int32), np.zeros(80, np.int32), 8, 0, 40)


@pytest.fixture(scope="module")
def with_run(strided):
    return Page(page(strided, arguments()))


def test_all_operations_are_where_the_mapping_has_them(strided, with_run):
    assert len(with_run.data["regions"]) == len(strided.regions)
    for region, shown in zip(strided.regions, with_run.data["regions"], strict=True):
        assert {node["id"] for node in shown["nodes"]} == {node.id for node in region.dfg.nodes}
        assert [(edge["src"], edge["dst"], edge["distance"]) for edge in shown["edges"]] == [
            (edge.src, edge.dst, edge.distance) for edge in region.dfg.edges
        ]
        places = region.mapping.places if region.mapping is not None else {}
        placed = {n["id"]: (n["pe"], n["time"]) for n in shown["nodes"] if n["pe"] is not None}
        assert placed == {node: (place.pe, place.time) for node, place in places.items()}
        issued = [
            (node, pe, slot + stage * region.ii)
            for slot, context in enumerate(shown["slots"])
            for pe, node, stage in context["issues"]
        ]
        assert sorted(issued) == [(node, *placed[node]) for node in sorted(places)]


def test_links_carry_what_the_routes_say(strided, with_run):
    for region, shown in zip(strided.regions, with_run.data["regions"], strict=True):
        if region.mapping is None:
            continue
        routed = {
            (step.index, (step.time - 1) % region.ii, region.dfg.edges[edge].src)
            for edge, steps in region.mapping.routes.items()
            for step in steps
            if step.kind == "link"
        }
        assert routed == {
            (link, slot, node)
            for slot, context in enumerate(shown["slots"])
            for link, node in context["links"]
        }


def test_the_bound_that_binds_names_its_operations_and_no_paths(dot):
    data = page_data(dot, None)
    number = next(i for i, region in enumerate(dot.regions) if region.kind == "loop")
    shown, result = data["regions"][number], dot.regions[number].result
    assert [bound["name"] for bound in shown["bounds"]] == [b.name for b in result.bounds]
    binding = shown["bounds"][shown["binds"]]
    assert binding["ii"] == shown["lower_bound"] > 1
    assert set(binding["nodes"]) >= set(result.bounds[shown["binds"]].nodes)
    assert "(line 12)" in binding["reason"]
    assert "dot.py" not in json.dumps(data["regions"][number]["bounds"])


def test_a_recurrence_brings_its_edges(dot):
    shown = page_data(dot, None)
    assert shown["run"] is None
    recurrences = [
        (region, bound)
        for region in shown["regions"]
        for bound in region["bounds"]
        if bound["name"] == "RecMII"
    ]
    assert recurrences
    for region, bound in recurrences:
        edges = [region["edges"][edge] for edge in bound["edges"]]
        assert sum(edge["distance"] for edge in edges) >= 1
        assert {edge["src"] for edge in edges} | {edge["dst"] for edge in edges} == set(
            bound["nodes"]
        )


def test_the_source_is_shown_if_it_is_the_one_that_was_compiled(strided, with_run, tmp_path):
    lines = with_run.data["source"]["lines"]
    assert lines[15:17] == ["    for i in range(n):", "        y[i] = x[a * i] + x[b * i]"]
    assert with_run.data["source"]["file"] == "small_kernels.py"
    hot = {one["line"]: one["heat"] for one in with_run.data["lines"]}
    assert max(hot, key=hot.get) == 17
    other = tmp_path / "other.py"
    other.write_text("its own text\n")
    assert page_data(strided, None, source=other)["source"]["lines"] == ["its own text", ""]


def test_a_source_that_was_changed_is_not_shown(tmp_path, monkeypatch):
    file = tmp_path / "changed.py"
    text = "import vividc\n\n\n@vividc.kernel('void(int32[::1])')\ndef zero(x):\n    x[0] = 0\n"
    file.write_text(text)
    monkeypatch.syspath_prepend(str(tmp_path))
    program = vividc.compile(__import__("changed").zero)
    assert page_data(program, None)["source"]["lines"] == text.split("\n")
    file.write_text(text + "# secret\n")
    shown = page_data(program, None)["source"]
    assert (shown["lines"], shown["missing"]) == (
        [],
        "changed.py was changed since it was compiled",
    )
    file.unlink()
    assert page_data(program, None)["source"]["missing"] == "changed.py was not found"
    (tmp_path / "beside").mkdir()
    (tmp_path / "beside" / "changed.py").write_text(text)
    assert page_data(program, None, folder=tmp_path / "beside")["source"]["lines"]


def test_the_run_is_the_engines(strided, with_run):
    run, args = with_run.data["run"], arguments()
    result = vividc.simulate(strided, *args)
    assert run["cycles"] == result.cycles
    assert [region["cycles"] for region in run["regions"]] == [
        region["cycles"] for region in result.stats["regions"]
    ]
    assert run["end"] == result.cycles
    assert len(run["stalled"]) == sum(region["stalls"] for region in run["regions"]) > 0
    assert sum(run["issues"]) == sum(result.stats["operations"].values())
    activity = result.stats["activity"]
    assert sum(run["accesses"]) == activity["scratchpad_reads"] + activity["scratchpad_writes"]
    assert sum(run["carried"]) >= activity["link_words"] > 0
    for cycle, region, slot, issued, _, _ in run["samples"]:
        shown = with_run.data["regions"][region]["slots"][slot]
        there = {(pe, node) for pe, node, _ in shown["issues"]}
        assert {(pe, node) for pe, node, _ in issued} <= there
        assert cycle not in run["stalled"]


def test_arguments_are_left_as_they_were(strided):
    args = arguments()
    page_data(strided, args)
    assert not args[1].any()


def test_a_run_that_fails_is_shown_up_to_there(strided):
    x, y, a, b, _ = arguments()
    run = page_data(strided, (x, y, a, b, 100))["run"]
    assert "out-of-bounds" in run["error"]
    assert "out-of-bounds" in run["stopped"]
    assert run["samples"]
    assert run["cycles"] is None


def test_a_window_is_a_part_of_the_run(strided):
    run = page_data(strided, arguments(), cycles=(50, 60))["run"]
    assert [sample[0] for sample in run["samples"] + [[c] for c in run["stalled"]]]
    assert all(50 <= sample[0] < 60 for sample in run["samples"])
    with pytest.raises(vividc.VividcError, match=r"ends before cycle 100,000"):
        page_data(strided, arguments(), cycles=(100_000, 100_010))
    with pytest.raises(vividc.VividcError, match=r"more than a page takes"):
        page_data(strided, arguments(), cycles=(0, 1_000_000))


def test_the_page_loads_nothing_and_says_so(with_run):
    policy = next(a for tag, a in with_run.elements if a.get("http-equiv"))
    assert policy["content"].startswith("default-src 'none'")
    for tag, attrs in with_run.elements:
        assert tag not in ("link", "iframe", "img", "object", "embed")
        assert not {"src", "href", "srcset"} & attrs.keys()
    assert not any(re.search(r"https?:|//[a-z]+\.|url\((?!#)|@import", s) for s in with_run.scripts)


def test_panes_and_controls_have_names(with_run):
    named = [attrs for tag, attrs in with_run.elements if tag == "section"]
    assert len(named) == 7
    for attrs in named:
        assert attrs["aria-labelledby"] in with_run.ids
    labels = {attrs.get("for") for tag, attrs in with_run.elements if tag == "label"}
    assert {"slot", "cycle"} <= labels


def test_what_a_hostile_program_says_is_text():
    script = as_script({"name": HOSTILE})
    assert not re.search("[<>&\u2028]", script)
    assert json.loads(script) == {"name": HOSTILE}


def test_a_hostile_name_ends_up_in_no_element(strided, tmp_path):
    source = tmp_path / "hostile.py"
    source.write_text(f"# {HOSTILE} @DATA@ @CODE@\n")
    shown = Page(page(strided, source=source))
    assert [tag for tag, _ in shown.elements].count("script") == 2
    assert shown.data["source"]["lines"] == [f"# {HOSTILE} @DATA@ @CODE@", ""]


@pytest.mark.parametrize("name", preset_names())
def test_every_fabric_has_its_pes_and_links_drawn(name):
    fabric = load_tile(name)
    shown = fabric_data(fabric)
    assert len(shown["pes"]) == len(fabric.pes)
    assert [(one["src"], one["dst"]) for one in shown["links"]] == [
        (link.src, link.dst) for link in fabric.links
    ]
    for one in (*shown["links"],):
        for x, y in (point for run in one["runs"] for point in run):
            assert 0 <= x <= shown["width"]
            assert 0 <= y <= shown["height"]


def test_view_writes_the_page(strided, tmp_path):
    vividc.view(strided, tmp_path / "p.html", arguments(), cycles=(0, 20))
    shown = Page((tmp_path / "p.html").read_text(encoding="utf-8"))
    assert shown.data["run"]["end"] == 20
    named = dict(zip("xyabn", arguments(), strict=True))
    vividc.view(strided, str(tmp_path / "q.html"), named)
    assert (tmp_path / "q.html").stat().st_size < 1_500_000
    with pytest.raises(vividc.VividcError, match="the program"):
        vividc.view(small_kernels.strided, tmp_path / "p.html")
