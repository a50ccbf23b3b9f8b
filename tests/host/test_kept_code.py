"""Code kept between processes is what the function in memory compiles to, or is made anew."""

from __future__ import annotations

import enum
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np
import pytest
from numba.core.registry import cpu_target

import vividc
from vividc.host import kept_code, made_of, store

LOOPS = """
from typing import NamedTuple
import numpy as np
from vividc.host.machine_code import compiler, inlined

WEIGHT = 10

class Row(NamedTuple):
    items: np.ndarray
    scale: int

@inlined
def weighted(row, at):
    return row.items[at] * row.scale * WEIGHT

@compiler(__file__)
def total(row):
    found = 0
    for at in range(len(row.items)):
        found += weighted(row, at)
    return found

@compiler(__file__)
def doubled(row):
    return 2 * total(row)

@compiler(__file__)
def both(row):
    return (total(row), 1)
"""
PROCESS = """
import importlib, json, sys, types, warnings
from pathlib import Path
vividc = sys.modules["vividc"] = types.ModuleType("vividc")  # the whole takes seconds
vividc.__path__ = [sys.argv[1]]
sys.path.insert(0, sys.argv[2])
sys.dont_write_bytecode = True
import numpy as np, loops
from vividc.host.made_of import made_of

def run(names):
    row = loops.Row(np.arange(4), 1)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        found = {name: getattr(loops, name)(row) for name in names}
    made = {name: sum(getattr(loops, name)._cache_misses.values()) for name in names}
    return [found, made, [str(warning.message) for warning in said]]

print(json.dumps([made_of(loops.total.py_func), *map(run, json.loads(sys.argv[3]))]))
if len(sys.argv) > 4:
    file = Path(loops.__file__)
    file.write_text(file.read_text().replace("WEIGHT = 10", "WEIGHT = 100"))
    importlib.reload(loops)
    print(json.dumps([made_of(loops.total.py_func), run(["total", "doubled"])]))
"""


