"""Inner loops as machine code do what Python does, or are refused."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import FunctionType
from typing import Annotated, Any, NamedTuple, cast

import numpy as np
import pytest
from numpy.typing import NDArray

import vividc
from vividc.host.machine_code import Compiler, door, inlined, shipped
from vividc.host.machine_code.origin import origin
from vividc.host.machine_code.unit import module_text

Ints = NDArray[np.int64]
Ints2 = Annotated[Ints, 2]
compiled = Compiler()
STEP, HALF = 3, 0.5


class Table(NamedTuple):
    """Arrays that travel together."""

    keys: Ints
    rows: Ints2
    marks: NDArray[np.uint8]
    prices: NDArray[np.float64]


class Scaled(NamedTuple):
    """A table in a tuple, and numbers."""

    table: Table
    factor: float
    is_up: bool


class Spot(NamedTuple):
    """Numbers only."""

    row: int
    column: int


@inlined
def quotients(a: int, b: int) -> tuple[int, int]:
    """Rounded down, whatever the signs."""
    return a // b, a % b


@inlined
def entered(table: Table, at: int, by: int) -> int:
    """Control flow of all kinds."""
    keys, rows = table.keys, table.rows
    if keys[at] % STEP == 0:
        return 0
    met = 0
    for step in range(1, 4):
        for other in range(at, max(0, at - step) - 1, -1):
            if keys[other] == keys[at] or not 1 < other <= at:
                continue
            quotient, rest = quotients(keys[other] - 7, step - 4)
            met += quotient * 5 - rest + (keys[other] < keys[at])
            if met > 10_000 and step == 2:
                break
        spot = Spot(row=at % rows.shape[0], column=step)
        row = rows[spot.row]
        row[spot.column] += met
    while met < 0:
        met += 1 << 4
    return met if at else -met


@compiled
def enter_all(scaled: Scaled, by: int) -> float:
    table, factor, is_up = scaled
    total, any_met = 0.0, False
    for key in table.keys:
        total = total + key / 4 - factor if is_up else total
    for at in range(len(table.keys)):
        met = entered(table, at, by)
        any_met = any_met or met > 2
        table.marks[at] |= met & 255
        table.marks[at] += 200
        table.prices[at] *= HALF
        table.prices[at] += math.log(1 + met % 100) * math.exp(-factor) - min(met, 3, at)
        total += max(table.prices[at], HALF)
    return total if any_met and bool(by ^ 5) else float(by)


@compiled
def mixed(numbers: Ints, count: int) -> int:
    """A linear congruential generator wraps."""
    for _ in range(count):
        numbers[0] = numbers[0] * 6364136223846793005 + 1442695040888963407
    return numbers[0] >> 33


@compiled
def bits_of(number: int) -> int:
    """Of a number, and the lowest that is set."""
    return 100 * number.bit_length() + (number & -number).bit_length()


@compiled
def is_ascending(numbers: Ints) -> bool:
    """With a return in a loop."""
    for at in range(len(numbers) - 1):  # noqa: SIM110 # generators are not compiled
        if numbers[at] > numbers[at + 1]:
            return False
    return True


def scaled_of(seed: int, *, is_up: bool) -> Scaled:
    rng = np.random.default_rng(seed)
    keys = rng.integers(-1000, 1000, 200)
    marks = rng.integers(0, 256, 200).astype(np.uint8)
    table = Table(keys, np.zeros((7, 4), dtype=np.int64), marks, rng.random(200))
    return Scaled(table, 0.75, is_up)


def python(function: Callable[..., object]) -> FunctionType:
    return cast(FunctionType, getattr(function, "py_func"))  # noqa: B009


@pytest.mark.filterwarnings("ignore:overflow")
@pytest.mark.parametrize("is_up", [False, True])
def test_machine_code_does_what_python_does(is_up: bool) -> None:
    ours, expected = scaled_of(1, is_up=is_up), scaled_of(1, is_up=is_up)
    for by in (3, 5):
        assert enter_all(ours, by) == python(enter_all)(expected, by)
    for one, other in zip(ours.table, expected.table, strict=True):
        assert one.dtype == other.dtype
        assert np.array_equal(one, other)
    assert ours.table.rows.any()


def test_integers_wrap_and_shift_with_their_sign() -> None:
    numbers, state = np.array([12345]), 12345
    for _ in range(5):
        state = (state * 6364136223846793005 + 1442695040888963407 + 2**63) % 2**64 - 2**63
    assert mixed(numbers, 5) == state >> 33
    assert numbers[0] == state


@pytest.mark.parametrize("number", [0, 1, 6, -6, 255, -256, 1 << 40, (1 << 62) + 8, -(1 << 62)])
def test_bits_are_counted_as_python_does(number: int) -> None:
    assert bits_of(number) == python(bits_of)(number)


def test_results_are_of_their_type() -> None:
    assert is_ascending(np.arange(5)) is True
    assert is_ascending(np.array([1, 3, 2])) is False
    assert is_ascending(np.zeros(0, dtype=np.int64)) is True


def test_threads_do_not_share_results() -> None:
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda k: mixed(np.array([k]), 20_000), range(16)))
    assert found == [mixed(np.array([k]), 20_000) for k in range(16)]


@pytest.mark.parametrize(
    "numbers",
    [
        np.arange(5.0),
        np.arange(5, dtype=np.int32),
        np.zeros((2, 2), dtype=np.int64),
        np.arange(10)[::2],
        np.frombuffer(bytes(16), dtype=np.int64),
    ],
    ids=["dtype", "width", "rank", "strides", "read-only"],
)
def test_an_array_that_is_not_what_was_said_is_refused(numbers: Any) -> None:
    with pytest.raises(TypeError):
        is_ascending(numbers)


def test_what_a_function_calls_is_in_its_module_once() -> None:
    text = module_text([python(enter_all)])
    assert text.count("define ") == 4  # with the one that Python calls
    assert text.count('call i64 @"') == 1
    assert text.count("}, ptr") == 0  # tuples with arrays go by address


def refused_else(a: Ints) -> int:
    for key in a:
        if key:
            break
    else:
        return 1
    return 0


def refused_call(a: Ints) -> int:
    return int(np.sum(a))


def refused_type(a: Ints) -> int:
    x = 1
    x = 0.5
    return int(x)


def refused_statement(a: Ints) -> int:
    with open(os.devnull):
        return 1


def refused_annotation(a: list[int]) -> int:
    return 1


def refused_power(a: Ints) -> int:
    return int(a[0] ** 2)


def refused_rank(a: Ints) -> int:
    return int(a[0, 1])


def refused_float_division(a: Ints) -> float:
    return 1.5 // a[0]


def refused_step(a: Ints) -> int:
    for at in range(0, 5, len(a)):
        return at
    return 0


@pytest.mark.parametrize("name", [name for name in globals() if name.startswith("refused_")])
def test_what_is_not_compiled_is_refused(name: str) -> None:
    function = globals()[name]
    unit = Compiler()
    unit(function)
    with pytest.raises(TypeError):
        unit.prepare()


def test_a_refusal_says_where() -> None:
    unit = Compiler()
    unit(refused_power)
    line = refused_power.__code__.co_firstlineno + 1
    with pytest.raises(TypeError, match=rf"{Path(__file__).name}, refused_power, line {line}: Pow"):
        unit.prepare()


def test_indices_can_be_checked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(door, "CHECKED", True)

    def third(a: Ints) -> int:
        return a[2]

    def last(a: Ints) -> int:
        return a[-1]

    for function, length, fails in ((third, 3, False), (third, 2, True), (last, 3, True)):
        checked = Compiler()(function)
        if fails:
            with pytest.raises(IndexError):
                checked(np.arange(length))
        else:
            assert checked(np.arange(length)) == 2


def test_what_is_made_soon_is_optimised_once_that_is_worth_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("VIVIDC_CACHE_DIR", str(tmp_path))

    def cubes(a: Ints, factor: float) -> float:
        found = 0.0
        for item in a:
            found += factor * item * item * item
        return found

    unit = Compiler(soon=True)
    run, numbers = unit(cubes), np.arange(9)
    expected = cubes(numbers, 0.1)
    assert run(numbers, 0.1) == expected
    unit.spent(1.5)
    assert unit.is_quick
    unit.spent(1.0)
    assert not unit.is_quick
    assert run(numbers, 0.1) == expected

    later = Compiler(soon=True)
    assert later(cubes)(numbers, 0.1) == expected
    assert not later.is_quick, "optimised code is in the cache"


def test_what_comes_with_an_installation_is_not_compiled(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("VIVIDC_CACHE_DIR", str(tmp_path / "cache"))

    def squares(a: Ints) -> int:
        found = 0
        for item in a:
            found += item * item
        return found

    def cubes(a: Ints) -> int:
        found = 0
        for item in a:
            found += item * item * item
        return found

    ships = Compiler()
    ships(squares)
    folder = tmp_path / "objects"
    made = ships.portable()
    shipped.write(folder, made)
    monkeypatch.setattr(shipped, "FOLDER", folder)
    monkeypatch.setattr(door, "optimised", None)
    monkeypatch.setattr(door, "quickly", None)

    unit = Compiler(soon=True)
    run, numbers = unit(squares), np.arange(9)
    assert run(numbers) == 204
    assert not unit.is_quick
    with pytest.raises(TypeError, match="not callable"):  # another text: it has to be compiled
        Compiler()(cubes)(numbers)
    for file in folder.iterdir():
        file.write_bytes(file.read_bytes()[:-1])
    assert not any(map(shipped.read, made))
    shipped.write(folder, {})
    assert not list(folder.iterdir())
    assert Compiler()(squares)(numbers) == 204, "it is in the cache by now"


@pytest.mark.parametrize("missing", ["text", "origin"])
def test_what_comes_with_an_installation_is_found_in_two_ways(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, missing: str
) -> None:
    monkeypatch.setenv("VIVIDC_CACHE_DIR", str(tmp_path / "cache"))

    def squares(a: Ints) -> int:
        found = 0
        for item in a:
            found += item * item
        return found

    ships = Compiler()
    ships(squares)
    made = ships.portable()
    (text,) = (name for name in made if "define" in name)
    left = {name: code for name, code in made.items() if (name == text) is (missing == "origin")}
    shipped.write(tmp_path / "objects", left)
    monkeypatch.setattr(shipped, "FOLDER", tmp_path / "objects")
    monkeypatch.setattr(door, "optimised", None)
    if missing == "text":  # nor is it written
        monkeypatch.setattr(door, "module_text", None)
    assert Compiler()(squares)(np.arange(9)) == 204


def test_threads_go_on_while_one_optimises(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("VIVIDC_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(door, "WORTH_S", 0.0)

    def total(a: Ints) -> int:
        found = 0
        for item in a:
            found += item
        return found

    run = Compiler(soon=True)(total)
    with ThreadPoolExecutor(4) as pool:
        assert set(pool.map(run, [np.arange(100)] * 200)) == {4950}


LOOPS = """
from typing import NamedTuple
import numpy as np
from numpy.typing import NDArray
from vividc.host.machine_code import Compiler, inlined

