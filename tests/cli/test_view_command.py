"""`vividc view`: files, options and refusals."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import vividc
from tests.sim.view import small_kernels
from vividc.cli import main


def run(*args):
    return CliRunner().invoke(main, ["view", *map(str, args)])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("view")
    vividc.compile(small_kernels.total, time_limit_s=30).save(folder / "total.vivid")
    np.savez(folder / "in.npz", x=np.arange(40, dtype=np.int32), n=40)
    return folder


def test_the_page_lies_beside_the_program(folder):
    done = run(folder / "total.vivid")
    assert (done.exit_code, done.stdout) == (0, f"written: {folder / 'total.html'}\n")
    assert "total on vivid-tile" in (folder / "total.html").read_text()


def test_a_run_and_json(folder, tmp_path):
    out = tmp_path / "p.html"
    done = run(
        *(folder / "total.vivid", "--inputs", folder / "in.npz", "--cycles", "5:15"),
        *("-o", out, "--json"),
    )
    assert done.exit_code == 0, done.stderr
    said = json.loads(done.stdout)
    assert said["schema"] == "vividc.view/1"
    assert (said["output"], said["bytes"]) == (str(out), out.stat().st_size)
    assert '"first":5,"end":15' in out.read_text()


@vividc.kernel("int32[::1](int32[::1])")
def doubled(x):
    out = np.zeros(len(x), np.int32)
    for i in range(len(x)):
        out[i] = 2 * x[i]
    return out


def test_what_a_kernel_returns_is_no_input(tmp_path):
    vividc.compile(doubled, effort="fast").save(tmp_path / "d.vivid")
    np.savez(tmp_path / "in.npz", x=np.arange(3, dtype=np.int32))
    done = run(tmp_path / "d.vivid", "--inputs", tmp_path / "in.npz")
    assert done.exit_code == 0, done.stderr
    assert "array([0, 2, 4], dtype=int32)" in (tmp_path / "d.html").read_text()


def test_the_page_is_opened_when_asked_for(folder, tmp_path, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    assert run(folder / "total.vivid", "-o", tmp_path / "p.html", "--open").exit_code == 0
    assert opened == [(tmp_path / "p.html").as_uri()]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--cycles", "0:10"), "--cycles needs --inputs"),
        (("--inputs", "IN", "--cycles", "9:3"), "is not FIRST:END"),
        (("--inputs", "IN", "--cycles", "900:950"), "the run ends before cycle 900"),
        (("-o", "PROGRAM"), "--output"),
        (("--source", "no.py"), "no.py: cannot be read"),
    ],
)
def test_what_cannot_be_shown_is_refused_and_writes_nothing(folder, tmp_path, options, message):
    names = {"IN": folder / "in.npz", "PROGRAM": folder / "total.vivid"}
    where = () if "-o" in options else ("-o", tmp_path / "p.html")
    done = run(folder / "total.vivid", *where, *(names.get(one, one) for one in options))
    assert done.exit_code == 2
    assert message in done.stderr
    assert not (tmp_path / "p.html").exists()
    assert vividc.load(folder / "total.vivid").name == "total"
