"""Programs of products that are kept in the user's cache."""

from __future__ import annotations

import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from vividc import arch
from vividc.errors import VividcWarning
from vividc.gemm import chain
from vividc.gemm.kept import key_of, read_program, write_program
from vividc.gemm.systolic import Form, SystolicArray
from vividc.host import cache, store

ARRAY = SystolicArray.of(arch.load_tile("vivid-8x8"))
ONE = chain.Chain(ARRAY, (chain.Link(Form(3, relu=True), 1),), 2)


@pytest.fixture(autouse=True)
def folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.setenv("VIVIDC_CACHE_DIR", str(tmp_path))
    chain.kept_program.cache_clear()
    return tmp_path


def test_a_program_is_built_once(monkeypatch: pytest.MonkeyPatch) -> None:
    built = chain.chain_program(ONE)
    chain.kept_program.cache_clear()
    monkeypatch.setattr(chain, "built_program", None)  # it must not be called
    read = chain.chain_program(ONE)
    assert read is not built
    assert np.array_equal(read.words, built.words)
    assert (read.table, read.launch, read.regions) == (built.table, built.launch, built.regions)


def test_other_forms_have_other_keys() -> None:
    keys = {key_of(ARRAY.fabric, *form) for form in (("a", 1), ("a", 2), ("b", 1))}
    assert len(keys) == 3
    assert key_of(ARRAY.fabric, "a", 1) in keys
    assert key_of(arch.load_tile("vivid-16x16"), "a", 1) not in keys


def test_what_is_damaged_is_built_anew(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = chain.chain_program(ONE)
    key = key_of(ARRAY.fabric, "mine")
    write_program(key, program)
    assert read_program(key) is not None
    for file in (folder / "entries").iterdir():
        file.write_bytes(file.read_bytes()[:-5])
    monkeypatch.setattr(store, "warned", [])
    with pytest.warns(VividcWarning, match="product-.* is damaged; it is thrown away"):
        assert read_program(key) is None
    assert read_program("none") is None


@pytest.mark.parametrize("content", [b"", b"no zip", zlib.compress(b"no program")])
def test_what_is_no_program_is_thrown_away(
    folder: Path, monkeypatch: pytest.MonkeyPatch, content: bytes
) -> None:
    cache.write("product", "mine", content)
    monkeypatch.setattr(store, "warned", [])
    with pytest.warns(VividcWarning, match="holds no program"):
        assert read_program("mine") is None
    assert not list((folder / "entries").iterdir())


def test_a_program_copied_over_another_is_not_used(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = chain.chain_program(ONE)
    for file in (folder / "entries").iterdir():
        file.unlink()
    write_program("one", replace(program, name="one"))
    (one,) = (folder / "entries").iterdir()
    write_program("other", replace(program, name="other"))
    (other,) = {*(folder / "entries").iterdir()} - {one}
    other.write_bytes(one.read_bytes())
    monkeypatch.setattr(store, "warned", [])
    with pytest.warns(VividcWarning, match="is damaged"):
        assert read_program("other") is None
    kept = read_program("one")
    assert kept is not None
    assert kept.name == "one"


def test_without_a_cache_everything_is_built(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VIVIDC_CACHE_DIR", "")
    assert chain.chain_program(ONE).name == "gemm"
    assert read_program(key_of(ARRAY.fabric, "mine")) is None
