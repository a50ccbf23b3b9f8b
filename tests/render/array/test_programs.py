"""Programs of stages: found, compiled once, kept on disk, and compiled again if damaged."""

from __future__ import annotations

import errno
import os
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import pytest

import vividc
from vividc.errors import VividcWarning
from vividc.host import store
from vividc.program import CUT_SHORT
from vividc.render import SceneError
from vividc.render.array.device.programs import Programs, kernel_folder

FIR = "prefix_sum:prefix_sum"


def programs(told: list[str]) -> Programs:
    return Programs(vividc.arch.load_accelerator("vivid"), told.append, mapping_s=5)


def test_a_kernel_is_compiled_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VIVIDC_CACHE_DIR", str(tmp_path))
    told: list[str] = []
    first = programs(told).get(FIR)
    assert told == ["compiling prefix_sum:prefix_sum (kept for the next time)"]
    (bundle,) = (tmp_path / "entries").glob("stage-*")
    held = programs(told)
    again = held.get(FIR)
    assert again is held.get(FIR)
    assert len(told) == 1
    assert [r.ii for r in again.regions] == [r.ii for r in first.regions]
    bundle.write_bytes(bundle.read_bytes()[:100])
    monkeypatch.setattr(store, "warned", [])
    with pytest.warns(VividcWarning, match="stage-.* is damaged"):
        programs(told).get(FIR)
    assert len(told) == 2
    programs(told).get(FIR)
    assert len(told) == 2


def test_a_program_that_the_clock_cut_short_is_not_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("VIVIDC_CACHE_DIR", str(tmp_path))
    told: list[str] = []
    cut = f"prefix_sum.py:5: the search for mappings took too long and {CUT_SHORT}"
    program = replace(programs(told).get(FIR), warnings=(cut,))
    (bundle,) = (tmp_path / "entries").glob("stage-*")
    bundle.unlink()
    monkeypatch.setattr(vividc, "compile", lambda *_, **__: program)
    held = programs(told)
    assert held.late == ()
    assert held.get(FIR) is program
    (late,) = held.late
    assert late.startswith("prefix_sum: the clock ended")
    assert told[-1].endswith("not kept: it is compiled again")
    assert not list((tmp_path / "entries").glob("stage-*"))


def test_a_program_that_cannot_be_kept_is_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("VIVIDC_CACHE_DIR", str(tmp_path))
    no_room = OSError(errno.ENOSPC, "No space left on device")
    monkeypatch.setattr(os, "fsync", Mock(side_effect=no_room))
    assert programs([]).get(FIR).name == "prefix_sum"
    assert not list((tmp_path / "entries").glob("stage-*"))


def test_options_and_places_are_told_apart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VIVIDC_CACHE_DIR", str(tmp_path))
    told: list[str] = []
    programs(told).get(FIR)
    programs(told).get(FIR, loops=vividc.LoopOptions(auto=False))
    assert len(list((tmp_path / "entries").glob("stage-*"))) == len(told) == 2


def test_without_a_cache_nothing_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VIVIDC_CACHE_DIR", "")
    assert programs([]).get(FIR).name == "prefix_sum"


def test_a_folder_that_cannot_be_written_is_no_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("VIVIDC_CACHE_DIR", str(tmp_path / "file"))
    assert programs([]).get(FIR).name == "prefix_sum"


def test_mistakes_are_messages() -> None:
    with pytest.raises(SceneError, match=r"prefix_sum\.py: has no kernel `absent`"):
        programs([]).get("prefix_sum:absent")
    with pytest.raises(SceneError, match=r"absent\.py: cannot be read: No such file"):
        programs([]).get("absent:kernel")


def test_the_kernels_are_found() -> None:
    assert (kernel_folder() / "render" / "marching.py").is_file()
