"""Each kind of advice, followed: the simulated cycles fall, and it is not given again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest
from numba import prange

import vividc
from tests.marks import with_slow
from vividc import LoopOptions, arch
from vividc.compiler.advice.advise import LEAST_GAIN, Hint, advise
from vividc.mapper import EffortLevel

F = np.float32


@vividc.kernel("float32(float32[::1], float32[::1])")
def dot(x, y):
    """A sum of floats."""
    total = F(0.0)
    for i in range(len(x)):
        total += x[i] * y[i]
    return total


@vividc.kernel("void(float32[::1], float32[::1], float32[::1])")
def sum_of_products(x, y, out):
    """A product and a sum that are one operation, on a chain from iteration to iteration."""
    total = F(0.0)
    for i in range(len(x)):
        total = total * x[i] + y[i]
        out[i] = total


@vividc.kernel("void(float32[:, ::1], float32[::1])")
def rowsums(a, y):
    """Sums of rows."""
    for i in range(a.shape[0]):
        total = F(0.0)
        for j in range(a.shape[1]):
            total += a[i, j]
        y[i] = total


@vividc.kernel("void(float32[:, ::1], float32[::1])")
def columnsums(a, y):
    """Sums of columns, a row at a time."""
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            y[j] += a[i, j]


@vividc.kernel("void(float32[:, ::1], float32[::1])")
def fractions(a, y):
    """Continued fractions of rows."""
    for i in range(a.shape[0]):
        total = F(1.0)
        for j in range(a.shape[1]):
            total = a[i, j] + F(1.0) / total
        y[i] = total


@vividc.kernel("void(float32[:, ::1], float32[::1])")
def fractions_in_parallel(a, y):
    """The same on all tiles."""
    for i in prange(a.shape[0]):
        total = F(1.0)
        for j in range(a.shape[1]):
            total = a[i, j] + F(1.0) / total
        y[i] = total


@vividc.kernel("void(float32[::1], float32[::1])")
def doubled(x, y):
    """A loop that pays to unroll."""
    for i in range(len(x)):
        y[i] = F(2.0) * x[i]


@vividc.kernel("void(float32[::1], float32[::1], float32[::1])")
def running(x, y, z):
    """A long chain, and behind it a loop that is a small part of the time."""
    total = F(0.0)
    for i in range(len(x)):
        total = (total * x[i] + y[i]) * y[i]
        z[i] = total
    for i in range(len(x)):
        y[i] = F(2.0) * x[i]


@vividc.kernel("void(float32[::1], float32[::1], int32[::1])")
def scattered(x, y, places):
    """Reads in order what it writes anywhere."""
    for i in range(len(y)):
        x[places[i]] = x[i] * F(2.0) + y[i]


@vividc.kernel("void(float32[::1], float32[::1], float32[::1], int32[::1])")
def gathered(x, read, y, places):
    """The same with what it reads in an array of its own."""
    for i in range(len(y)):
        x[places[i]] = read[i] * F(2.0) + y[i]


@vividc.kernel("void(float32[::1], float32[::1], int64)")
def strided(x, y, n):
    """A division of 64-bit integers."""
    for i in range(len(y)):
        y[i] = x[(i * 7) % n]


@vividc.kernel("void(float32[::1], float32[::1], int64)")
def strided_in_words(x, y, n):
    """The same of 32-bit ones."""
    for i in range(len(y)):
        y[i] = x[np.int32(np.int32(i * 7) % np.int32(n))]


@vividc.kernel("void(int32[::1], int32[::1])")
def counted(bins, places):
    """A histogram."""
    for i in range(len(places)):
        bins[places[i]] += 1


@vividc.kernel("void(float32[:, ::1], int32[::1], float32[::1])")
def roots_in_parallel(x, lengths, y):
    """Rows that end by themselves, side by side."""
    for i in prange(len(y)):
        total = F(0.0)
        for j in range(lengths[i]):
            total = total * F(0.5) + x[i, j]
        y[i] = total


@vividc.kernel("void(float32[::1], int32[::1], int32[::1], float32[::1])")
def segments(x, lengths, places, y):
    """Iterations over `prange` that nothing proves to be independent."""
    for i in prange(len(lengths)):
        total = F(0.0)
        for j in range(lengths[i]):
            total = total * F(0.5) + x[i + j]
        y[places[i]] = total


def _floats(*shape: int) -> Any:
    return np.linspace(0.5, 1.5, int(np.prod(shape)), dtype=F).reshape(shape)


def _lengths(count: int, most: int) -> Any:
    return (np.arange(count, dtype=np.int32) * 5) % most + 1


@dataclass(frozen=True)
class Case:
    """A hint that a kernel gets for an option or a change of its source, and how it is followed.

    Attributes
    ----------
    given, then
        Keywords of `compile` before and after.
    changed, args_then
        Another source, and its arguments if they are others.
    exact
        What it computes stays the same.
    spread
        The accelerator on whose tiles it then runs.
    """

    option: str
    kernel: Any
    args: Callable[[], tuple[Any, ...]]
    action: str = ""
    given: dict[str, Any] = field(default_factory=dict)
    then: dict[str, Any] | Callable[[Hint], dict[str, Any]] = field(default_factory=dict)
    changed: Any = None
    args_then: Callable[[], tuple[Any, ...]] | None = None
    exact: bool = True
    spread: str | None = None


def _matrix() -> tuple[Any, ...]:
    return _floats(24, 24), np.zeros(24, F)


def _rows() -> tuple[Any, ...]:
    return _floats(24, 32), _lengths(24, 30), np.zeros(24, F)


def _pair() -> tuple[Any, ...]:
    return _floats(256), np.zeros(256, F)


def _scattered() -> tuple[Any, ...]:
    return _floats(64), _floats(32), np.arange(32, 64, dtype=np.int32)


def _gathered() -> tuple[Any, ...]:
    x, y, places = _scattered()
    return x, x.copy(), y, places


def _chain() -> tuple[Any, ...]:
    return _floats(200), _floats(200), np.zeros(200, F)


def _strided() -> tuple[Any, ...]:
    return _floats(100), np.zeros(64, F), 100


def _segments() -> tuple[Any, ...]:
    return _floats(64), _lengths(24, 30), np.arange(24, dtype=np.int32), np.zeros(24, F)


def _long_matrix() -> tuple[Any, ...]:
    return _floats(256, 24), np.zeros(256, F)


def _unrolled(hint: Hint) -> dict[str, Any]:
    line, factor = map(int, hint.option.removeprefix("--unroll ").split("="))
    return {"loops": LoopOptions(unroll={line: factor})}


def _threaded(hint: Hint) -> dict[str, Any]:
    return {"loops": LoopOptions(threads=int(hint.option.removeprefix("--threads ")))}


ALONE = {"loops": LoopOptions(unroll={doubled.line + 3: 1})}
SLOW_FMA = {
    "fabric": arch.load_text(arch.load("vivid-tile").source.replace("fma: 4", "fma: 8"), "slow-fma")
}
PLAIN = {"loops": LoopOptions(auto=False)}
UNSTRUCTURED = {"loops": LoopOptions(restructure=False)}
RESTRUCTURED = {"loops": LoopOptions(restructure=True)}
CASES = {
    "reassociate": Case(
        "--reassociate",
        dot,
        lambda: (_floats(256), _floats(256)),
        then={"reassociate": True},
        exact=False,
    ),
    "contract": Case("--contract", sum_of_products, _chain, given={"contract": False}, exact=False),
    "no contract": Case(
        "--no-contract",
        dot,
        lambda: (_floats(256), _floats(256)),
        given=SLOW_FMA,
        then={**SLOW_FMA, "contract": False},
        exact=False,
    ),
    "one thread": Case(
        "--transform",
        roots_in_parallel,
        _rows,
        "leave out --threads",
        given={"loops": LoopOptions(threads=1)},
    ),
    "tiles": Case(
        "",
        fractions,
        _long_matrix,
        "write prange",
        given={"fabric": "vivid", **UNSTRUCTURED},
        then={"fabric": "vivid", **UNSTRUCTURED},
        changed=fractions_in_parallel,
        spread="vivid",
    ),
    "transform": Case("--transform", rowsums, _matrix, given=PLAIN),
    "restructure": Case(
        "--restructure", columnsums, _matrix, given=UNSTRUCTURED, then=RESTRUCTURED
    ),
    "sizes": Case(
        "--sizes a=24x24,y=24",
        columnsums,
        _matrix,
        given=UNSTRUCTURED,
        then={**UNSTRUCTURED, "like": _matrix()},
    ),
    "unroll": Case("--unroll", running, _chain, "unroll by", then=_unrolled),
    "left alone": Case("--transform", doubled, _pair, "leave out --unroll", given=ALONE),
    "threads": Case("--threads 8", segments, _segments, then=_threaded),
    "arrays": Case(
        "", scattered, _scattered, "read x from an array of its own", {}, {}, gathered, _gathered
    ),
    "int32": Case("", strided, _strided, "compute in 32 bits", changed=strided_in_words),
}


def _run(
    kernel: Any, args: tuple[Any, ...], options: dict[str, Any], spread: str | None = None
) -> tuple[int, list[Any]]:
    program = vividc.compile(kernel, **options)
    arrays = [arg for arg in args if isinstance(arg, np.ndarray)]
    if spread is not None:
        return vividc.simulate(program, *args, fabric=spread).cycles, [*arrays, np.asarray(None)]
    result = vividc.simulate(program, *args)
    return result.cycles, [*arrays, np.asarray(result.value)]


def _of(hints: tuple[Hint, ...], case: Case) -> list[Hint]:
    return [
        h for h in hints if h.option.startswith(case.option) and h.action.startswith(case.action)
    ]


_ADVICE: dict[tuple[str, str], tuple[Hint, ...]] = {}


def _advice(kernel: Any, given: dict[str, Any]) -> tuple[Hint, ...]:
    """What is advised, found once: beside other work, too, the clock cuts nothing short."""
    key = kernel.name, repr(given)
    if key not in _ADVICE:
        with vividc.patient(20.0):
            _ADVICE[key] = advise(kernel, **given)
    return _ADVICE[key]


@pytest.mark.parametrize("name", with_slow(CASES, {"tiles", "restructure"}))
def test_following_it_saves_cycles(name: str) -> None:
    case = CASES[name]
    hint, *_ = _of(_advice(case.kernel, case.given), case)
    with vividc.patient(20.0):
        _demand_savings(case, hint)


@pytest.mark.parametrize(
    "name", with_slow(CASES, {"restructure", "sizes", "threads", "tiles", "transform"})
)
def test_what_was_followed_is_not_advised_again(name: str) -> None:
    case = CASES[name]
    then = case.then
    if callable(then):
        hint, *_ = _of(_advice(case.kernel, case.given), case)
        then = then(hint)
    assert not _of(_advice(case.changed or case.kernel, then), case)


def _demand_savings(case: Case, hint: Hint) -> None:
    assert hint.after <= (1 - LEAST_GAIN) * hint.before
    assert hint.loc is None or hint.loc.line > case.kernel.line
    kernel = case.changed or case.kernel
    then = case.then(hint) if callable(case.then) else case.then
    before, as_it_was = _run(case.kernel, case.args(), case.given)
    after, as_it_is = _run(kernel, (case.args_then or case.args)(), then, case.spread)
    assert after < (1 - LEAST_GAIN) * before
    if case.exact and not case.args_then:
        assert all(map(np.array_equal, as_it_was, as_it_is))


@pytest.mark.parametrize("missing", [0, 2])
@pytest.mark.parametrize(("effort", "higher"), [("normal", "thorough"), ("thorough", "prove")])
def test_a_longer_search_may_save_what_is_not_refuted(
    missing: int, effort: EffortLevel, higher: str
) -> None:
    program = vividc.compile(dot, effort=effort)
    regions = tuple(
        replace(r, ii=r.ii + missing) if r.kind == "loop" else r for r in program.regions
    )
    hints = [h for h in advise(dot, program=replace(program, regions=regions)) if h.at_most]
    assert [h.option for h in hints] == [f"--effort {higher}"] * bool(missing)
    for hint in hints:
        assert hint.saved == 255 * missing  # of the 256 iterations that are assumed


def test_the_largest_saving_comes_first_and_small_ones_do_not_come() -> None:
    hints = _advice(columnsums, UNSTRUCTURED)
    assert [h.saved for h in hints] == sorted((h.saved for h in hints), reverse=True)
    assert len(hints) > 1
    assert all(h.saved >= LEAST_GAIN * h.before for h in hints)
    assert len({h.before for h in hints}) == 1


def test_histograms_are_not_told_to_read_from_another_array() -> None:
    """A store where a load came from is meant to be read again."""
    assert not [h for h in advise(counted) if "array of its own" in h.action]


def test_what_there_was_no_time_for_is_a_warning() -> None:
    with pytest.warns(vividc.VividcWarning, match="advice may be missing"):
        advise(rowsums, time_limit_s=1e-3, **RESTRUCTURED)