compiled = Compiler()
WEIGHT = 10

class Row(NamedTuple):
    items: NDArray[np.int64]
    scale: int

@inlined
def weighted(row: Row, at: int) -> int:
    return row.items[at] * row.scale * WEIGHT

@compiled
def total(row: Row) -> int:
    found = 0
    for at in range(len(row.items)):
        found += weighted(row, at)
    return found

@compiled
def doubled(row: Row) -> int:
    return 2 * total(row)
"""
PROCESS = """
import importlib, json, sys, types, warnings
vividc = sys.modules["vividc"] = types.ModuleType("vividc")  # the whole takes seconds
vividc.__path__ = [sys.argv[1]]
sys.path.insert(0, sys.argv[2])
sys.dont_write_bytecode = True
import numpy as np, loops
from vividc.host.machine_code import door
made = []
optimised = door.optimised
door.optimised = lambda *text, **how: made.append(1) or optimised(*text, **how)
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    row = loops.Row(np.arange(4), 1)
    found = [loops.doubled(row), loops.total(row)]
assert "numba" not in sys.modules
print(json.dumps([found, len(made), [str(warning.message) for warning in said]]))
"""


def run(folder: Path) -> Any:
    """Results, modules compiled, and warnings, in a process of its own."""
    script = [sys.executable, "-c", PROCESS, vividc.__path__[0], str(folder)]
    env = {**os.environ, "PYTHONHASHSEED": "random", "VIVIDC_CACHE_DIR": str(folder / "cache")}
    done = subprocess.run(script, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_code_is_kept_for_what_it_was_made_from_and_damage_is_made_anew(tmp_path: Path) -> None:
    file = tmp_path / "loops.py"
    file.write_text(LOOPS)
    assert run(tmp_path) == [[120, 60], 1, []]
    assert run(tmp_path) == [[120, 60], 0, []]
    (entry,) = (tmp_path / "cache" / "entries").iterdir()
    file.write_text(LOOPS.replace("WEIGHT = 10", "WEIGHT = 100"))
    assert run(tmp_path) == [[1200, 600], 1, []]
    content = bytearray(entry.read_bytes())
    content[len(content) // 2] ^= 16
    entry.write_bytes(content)
    file.write_text(LOOPS)
    found, made, said = run(tmp_path)
    assert (found, made, len(said)) == ([120, 60], 1, 1)
    assert "is damaged; it is thrown away and made again" in said[0]


def origin_of(text: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """That of functions as they are written in a file."""
    file = folder / "loops.py"
    file.write_text(text)
    spec = spec_from_file_location("loops", file)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "loops", module)
    exec(compile(text, file, "exec"), vars(module))
    return origin([module.doubled.py_func])


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("WEIGHT = 10", "WEIGHT = 11"),
        ("WEIGHT = 10", "WEIGHT = 10.0"),
        ("* WEIGHT", "+ WEIGHT"),
        ("return 2 *", "return 3 *"),
        ("scale: int", "scale: float"),
        ("np.int64", "np.uint8"),
        ("row: Row, at: int) -> int", "row: Row, at: int) -> float"),
        ("import numpy", "import math\nimport numpy"),
    ],
)
def test_code_that_would_be_another_is_looked_for_under_another_key(
    old: str, new: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = origin_of(LOOPS, tmp_path, monkeypatch)
    assert old in LOOPS
    after = origin_of(LOOPS.replace(old, new, 1), tmp_path, monkeypatch)
    assert (after != before) == ("math" not in new), "what does not matter does not count"
