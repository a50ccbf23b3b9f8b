"""The report: what is measured for it, kept, and written. Frames are made up."""

from __future__ import annotations

import json
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest
from click.testing import CliRunner

from vividc.cli import main
from vividc.errors import VividcError
from vividc.paper import EXHIBITS, reproduce
from vividc.paper.frames import ALL_VIEWS, Key, Row, in_child
from vividc.paper.reproduce import DATA, PAGE, ROWS, Recipe
from vividc.paper.scenes import CHECKOUT, METHODS, Scenes
from vividc.render import SceneError

FRAMES = ("fig1b", "table2", "fig7ab", "fig7c", "weights", "table3")
RATE = {"kilonerf": 20.0, "instant-ngp": 8.0, "tensorf": 40.0, "3dgs": 179.0}


class Frames:
    """Makes up a frame of each key, until it is told to stop."""

    def __init__(self, most: int = 10_000) -> None:
        self.keys: list[Key] = []
        self.most = most

    def __call__(self, key: Key, scenes: Scenes, folder: str) -> Row:
        if len(self.keys) == self.most:
            raise KeyboardInterrupt
        self.keys.append(key)
        rate = RATE[key.method] * (1 if key.precision == "fp8" else 0.5)
        stages = {"blend": 7e5, "binning": 3e5} if key.method == "3dgs" else {"basis": 1e6}
        return Row(key, "done", rate, stages, psnr_reference=50.0, energy_mj=2.0 * key.sample)


class Page(HTMLParser):
    """What a page has: tags that are closed, headings, and what it would load."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.loaded: list[str] = []
        self.ids: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in ("meta", "br") and tag not in ("path", "rect", "line", "circle"):
            self.open.append(tag)
        found = dict(attrs)
        self.loaded += [str(found[name]) for name in ("src", "href") if name in found]
        self.ids += [str(found["id"])] if tag == "section" else []

    def handle_endtag(self, tag: str) -> None:
        if tag in self.open:
            assert self.open.pop() == tag


def test_every_exhibit_of_frames_is_on_the_page(tmp_path: Path) -> None:
    told: list[str] = []
    frames = Frames()
    report = reproduce(tmp_path, only=FRAMES, tell=told.append, measure=frames)
    assert [exhibit.name for exhibit in report.exhibits] == list(FRAMES)
    assert (report.measured, report.kept) == (len(frames.keys), 0)
    assert f"{len(frames.keys)} of {len(frames.keys)} frames to render: about" in told[0]
    assert len(told) == 1 + len(frames.keys)
    page = Page((tmp_path / PAGE).read_text())
    assert page.open == []
    assert page.ids == list(FRAMES)
    assert all(link.startswith("#") for link in page.loaded)
    by_name = {exhibit.name: exhibit for exhibit in report.exhibits}
    verdicts = {line.what: line.verdict for line in by_name["fig7c"].lines}
    assert verdicts["instant-ngp: frames a second"] == "different"
    assert {verdicts[f"{m}: frames a second"] for m in METHODS if m != "instant-ngp"} == {
        "reproduced"
    }
    breakdown = {line.what: line.ours for line in by_name["fig1b"].lines}
    assert breakdown == {
        "kilonerf: networks": 1.0,
        "3dgs: sorting": pytest.approx(0.3),
        "3dgs: blending": pytest.approx(0.7),
    }
    ours = {row[1]: row for row in by_name["fig7ab"].tables[0].rows if row[0] == "vividc"}
    # 20 frames of 800x800 and 2 mJ a second; the sampled energy counts for the whole.
    assert ours["kilonerf"][3:6] == ("12.8", "0.0", "320.0")
    body = json.loads((tmp_path / DATA).read_text())
    assert [one["name"] for one in body["exhibits"]] == list(FRAMES)
    for exhibit in report.exhibits:
        assert all((tmp_path / f"{exhibit.name}-{name}.svg").is_file() for name in exhibit.pictures)


def test_other_memories_and_sizes_are_measured(tmp_path: Path) -> None:
    frames = Frames()
    reproduce(tmp_path, only=["table3"], measure=frames)
    fabrics = {key.fabric for key in frames.keys}
    assert len(fabrics) == 5  # vivid itself has 32 GB/s and 32 KiB
    assert "vivid" in fabrics
    assert any("size_bytes: 65536" in fabric for fabric in fabrics)
    assert {key.size for key in frames.keys} == {800, 1024, 1080}
    quick = Frames()
    reproduce(tmp_path, only=["table3"], quick=True, measure=quick)
    assert {key.size for key in quick.keys} == {200, 256, 268}


def test_rates_of_small_pictures_have_no_verdict(tmp_path: Path) -> None:
    """The paper's are of 800x800."""
    found = {}
    for quick in (False, True):
        exhibits = ["fig7c", "weights", "table3"]
        report = reproduce(tmp_path, only=exhibits, quick=quick, measure=Frames())
        lines = [line for one in report.exhibits for line in one.lines if line.ours is not None]
        found[quick] = {line.verdict for line in lines}
        assert quick == all("pictures of 200x200" in line.because for line in lines)
    assert "not measured" not in found[False]
    assert found[True] == {"not measured"}


