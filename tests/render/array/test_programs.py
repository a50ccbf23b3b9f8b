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
from vividc.render import SceneError, orbit_camera, read_scene
from vividc.render.array import ArrayOptions, RenderPrecision, render
from vividc.render.array.device import programs as device_programs
from vividc.render.array.device.ahead import compile_ahead
from vividc.render.array.device.kernels import METHODS, all_kernels, kernels_of
from vividc.render.array.device.programs import Programs, kernel_folder, kernel_module
from vividc.render.array.device.ship import ship

MIC = Path(__file__).parents[3] / "scenes" / "mic"
FILES = [
    ("mic_3dgs_sh3.ply", "3dgs"),
    ("mic_kilonerf.npz", "kilonerf"),
    ("mic_ngp_hash.npz", "instant-ngp"),
    ("mic_tensorf_vm.npz", "tensorf"),
]
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


SOME = [(FIR, {}), ("saxpy:saxpy", {}), (FIR, {"effort": "fast"})]


@pytest.mark.skipif(os.name != "posix", reason="helpers are started on POSIX only")
def test_kernels_are_compiled_ahead_by_several_processes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("VIVIDC_CACHE_DIR", str(tmp_path / "alone"))
    alone = [programs([]).get(kernel, **options).to_bytes() for kernel, options in SOME]
    monkeypatch.setenv("VIVIDC_CACHE_DIR", str(tmp_path / "together"))
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    told: list[str] = []
    here = programs(told)
    compile_ahead(here, SOME)
    assert told[0] == "compiling 3 kernels in 2 processes"
    assert all(here.is_at_hand(kernel, **options) for kernel, options in SOME)
    before = len(told)
    assert [here.get(kernel, **options).to_bytes() for kernel, options in SOME] == alone
    assert len(told) == before
    compile_ahead(here, SOME)  # nothing is missing
    assert len(told) == before


def test_without_a_cache_nothing_is_compiled_ahead(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VIVIDC_CACHE_DIR", "")
    told: list[str] = []
    compile_ahead(programs(told), SOME)
    assert told == []


def test_programs_are_shipped_under_the_keys_that_are_looked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("VIVIDC_CACHE_DIR", str(tmp_path / "maker"))
    folder = tmp_path / "programs"
    folder.mkdir()
    (folder / "stale").write_text("")
    ship(programs([]), SOME, folder)
    assert len(list(folder.iterdir())) == len(SOME)
    monkeypatch.setenv("VIVIDC_CACHE_DIR", str(tmp_path / "user"))
    monkeypatch.setattr(device_programs, "SHIPPED", folder)
    told: list[str] = []
    user = programs(told)
    assert user.get(FIR).name == "prefix_sum"
    assert user.is_at_hand("saxpy:saxpy")
    assert told == []
    assert not user.is_at_hand("fir:fir")


def test_every_kernel_of_a_frame_is_there() -> None:
    kernels = all_kernels()
    assert len(kernels) == 46
    for kernel, _ in kernels:
        file, _, function = kernel.partition(":")
        module = kernel_module(kernel_folder() / f"{file}.py")
        assert isinstance(getattr(module, function), vividc.KernelFunction)


@pytest.mark.slow
@pytest.mark.parametrize("precision", ["fp32", "fp8"])
@pytest.mark.parametrize("method", METHODS)
def test_a_frame_runs_the_kernels_that_it_is_said_to(
    method: str, precision: RenderPrecision, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: set[str] = set()
    get = Programs.get

    def noted(self: Programs, kernel: str, **options: object) -> vividc.Program:
        asked.add(f"{kernel} {options}")
        return get(self, kernel, **options)

    monkeypatch.setattr(Programs, "get", noted)
    monkeypatch.setattr(render, "compile_ahead", lambda *_: None)
    (file,) = (MIC / name for name, of in FILES if of == method)
    scene = read_scene(file)[1]
    camera = orbit_camera(scene, 30.0, 20.0, "+z", 24, 24)
    render.render_array(scene, camera, ArrayOptions(precision=precision))
    assert asked == {f"{kernel} {options}" for kernel, options in kernels_of(method, precision)}
