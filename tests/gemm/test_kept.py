"""Programs of products that are kept in the user's cache."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vividc import arch
from vividc.gemm import chain
from vividc.gemm.kept import key_of, read_program, write_program
from vividc.mapper.systolic import SystolicArray

ARRAY = SystolicArray.of(arch.load_tile("vivid-8x8"))
ONE = chain.Chain(ARRAY, (chain.Link(3, 1, relu=True),), 2)


@pytest.fixture(autouse=True)
def folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.setenv("VIVIDC_CACHE_DIR", str(tmp_path))
    chain._program.cache_clear()
    return tmp_path


def test_a_program_is_built_once(monkeypatch: pytest.MonkeyPatch) -> None:
    built = chain.chain_program(ONE)
    chain._program.cache_clear()
    monkeypatch.setattr(chain, "_built", None)  # it must not be called
    read = chain.chain_program(ONE)
    assert read is not built
    assert np.array_equal(read.words, built.words)
    assert (read.table, read.launch, read.regions) == (built.table, built.launch, built.regions)


def test_other_forms_have_other_keys() -> None:
    keys = {key_of(ARRAY.fabric, *form) for form in (("a", 1), ("a", 2), ("b", 1))}
    assert len(keys) == 3
    assert key_of(ARRAY.fabric, "a", 1) in keys
    assert key_of(arch.load_tile("vivid-16x16"), "a", 1) not in keys


def test_what_is_damaged_is_built_anew(folder: Path) -> None:
    program = chain.chain_program(ONE)
    key = key_of(ARRAY.fabric, "mine")
    write_program(key, program)
    assert read_program(key) is not None
    for file in (folder / "native").glob(f"{key}*"):
        file.write_bytes(file.read_bytes()[:-5])
    assert read_program(key) is None
    assert read_program("none") is None


def test_without_a_cache_everything_is_built(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VIVIDC_CACHE_DIR", "")
    assert chain.chain_program(ONE).name == "gemm"
    assert read_program(key_of(ARRAY.fabric, "mine")) is None
