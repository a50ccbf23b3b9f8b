"""The page of `vividc view` in headless Chromium: clicks, sliders, keyboard, screens."""

import re

import numpy as np
import pytest

import vividc
from kernels.dot import dot
from tests.sim.view import small_kernels

LOOP = 0


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Pages: a run with stalls, and a recurrence without a run."""
    folder = tmp_path_factory.mktemp("pages")
    strided = vividc.compile(small_kernels.strided, time_limit_s=30)
    args = (np.arange(640, dtype=np.int32), np.zeros(80, np.int32), 8, 0, 40)
    vividc.view(strided, folder / "run.html", args)
    vividc.view(vividc.compile(dot, time_limit_s=30), folder / "dot.html")
    return folder


@pytest.fixture
def opened(browser, files):
    """Opens a page; a script's error or a request fails the test."""
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    wrong = []

    def go(name):
        tab = context.new_page()
        tab.on("pageerror", lambda error: wrong.append(str(error)))
        tab.on("console", lambda message: wrong.append(message.text))
        tab.on("request", lambda r: wrong.append(r.url) if not r.url.startswith("file:") else None)
        tab.goto((files / name).as_uri())
        return tab

    yield go
    context.close()
    assert not wrong


def loop(tab):
    """The data of the region on show."""
    return tab.evaluate("region()")


def marked(tab, pane):
    return tab.eval_on_selector_all(
        f"#{pane} .on[data-node]", "all => all.map(one => Number(one.dataset.node))"
    )


def test_the_loop_is_chosen_with_its_graph_array_and_schedule(opened):
    tab = opened("dot.html")
    region = loop(tab)
    assert region["kind"] == "loop"
    nodes = tab.locator("#graph [data-node]")
    assert nodes.count() == len(region["nodes"])
    assert tab.locator("#table [data-node]").count() == sum(
        node["time"] is not None for node in region["nodes"]
    )
    assert tab.locator("#array .pe").count() == 16
    assert tab.locator("#run-pane").is_hidden()
    assert tab.locator("#modes").is_hidden()


def test_the_recurrence_is_marked_in_graph_source_array_and_schedule(opened):
    tab = opened("dot.html")
    region = loop(tab)
    bound = region["bounds"][region["binds"]]
    assert bound["name"] == "RecMII"
    assert tab.locator("#graph .edge.binds").count() == len(bound["edges"]) > 0
    assert tab.locator("#graph .node.binds").count() == len(bound["nodes"])
    assert tab.locator("#source .line.binds").count() == 1
    assert tab.locator("#table .binds").count() > 0
    node = next(n for n in region["nodes"] if n["id"] in bound["nodes"] and n["pe"] is not None)
    tab.evaluate("slot => setSlot(slot)", node["time"] % region["ii"])
    assert tab.locator(f'#array .pe.binds[data-pe="{node["pe"]}"]').count() == 1
    tab.locator("#binding").uncheck()
    assert tab.locator(".binds").count() == 0
    tab.locator('[data-bound="1"]').click()
    assert tab.locator('[data-bound="1"]').get_attribute("aria-pressed") == "true"
    assert tab.locator("#graph .node.binds").count() == len(region["bounds"][1]["nodes"])


def test_a_click_shows_an_operation_everywhere_and_escape_lets_it_go(opened):
    tab = opened("dot.html")
    region = loop(tab)
    node = next(node for node in region["nodes"] if node["name"] == "fma")
    tab.locator(f'#graph [data-node="{node["id"]}"]').click()
    tab.mouse.move(0, 0)
    assert marked(tab, "graph") == marked(tab, "table") == [node["id"]]
    assert node["id"] in marked(tab, "array")
    assert tab.locator("#slot").input_value() == str(node["time"] % region["ii"])
    assert tab.locator("#source .line.on").get_attribute("data-line") == str(node["line"])
    assert tab.locator("#detail").text_content() == node["title"]
    tab.keyboard.press("Escape")
    assert tab.locator(".on").count() == 0


def test_pointing_at_a_line_marks_its_operations(opened):
    tab = opened("dot.html")
    tab.locator('#source [data-line="12"]').hover()
    expected = {n["id"] for n in loop(tab)["nodes"] if n["line"] == 12 and n["pe"] is not None}
    assert set(marked(tab, "graph")) == set(marked(tab, "table")) == expected


