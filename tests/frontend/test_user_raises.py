"""What a kernel raises is raised by whoever runs it, with what was stored before."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import vividc
from tests.frontend.raising_kernels import SAYING, checked, helper, roots, through_a_helper, worded
from tests.fuzz.witnesses import run_regions, words_in_blocks
from vividc.dfg.cut.build import build_kernel
from vividc.errors import KernelRaised, SimulationError, SourceLoc, raised
from vividc.program import from_bytes
from vividc.ssa.interpret import interpret
from vividc.ssa.results import NONE, PLACE, Raise, Results
from vividc.ssa.rewrite.normalize import normalize
from vividc.ssa.text import parse, to_text


@pytest.mark.parametrize(
    ("function", "kind", "text", "home"),
    [
        (roots, ValueError, "a negative number, at x", roots),
        (checked, AssertionError, "too many", checked),
        (through_a_helper, OverflowError, "OverflowError", helper),
    ],
)
def test_all_witnesses_raise(
    function: Callable[..., object], kind: type[Exception], text: str, home: Callable[..., object]
) -> None:
    kernel = vividc.kernel("(float32[::1], int32)")(function)
    lowered = kernel.lower()
    assert parse(to_text(lowered)) == lowered
    program = words_in_blocks(lowered)
    assert from_bytes(program.to_bytes()) == program
    graphs = build_kernel(normalize(lowered))
    for n, bad in ((3, False), (5, True)):
        start = np.array([1, 4, 9, 16, -1, 2], np.float32)

        def simulated(x: np.ndarray, n: np.int32) -> object:
            return vividc.simulate(program, x, n).value

        def by_graphs(x: np.ndarray, n: np.int32) -> object:
            return run_regions(graphs, [x, n])

        def by_ssa(x: np.ndarray, n: np.int32) -> object:
            return interpret(lowered, x, n)

        theirs = start.copy()
        if not bad:
            expected = kernel(theirs, np.int32(n))
        else:
            with pytest.raises(kind):
                kernel(theirs, np.int32(n))
        for run in (simulated, by_graphs, by_ssa):
            mine = start.copy()
            if not bad:
                value = run(mine, np.int32(n))
                assert (value is None) is (expected is None)
                assert value is None or np.allclose(value, expected)
            else:
                with pytest.raises(kind, match=text) as caught:
                    run(mine, np.int32(n))
                assert isinstance(caught.value, SimulationError)
                assert isinstance(caught.value.loc, SourceLoc)
                assert caught.value.loc.line > home.__code__.co_firstlineno
            assert np.allclose(mine, theirs)


def test_a_raise_that_cannot_happen_costs_nothing() -> None:
    def first(x, n):
        if len(x) < 0:
            raise ValueError("never")
        return x[0]

    assert vividc.kernel("float32(float32[::1], int32)")(first).lower().results is None


@pytest.mark.parametrize("n", [2, 3, 4, 5])
def test_a_users_text_may_be_as_numbas_own(n: int) -> None:
    kernel = vividc.kernel("(float32[::1], int32)")(worded)
    program = from_bytes(words_in_blocks(kernel.lower()).to_bytes())
    expected: object = None
    try:
        kernel(np.zeros(1, np.float32), np.int32(n))
    except Exception as error:
        expected = error
    x = np.zeros(1, np.float32)
    if expected is None:
        assert vividc.simulate(program, x, n).value == n
    else:
        with pytest.raises(type(expected)) as caught:
            vividc.simulate(program, x, n)
        assert str(expected).strip() in str(caught.value)
        assert isinstance(caught.value, KernelRaised)
    assert x[0] == n


@pytest.mark.parametrize("kind", ["UnicodeDecodeError", "ExceptionGroup", "KeyError", "Own", "a b"])
def test_every_type_can_be_raised(kind: str) -> None:
    assert f"{kind}: text" in str(raised(kind, "text", None))


@pytest.mark.parametrize("function", SAYING)
@pytest.mark.parametrize("n", [-(2**40), -1, 3, 2**33 + 5])
def test_texts_say_the_numbers_of_the_run(function: Callable[..., object], n: int) -> None:
    kernel = vividc.kernel("(float32[::1], int64)")(function)
    lowered = kernel.lower()
    assert parse(to_text(lowered)) == lowered
    program = from_bytes(words_in_blocks(lowered).to_bytes())
    x = np.array([0.5, -1, 2, 3], np.float32)
    expected: object = None
    try:
        kernel(x, n)
    except Exception as error:
        expected = error
    assert expected is not None
    said = str(expected).replace("<object type:float32>", "2.0")
    for run in (vividc.simulate, lambda _, *given: interpret(lowered, *given)):
        with pytest.raises(type(expected)) as caught:
            run(program, x, n)
        assert said in str(caught.value)


@pytest.mark.parametrize(
    ("text", "numbers"), [("a", ("int",)), (f"a{PLACE}", ()), (f"a{PLACE}", ("str",))]
)
def test_a_text_that_does_not_fit_its_numbers_is_not_sound(
    text: str, numbers: tuple[str, ...]
) -> None:
    assert Raise("ValueError", "a").is_sound
    assert not Raise("ValueError", text, numbers=numbers).is_sound
    raises = (Raise("ValueError", text, numbers=numbers),)
    assert not Results((), (NONE,), error="e", made=("e",), raises=raises).is_sound
    assert Raise("ValueError", f"{PLACE}!", numbers=("int",)).said([]) == ""


def changed(x, n):
    text = f"n is {n}"
    n = n + 1
    if n > 3:
        raise ValueError(text)
    return n


def changed_in_a_loop(x, n):
    k = n
    for i in range(4):
        if x[i] > 1:
            k += 1
            raise ValueError(f"{k} at {i}")
    return k


@pytest.mark.parametrize(("function", "text"), [(changed, "n is 5"), (changed_in_a_loop, "6 at 2")])
def test_a_text_says_numbers_as_they_were(function: Callable[..., object], text: str) -> None:
    kernel = vividc.kernel("(float32[::1], int64)")(function)
    program = words_in_blocks(kernel.lower())
    x = np.array([0.5, -1, 2, 3], np.float32)
    for run in (kernel, lambda *given: vividc.simulate(program, *given)):
        with pytest.raises(ValueError, match=text):
            run(x, 5)


def stepping(x, n):
    total = np.float32(0)
    for i in range(0, len(x), n):
        total += x[i]
    return total + x[::n].sum()


def test_a_step_of_zero_is_raised_and_any_other_runs() -> None:
    kernel = vividc.kernel("(float32[::1], int32)")(stepping)
    program = words_in_blocks(kernel.lower())
    x = np.arange(7, dtype=np.float32)
    for n in (1, 2, 3, 10, -1, -2):
        assert vividc.simulate(program, x, n).value == kernel(x, np.int32(n))
    with pytest.raises(ValueError, match=r"range\(\) arg 3 must not be zero"):
        vividc.simulate(program, x, 0)


def picking(x, n):
    return (x[0], x[1], np.float32(4))[n]


def test_an_index_outside_of_a_tuple_is_an_error() -> None:
    kernel = vividc.kernel("(float32[::1], int32)")(picking)
    program = words_in_blocks(kernel.lower())
    x = np.arange(7, dtype=np.float32)
    for n in (0, 2, -1, -3):
        assert vividc.simulate(program, x, n).value == kernel(x, np.int32(n))
    for n in (3, -4):
        with pytest.raises(IndexError):
            kernel(x, np.int32(n))
        with pytest.raises(SimulationError, match="IndexError: tuple index out of range"):
            vividc.simulate(program, x, n)
