"""Random `.ll` modules: a message or the host's values, and nothing of the file runs unasked."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.fuzz import modules
from tests.fuzz.modules import judge
from vividc.frontend.c import host as ll_host


def check(seed: int, folder: Path) -> None:
    verdict = judge(seed, folder)
    assert not verdict.is_find, verdict.text


@pytest.fixture(autouse=True)
def _short_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ll_host, "LIMIT_S", 60.0)


@pytest.mark.filterwarnings("ignore::vividc.errors.VividcWarning")
@pytest.mark.parametrize("seed", range(1, 25))
def test_modules(seed: int, tmp_path: Path) -> None:
    check(seed, tmp_path)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::vividc.errors.VividcWarning")
@pytest.mark.parametrize("seed", range(100, 2000))
def test_many_modules(seed: int, tmp_path: Path) -> None:
    check(seed, tmp_path)


def test_foreign_code_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def run(path: Path, name: str, seed: int, *, defined: bool) -> modules.Verdict:
        (tmp_path / "executed").touch()
        return modules.Verdict("agrees", "")

    monkeypatch.setattr(modules, "_judged", run)
    assert judge(1, tmp_path).is_find