def test_the_slider_walks_through_the_contexts_by_keyboard(opened):
    tab = opened("dot.html")
    region = loop(tab)
    slider = tab.locator("#slot")
    slider.focus()
    for slot in range(1, region["ii"]):
        tab.keyboard.press("ArrowRight")
        assert slider.get_attribute("aria-valuetext") == f"context {slot} of {region['ii']}"
        busy = tab.eval_on_selector_all(
            "#array .pe.busy", "all => all.map(one => Number(one.dataset.pe))"
        )
        assert set(busy) == {pe for pe, _, _ in region["slots"][slot]["issues"]}
        shaded = tab.eval_on_selector_all("#table .now", "all => all.map(r => r.dataset.context)")
        assert set(shaded) <= {str(slot)}
        driven = tab.eval_on_selector_all(
            "#array .link.used", "all => all.map(one => Number(one.dataset.link))"
        )
        assert sorted(driven) == sorted(link for link, _ in region["slots"][slot]["links"])


def test_regions_are_chosen_with_arrow_keys(opened):
    tab = opened("run.html")
    tab.locator("#regions input:checked").focus()
    before = loop(tab)["name"]
    tab.keyboard.press("ArrowUp")
    assert loop(tab)["name"] != before
    shown = tab.locator("#regions label", has=tab.locator(":checked")).text_content()
    assert loop(tab)["name"] in shown


def test_arrow_keys_follow_the_graph_and_enter_keeps(opened):
    tab = opened("dot.html")
    region = loop(tab)
    load = next(node["id"] for node in region["nodes"] if node["name"] == "load")
    after = next(e["dst"] for e in region["edges"] if e["src"] == load and not e["distance"])
    tab.locator(f'#graph [data-node="{load}"]').focus()
    tab.keyboard.press("ArrowDown")
    assert marked(tab, "graph") == [after]
    tab.keyboard.press("Enter")
    tab.evaluate("document.activeElement.blur()")
    assert marked(tab, "table") == [after]
    assert tab.locator('#graph [tabindex="0"]').count() == 1


def test_the_cycles_of_a_run(opened):
    tab = opened("run.html")
    run = tab.evaluate("data.run")
    tab.get_by_label("run", exact=True).check()
    tab.locator("#stall").click()
    assert tab.locator("#cycle").input_value() == str(run["stalled"][0])
    assert "stands still" in tab.locator("#array-note").text_content()
    tab.locator("#cycle").focus()
    tab.keyboard.press("ArrowLeft")
    cycle, region, slot, issued, _, banks = next(
        sample for sample in run["samples"] if sample[0] == run["stalled"][0] - 1
    )
    assert tab.locator("#cycle").get_attribute("aria-valuetext") == f"cycle {cycle}"
    assert tab.evaluate("[state.region, state.slot]") == [region, slot]
    assert tab.locator("#array .pe.busy").count() >= len(issued)
    meeting = {bank for bank in banks if banks.count(bank) > 1}
    conflicts = tab.eval_on_selector_all(
        "#array .bank.conflict", "all => all.map(one => Number(one.dataset.bank))"
    )
    assert set(conflicts) == meeting
    assert meeting


def test_the_heat_of_a_run(opened):
    tab = opened("run.html")
    run = tab.evaluate("data.run")
    tab.get_by_label("heat", exact=True).check()
    busiest = max(range(16), key=lambda pe: run["issues"][pe])
    share = round(100 * run["issues"][busiest] / (run["end"] - run["first"]))
    shown = tab.locator(f'#array [data-pe="{busiest}"] .name').text_content()
    assert abs(int(re.match(r"\d+", shown)[0]) - share) <= 1
    assert tab.locator("#array .link.used").count() == sum(map(bool, run["carried"]))
    assert tab.locator("#array .bank").count() == 8
    assert f"{len(run['stalled'])} cycles stalled" in tab.locator("#array-note").text_content()


@pytest.mark.parametrize(("width", "height"), [(1000, 700), (1600, 1000), (390, 844)])
def test_every_screen_shows_every_pane(opened, width, height):
    tab = opened("run.html")
    tab.set_viewport_size({"width": width, "height": height})
    assert tab.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
    for pane in ("regions", "source", "graph", "array", "table", "bounds", "run"):
        box = tab.locator(f"#{pane}-pane").bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= width
        assert box["height"] > 40
        assert box["width"] > (200 if pane == "regions" else 300)


def test_everything_that_acts_has_a_name_and_can_be_reached(opened):
    tab = opened("run.html")
    unnamed = tab.evaluate(
        """() => [...document.querySelectorAll('button, input, [role=button], [role=radiogroup]')]
        .filter(one => !(one.getAttribute('aria-label') || one.getAttribute('aria-labelledby') ||
            (one.labels && one.labels.length) || one.textContent.trim()))
        .map(one => one.outerHTML)"""
    )
    assert unnamed == []
    seen = []
    for _ in range(25):
        tab.keyboard.press("Tab")
        seen.append(tab.evaluate("document.activeElement.closest('section')?.id"))
    order = [pane for pane in dict.fromkeys(seen) if pane]
    wanted = ["regions-pane", "source-pane", "graph-pane", "array-pane", "table-pane"]
    assert [pane for pane in order if pane in wanted] == wanted