def run(folder: Path, *turns: list[str], edit: bool = False) -> list[Any]:
    """Results, functions compiled, and warnings of calls in a process of their own."""
    script = [sys.executable, "-c", PROCESS, vividc.__path__[0], str(folder), json.dumps(turns)]
    seeded = {**os.environ, "PYTHONHASHSEED": "random", "NUMBA_CACHE_DIR": str(folder / "numba")}
    seeded["VIVIDC_CACHE_DIR"] = str(folder / "cache")
    done = subprocess.run(
        [*script, *["edit"] * edit], env=seeded, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


def test_code_is_kept_for_the_function_in_memory_and_damage_is_made_anew(tmp_path: Path) -> None:
    (tmp_path / "loops.py").write_text(LOOPS)
    ((made, cold, other),) = run(tmp_path, ["doubled"], ["both"])
    assert cold == [{"doubled": 120}, {"doubled": 1}, []]
    assert other == [{"both": [60, 1]}, {"both": 1}, []]  # its type of result is not kept
    assert not (tmp_path / "numba").exists()
    assert not list(tmp_path.rglob("*.nb*"))
    entries = sorted((tmp_path / "cache" / "entries").iterdir())
    assert len(entries) == 2
    (again, warm, linked), (edited, new) = run(tmp_path, ["total", "doubled"], ["both"], edit=True)
    assert again == made
    assert warm == [{"total": 60, "doubled": 120}, {"total": 0, "doubled": 0}, []]
    assert linked == [{"both": [60, 1]}, {"both": 1}, []]  # a caller of code that was loaded
    assert edited != made
    assert new == [{"total": 600, "doubled": 1200}, {"total": 1, "doubled": 1}, []]
    for entry in entries:  # as compiled before the edit
        content = bytearray(entry.read_bytes())
        content[len(content) // 2] ^= 16
        entry.write_bytes(content)
    (tmp_path / "loops.py").write_text(LOOPS)
    ((_, repaired),) = run(tmp_path, ["total", "doubled"])
    found, compiled, said = repaired
    assert found == {"total": 60, "doubled": 120}
    assert compiled["doubled"] == 1
    assert len(said) == 1
    assert "is damaged; it is thrown away and made again" in said[0]


def test_an_entry_of_another_form_is_thrown_away(monkeypatch: pytest.MonkeyPatch) -> None:
    """The store vouches for who wrote it, and this for what it is."""
    monkeypatch.setattr(store, "warned", [])

    def one() -> int:
        return 1

    code = kept_code.KeptCode(one, "stamp")
    for content in (b"", b"{}\ncode", b"\xff\n", b"[]", b'{"bytes": 3}\nabc'):
        monkeypatch.setattr(vividc.host.cache, "read", lambda *_, content=content: content)
        thrown = []
        monkeypatch.setattr(
            vividc.host.cache, "discard", lambda *of, thrown=thrown: thrown.append(of)
        )
        assert code.load_overload((), cpu_target.target_context) is None
        assert len(thrown) == 1


class Colour(enum.Enum):
    RED = 1


class Pair(NamedTuple):
    a: int
    b: int


def returning(value: Any) -> Callable[[], Any]:
    def read() -> Any:
        return value

    return read


def calling(function: Callable[..., Any]) -> Callable[[], Any]:
    def call() -> Any:
        return function()

    return call


def written(text: str, **names: object) -> FunctionType:
    """A function `f` over globals of other files."""
    space: dict[str, Any] = {"__name__": "somewhere", **names}
    exec(text, space)
    return space["f"]  # type: ignore[no-any-return]


class Reversed(NamedTuple):
    b: int
    a: int


Reversed.__qualname__ = "Pair"
READ = "def f(): return A"
DIFFERENT = [
    (returning(1), returning(2)),
    (returning(1), returning(1.0)),
    (returning(1), returning(np.int64(1))),
    (returning(0.0), returning(-0.0)),
    (returning((1, 2)), returning((2, 1))),
    (returning(Pair), returning(Reversed)),
    (returning(np.array([1, 2])), returning(np.array([1, 3]))),
    (returning(np.arange(2000)), returning(np.arange(2000)[::-1])),
    (returning(np.zeros((2, 3))), returning(np.zeros((3, 2)))),
    (returning(np.zeros((2, 3))), returning(np.asfortranarray(np.zeros((2, 3))))),
    (calling(returning(1)), calling(returning(2))),
    (calling(calling(returning(1))), calling(calling(returning(2)))),
    (written(READ, A=1), written(READ, A=2)),
    (written("def f(): return 1"), written("def f(): return 2")),
    (written("def f(): return 1"), written("def f(): return True")),
    (written("def f(x): return x + 1"), written("def f(x): return x - 1")),
    (written("def f(x=1): return x"), written("def f(x=2): return x")),
    (written("def f(*, x=1): return x"), written("def f(*, x=2): return x")),
    (
        written("def f(x=A): return x", A=np.arange(2000)),
        written("def f(x=A): return x", A=np.arange(2000) // 1000 * 1000),
    ),
    (
        written("def f(): return FS[0]()", FS=(returning(1),)),
        written("def f(): return FS[0]()", FS=(returning(2),)),
    ),
    (written("def f(x, y): return x"), written("def f(y, x): return x")),
    (written("def f(): return min(1, 2)"), written("def f(): return max(1, 2)")),
    (
        written("def f(): return g()", g=returning(1)),
        written("def f(): return g()", g=returning(2)),
    ),
    (
        written("def f(): return [A for _ in ()]", A=1),
        written("def f(): return [A for _ in ()]", A=2),
    ),
    (
        written("def f(): return C.RED.value", C=Colour),
        written("def f(): return C.RED.value", C=enum.Enum("Colour", {"RED": 2})),
    ),
]


@pytest.mark.parametrize(("one", "other"), DIFFERENT)
def test_functions_that_differ_somewhere_are_told_apart(
    one: FunctionType, other: FunctionType
) -> None:
    assert made_of.made_of(one) == made_of.made_of(one)
    assert made_of.made_of(one) != made_of.made_of(other)


def test_a_constant_of_a_module_counts() -> None:
    other = type(sys)("other")
    function = written("def f(): return other.A", other=other)
    hashes = set()
    for value in (1, 2):
        other.A = value  # type: ignore[attr-defined]
        hashes.add(made_of.made_of(function))
    assert len(hashes) == 2


def test_a_constant_of_a_module_in_a_module_counts() -> None:
    outer, inner = type(sys)("outer"), type(sys)("inner")
    outer.inner, inner.outer = inner, outer  # type: ignore[attr-defined]
    function = written("def f(): return outer.inner.A", outer=outer)
    hashes = set()
    for value in (1, 2):
        inner.A = value  # type: ignore[attr-defined]
        hashes.add(made_of.made_of(function))
    assert len(hashes) == 2


def test_functions_that_call_each_other_have_a_hash() -> None:
    space: dict[str, Any] = {"__name__": "somewhere"}
    exec("def f(n): return g(n)\ndef g(n): return f(n)", space)
    assert made_of.made_of(space["f"]) != made_of.made_of(space["g"])
