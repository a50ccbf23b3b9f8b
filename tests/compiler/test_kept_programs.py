"""Programs that were compiled before are taken from the cache: the same ones, and no others."""

from __future__ import annotations

import stat
import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vividc
from vividc import LoopOptions, arch
from vividc.compiler import driver, kept_programs
from vividc.errors import VividcWarning
from vividc.host import store, time_limit
from vividc.host.watch import Watch, watching
from vividc.mapper.registry import BUILT_IN

FACTOR = np.float32(2.0)


@vividc.kernel("void(float32[::1], float32[::1])")
def scale(x, y):
    for i in range(len(x)):
        y[i] = FACTOR * x[i]


@vividc.kernel("void(float32[::1])")
def demoted(x):
    """Its float64 constant is warned of."""
    for i in range(len(x)):
        x[i] = 0.1 * x[i]


@pytest.fixture(autouse=True)
def entries(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A cache of the test's own."""
    monkeypatch.setenv("VIVIDC_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.delenv("VIVIDC_CACHE_PROGRAMS")
    monkeypatch.setattr(store, "warned", [])
    return tmp_path / "cache" / "entries"


@pytest.fixture
def compiled(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the kernels that were not taken from the cache."""
    names: list[str] = []
    whole = driver.compile_stages

    def noted(function: Any, *rest: Any) -> vividc.Program:
        if "all" not in rest:  # as parts of an accelerator's program are compiled
            names.append(function.name)
        return whole(function, *rest)

    monkeypatch.setattr(driver, "compile_stages", noted)
    return names


def kept(entries: Path) -> list[Path]:
    return sorted(entries.glob("program-*"))


@pytest.mark.parametrize("fabric", ["vivid-tile", "vivid"])
def test_a_second_compilation_gives_the_same_program(compiled: list[str], fabric: str) -> None:
    first = vividc.compile(scale, fabric)
    second = vividc.compile(scale, fabric)
    assert compiled == ["scale"]
    assert second == first
    assert second.to_bytes() == first.to_bytes()
    x, y = np.arange(20, dtype=np.float32), np.zeros(20, np.float32)
    vividc.simulate(second, x, y)
    assert np.array_equal(y, 2 * x)


OTHERS: dict[str, Callable[[], dict[str, Any]]] = {
    "loops": lambda: {"loops": LoopOptions(auto=False)},
    "a factor": lambda: {"loops": LoopOptions(unroll={scale.line + 2: 2})},
    "contract": lambda: {"contract": False},
    "reassociate": lambda: {"reassociate": True},
    "effort": lambda: {"effort": "fast"},
    "mapper": lambda: {"mapper": "decoupled"},
    "limit": lambda: {"time_limit_s": 50.0},
    "sizes": lambda: {"like": {"x": 16}},
    "precision": lambda: {"precision": {"fma": "fp16"}},
    "fabric": lambda: {"fabric": "mesh-4x4"},
    "accelerator": lambda: {"fabric": "vivid"},
}


@pytest.mark.parametrize("other", OTHERS)
def test_what_a_program_follows_from_tells_it_apart(compiled: list[str], other: str) -> None:
    vividc.compile(scale)
    vividc.compile(scale, **OTHERS[other]())
    assert compiled == ["scale", "scale"]


SOURCE = """\
import numpy as np
import vividc

{constant}

@vividc.kernel("void(int32[::1])")
def add(x):
    for i in range(len(x)):
        x[i] += {value}
"""


def _written(path: Path, **parts: str) -> vividc.KernelFunction:
    from vividc.cli.kernels import load_kernel  # noqa: PLC0415 - the command's way to a kernel

    path.write_text(SOURCE.format(**{"constant": "", "value": "1", **parts}))
    kernel = load_kernel(str(path))
    assert isinstance(kernel, vividc.KernelFunction)
    return kernel


def test_an_edited_kernel_is_another_one(compiled: list[str], tmp_path: Path) -> None:
    path = tmp_path / "k.py"
    results = []
    for parts in (
        {"value": "1"},
        {"value": "2"},
        {"constant": "N = np.int32(3)", "value": "N"},
        {"constant": "N = np.int32(4)", "value": "N"},
        {"constant": "N = np.int32(3)", "value": "N"},
    ):
        x = np.zeros(4, np.int32)
        vividc.simulate(vividc.compile(_written(path, **parts)), x)
        results.append(int(x[0]))
    assert results == [1, 2, 3, 4, 3]
    assert len(compiled) == 4


def test_a_program_names_the_file_it_was_compiled_from(tmp_path: Path) -> None:
    one = vividc.compile(_written(tmp_path / "one.py"))
    two = vividc.compile(_written(tmp_path / "two.py"))
    assert one.provenance.kernel_file != two.provenance.kernel_file
    assert two.provenance.kernel_file == str(tmp_path / "two.py")


def test_it_can_be_left_alone(
    compiled: list[str], entries: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    vividc.compile(scale, cache=False)
    monkeypatch.setenv(kept_programs.VARIABLE, "0")
    vividc.compile(scale)
    assert not kept(entries)
    monkeypatch.setenv(kept_programs.VARIABLE, "1")
    vividc.compile(scale)
    vividc.compile(scale, cache=False)
    assert len(compiled) == 4


def test_whoever_looks_at_stages_sees_them(compiled: list[str]) -> None:
    vividc.compile(scale)
    seen: list[str] = []
    with watching(Watch(lambda name, _: seen.append(name))):
        vividc.compile(scale)
    assert "map" in seen
    assert len(compiled) == 2


def test_programs_of_guest_mappers_are_not_kept(
    entries: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Their code is not part of a key."""
    monkeypatch.setattr("vividc.mapper.api.find_mapper", lambda _: BUILT_IN["auto"])
    vividc.compile(scale, mapper="guest")
    assert not kept(entries)


def test_warnings_are_given_each_time(compiled: list[str]) -> None:
    texts = []
    for _ in range(2):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            program = vividc.compile(demoted)
        texts.append([str(item.message) for item in caught])
        assert list(program.warnings) == texts[-1]
    assert texts[0] == texts[1]
    assert len(texts[0]) == 1
    assert len(compiled) == 1


def test_what_the_clock_cut_short_is_not_kept(
    entries: Path, compiled: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    noted = driver.compile_stages

    def cut(*given: Any) -> vividc.Program:
        time_limit.left_out("the search for mappings")
        return noted(*given)

    monkeypatch.setattr(driver, "compile_stages", cut)
    with pytest.warns(VividcWarning, match="took too long"):
        assert vividc.compile(scale).hurried
    assert not kept(entries)
    monkeypatch.setattr(driver, "compile_stages", noted)
    assert not vividc.compile(scale).hurried
    assert len(compiled) == 2


def test_a_fabric_that_is_not_that_of_its_text_is_not_kept(
    entries: Path, compiled: list[str]
) -> None:
    fabric = arch.load("vivid-tile")
    other = replace(fabric, controller=replace(fabric.controller, contexts=256))
    for _ in range(2):
        assert vividc.compile(scale, other).fabric.controller.contexts == 256
    assert not kept(entries)
    assert len(compiled) == 2


DAMAGES: dict[str, Callable[[Path], object]] = {
    "cut": lambda file: file.write_bytes(file.read_bytes()[:-9]),
    "empty": lambda file: file.write_bytes(b""),
    "other content": lambda file: file.write_bytes(b"PK" + bytes(100)),
    "one bit": lambda file: file.write_bytes(_flipped(file.read_bytes())),
    "a link": lambda file: (
        file.rename(file.with_suffix(".x")).exists() and file.symlink_to(file.with_suffix(".x"))
    ),
    "a folder": lambda file: (file.unlink(), file.mkdir()),
    "for all to write": lambda file: file.chmod(0o666),
}


def _flipped(content: bytes) -> bytes:
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 4]) + content[middle + 1 :]


@pytest.mark.parametrize("damage", DAMAGES)
def test_odd_entries_are_made_again(compiled: list[str], entries: Path, damage: str) -> None:
    first = vividc.compile(scale)
    [file] = kept(entries)
    DAMAGES[damage](file)
    with pytest.warns(VividcWarning, match="made again"):
        second = vividc.compile(scale)
    assert second == first
    assert len(compiled) == 2
    assert stat.S_ISREG(file.lstat().st_mode)
    vividc.compile(scale)
    assert len(compiled) == 2


def test_an_intact_entry_without_a_program_is_made_again(
    compiled: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As one that another version's file format left under an equal key would be."""
    with monkeypatch.context() as patch:
        patch.setattr(vividc.Program, "to_bytes", lambda _: b"no bundle")
        vividc.compile(scale)
    with pytest.warns(VividcWarning, match="holds no program"):
        vividc.compile(scale)
    vividc.compile(scale)
    assert len(compiled) == 2