def test_an_interrupted_run_goes_on(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        reproduce(tmp_path, only=["fig7c"], measure=Frames(most=5))
    with (tmp_path / ROWS).open("a") as file:
        file.write('{"made_by": "cut sho')
    rest = Frames()
    report = reproduce(tmp_path, only=["fig7c"], measure=rest)
    assert (report.measured, report.kept) == (len(rest.keys), 5)
    again = Frames(most=0)
    assert reproduce(tmp_path, only=["fig7c"], measure=again).measured == 0


def test_rows_of_other_code_do_not_count(tmp_path: Path) -> None:
    frames = Frames()
    reproduce(tmp_path, only=["fig1b"], measure=frames)
    rows = (tmp_path / ROWS).read_text()
    made_by = json.loads(rows.splitlines()[0])["made_by"]
    (tmp_path / ROWS).write_text(rows.replace(made_by, "another"))
    assert reproduce(tmp_path, only=["fig1b"], measure=Frames()).measured == len(frames.keys)


def test_what_was_not_measured_says_so(tmp_path: Path) -> None:
    def fails(key: Key, scenes: Scenes, folder: str) -> Row:
        return Row(key, "the scene does not fit")

    report = reproduce(tmp_path, only=["fig7c", "fig1b"], measure=fails)
    lines = [line for exhibit in report.exhibits for line in exhibit.lines]
    assert {line.verdict for line in lines} == {"not measured", "not reproducible here"}
    assert all(line.because for line in lines)


def test_errors(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(VividcError, match="no exhibit 'fig9'"):
        reproduce(tmp_path, only=["fig9"])
    with monkeypatch.context() as patched:
        patched.setattr(sys.modules[Recipe.__module__], "CHECKOUT", tmp_path / "installed")
        with pytest.raises(SceneError, match=r"mic_3dgs_sh3\.ply` is in none of"):
            reproduce(tmp_path, only=["fig6"], scenes=[tmp_path / "nowhere"])
    (tmp_path / "file").write_text("")
    with pytest.raises(VividcError, match="cannot be made"):
        reproduce(tmp_path / "file", only=["fig6"])
    assert not (tmp_path / PAGE).exists()


def test_the_command_prints_a_table_and_data(tmp_path: Path) -> None:
    args = ["reproduce", "-o", str(tmp_path / "report"), "--only", "fig6"]
    run = CliRunner().invoke(main, args)
    assert run.exit_code == 0
    assert "Figure 6: area" in run.stdout
    assert "reproduced" in run.stdout
    assert (tmp_path / "report" / PAGE).is_file()
    body = json.loads(CliRunner().invoke(main, [*args, "--json"]).stdout)
    assert body["schema"] == "vividc.reproduce/1"
    assert body["exhibits"][0]["lines"][0]["verdict"] == "reproduced"
    assert CliRunner().invoke(main, ["reproduce", "--only", "fig9"]).exit_code == 2


def test_modes_and_reconfiguration(tmp_path: Path) -> None:
    report = reproduce(tmp_path, only=["eq45", "fig8a"])
    reload, modes = report.exhibits
    assert reload.lines[0].verdict == "reproduced"
    nearest = next(line for line in modes.lines if line.what == "the nearest width")
    assert nearest.verdict == "reproduced"
    assert set(EXHIBITS) >= {"eq45", "fig8a"}


def test_a_frame_is_measured_in_a_process_of_its_own(tmp_path: Path) -> None:
    """Of a scene that is not there: the process fails, and the row says so."""
    nowhere = Scenes((tmp_path,))
    row = in_child(Key("mic", "3dgs", 8, 0), nowhere, str(tmp_path))
    assert row.status == "the process that rendered it died"
    whole = in_child(Key("mic", "3dgs", 8, ALL_VIEWS), Scenes((CHECKOUT,)), str(tmp_path))
    assert whole.status == "no photographs of this size"


def test_scenes_of_a_folder_are_beside_those_of_the_checkout(tmp_path: Path) -> None:
    (tmp_path / "scenes" / "playbot").mkdir(parents=True)
    frames = Frames()
    scenes = [tmp_path / "scenes"]
    report = reproduce(tmp_path / "report", only=["fig1b"], scenes=scenes, measure=frames)
    assert report.measured == len(frames.keys) > 0
