"""Threads of a tile from the public API: both engines, all tiles, and what is refused."""

from __future__ import annotations

import importlib.util
from copy import deepcopy
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import vividc
from benchmarks.simd import WORKLOADS
from benchmarks.workloads import Workload
from vividc.errors import ArgumentError, KernelError

ROOT = Path(__file__).resolve().parents[2]


def workload(name: str) -> Workload:
    return next(item for item in WORKLOADS if item.name == name)


def _threads_module() -> ModuleType:
    spec = importlib.util.spec_from_file_location("threads", ROOT / "kernels" / "threads.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def words(program: vividc.Program, args: Any, **options: Any) -> list[bytes]:
    mine = deepcopy(args)
    vividc.simulate(program, *mine, **options)
    return [value.tobytes() for value in mine if isinstance(value, np.ndarray)]


@pytest.mark.parametrize("name", ["march", "escape_time", "fir_outputs"])
def test_threads_write_the_words_of_one(name: str) -> None:
    item = workload(name)
    args = item.fresh()
    one, four = (
        vividc.compile(
            item.kernel(),
            loops=vividc.LoopOptions(auto=False, threads=n),
            time_limit_s=20,
            effort="fast",
        )
        for n in (1, 4)
    )
    expected = words(one, args)
    assert words(four, args, engine="reference") == expected
    assert words(four, args, engine="native") == expected
    assert vividc.simulate(four, *deepcopy(args)).cycles < (
        vividc.simulate(one, *deepcopy(args)).cycles
    )
    chosen = [t for loop in four.loops for t in loop.transforms if t.chosen]
    assert [(t.kind, t.factor) for t in chosen] == [("threads", 4)]


def test_threads_on_all_tiles() -> None:
    kernel = _threads_module().escape_time
    args = list(workload("escape_time").fresh())
    program = vividc.compile(
        kernel, fabric="vivid", loops=vividc.LoopOptions(auto=False, threads=4), effort="fast"
    )
    expected = deepcopy(args)
    kernel(*expected)
    vividc.simulate(program, *args, fabric="vivid")
    np.testing.assert_array_equal(args[3], expected[3])


@pytest.mark.parametrize("threads", [0, 9, -1, True, 2.0, "4"])
def test_a_wrong_number_of_threads_is_refused(threads: Any) -> None:
    with pytest.raises(ArgumentError, match="threads cannot be"):
        vividc.compile(
            _threads_module().fir_outputs, loops=vividc.LoopOptions(threads=threads), effort="fast"
        )


def test_threads_need_a_parallel_loop() -> None:
    from_file = Workload("saxpy", lambda rng: ()).kernel()
    with pytest.raises(KernelError, match="no loop over prange") as caught:
        vividc.compile(from_file, loops=vividc.LoopOptions(threads=4), effort="fast")
    assert caught.value.loc is not None
    assert caught.value.loc.file.endswith("saxpy.py")
