"""Arrays whose size the launch decides, and what numba's functions raise."""

from __future__ import annotations

import itertools
from pathlib import Path
from random import Random

import numpy as np
import pytest

import vividc
from tests.fuzz.witnesses import judge, run_regions
from vividc.compiler.driver import lower
from vividc.errors import SimulationError
from vividc.frontend import KernelFunction
from vividc.frontend.ranges.formulas import shortened
from vividc.machine.params import Formula, LocalArray, evaluate_formula
from vividc.program import Program

LENGTHS = (0, 1, 2, 7, 16)


def shifted(x, y):
    made = x + np.float32(1)
    y[:] = made
    y[:1] = made[:1]


def best(x, y):
    y[0] = np.max(x)


def stretched(x, n):
    t = np.zeros(n * 3, np.float32)
    for i in range(n):
        t[3 * i] = x[i]
    for i in range(n):
        x[i] = t[i]


def compiled(function: object, signature: str) -> Program:
    return vividc.compile(
        KernelFunction(function, signature, None), time_limit_s=20.0, effort="fast"
    )


@pytest.fixture(scope="module")
def expression() -> Program:
    return compiled(shifted, "void(float32[::1], float32[::1])")


def test_a_formula_is_evaluated_in_postfix_order() -> None:
    inputs = {"n": 7, "m": 0xFFFFFFFF, "w": 5, "w.high": 1}
    assert evaluate_formula(("u:n", 3, "*", -1, "+"), inputs) == 20
    assert evaluate_formula(("s:m", "u:n", "max"), inputs) == 7
    assert evaluate_formula(("u:m", "u:n", "min", 2, "//"), inputs) == 3
    assert evaluate_formula(("s:w",), inputs) == (1 << 32) + 5


def test_a_negative_size_is_none() -> None:
    array = LocalArray("local0", 0, size=("s:n", 4, "*"))
    assert array.at_launch({"n": 0xFFFFFFFF}).words == 0
    assert array.at_launch({"n": 3}).words == 12


@pytest.mark.parametrize("length", LENGTHS)
def test_one_program_runs_on_all_lengths(expression: Program, length: int) -> None:
    x, y = np.arange(length, dtype=np.float32), np.zeros(length, np.float32)
    vividc.simulate(expression, x, y)
    np.testing.assert_array_equal(y, x + 1)


def test_the_size_survives_the_bundle(expression: Program, tmp_path: Path) -> None:
    expression.save(tmp_path / "k.vivid")
    again = vividc.load(tmp_path / "k.vivid")
    assert again.locals == expression.locals
    assert any(local.size for local in again.locals)


def test_arrays_of_launch_size_are_refused_where_they_do_not_fit() -> None:
    program = compiled(stretched, "void(float32[::1], int32)")
    with pytest.raises(vividc.VividcError, match="the scratchpad has"):
        vividc.simulate(program, np.zeros(4, np.float32), 5000)


def test_slices_of_different_sizes_end_the_simulation(expression: Program) -> None:
    y = np.zeros(4, np.float32)
    with pytest.raises(vividc.VividcError, match="raises ValueError: cannot assign slice"):
        vividc.simulate(expression, np.ones(3, np.float32), y)
    assert not y.any()


def test_what_may_be_raised_takes_one_address() -> None:
    """Of as many exceptions as there are, in as few entries of constant stores."""

    @vividc.kernel("void(float32[::1], float32[::1], float32[:, ::1])")
    def three(x, y, z):
        y[:] = x[1:] + x[:-1]
        z[:, :] = z[::-1] + x
        y[0] = x[2:].max()

    program = vividc.compile(three)
    raised = {name for name in program.stored_arrays if name.startswith("raise.")}
    assert len(raised) > 2
    assert {row.key for row in program.launch if "raise" in row.key} == {"&raise."}


def test_the_largest_of_nothing_ends_the_simulation() -> None:
    program = compiled(best, "void(float32[::1], float32[::1])")
    y = np.zeros(1, np.float32)
    vividc.simulate(program, np.array([1, 5, 2], np.float32), y)
    assert y[0] == 5
    with pytest.raises(vividc.VividcError, match="raises ValueError: zero size") as caught:
        vividc.simulate(program, np.zeros(0, np.float32), y)
    assert "test_launch_sizes.py" in str(caught.value)


def test_operands_of_where_that_do_not_fit_end_the_simulation() -> None:
    def chosen(x, y):
        x[:] = np.where(x > 0, x, y)

    program = compiled(chosen, "void(float32[::1], float32[::1])")
    x = -np.ones(3, np.float32)
    with pytest.raises(vividc.VividcError, match="raises ValueError: unable to broadcast"):
        vividc.simulate(program, x, np.zeros(4, np.float32))
    assert (x == -1).all()


@pytest.mark.parametrize(("sizes", "line"), [((3, 5, 4), 2), ((3, 3, 4), 3), ((3, 5, 2), 2)])
def test_of_two_statements_that_do_not_fit_the_first_ends_the_simulation(
    sizes: tuple[int, ...], line: int
) -> None:
    """Both raise in straight code, where what is stored between them comes after the first."""

    def assigned(x, y, z):
        x[:] = y
        x[1:] = z

    program = compiled(assigned, "void(float32[::1], float32[::1], float32[::1])")
    first = assigned.__code__.co_firstlineno
    arrays = [np.ones(size, np.float32) for size in sizes]
    for engine in ("native", "reference"):
        with pytest.raises(vividc.VividcError, match="raises ValueError: cannot assign") as caught:
            vividc.simulate(program, *arrays, engine=engine)
        assert f".py:{first + line - 1}:" in str(caught.value)


def counted_from_a_scalar(x, n):
    t = np.arange(n)
    x[0] = t.sum()
    x[1] = len(t)


def zeros_of_a_scalar(x, n):
    x[0] = np.zeros(n, np.float32).size  # here


def filled_from_a_difference(x, n):
    x[0] = np.full(n - 5, 3, np.int32).sum()  # here


def two_dimensions(x, n):
    x[0] = np.empty((2, n - 3), np.float32).size  # here


def constant(x, n):
    x[0] = np.zeros(-1, np.float32).size  # here


def test_a_range_of_a_negative_length_is_empty() -> None:
    program = compiled(counted_from_a_scalar, "void(float32[::1], int32)")
    for n in (-(2**31), -1, 0, 3):
        x = np.full(2, 9, np.float32)
        vividc.simulate(program, x, n)
        assert x.tolist() == [np.arange(n).sum(), max(n, 0)]


@pytest.mark.parametrize(
    "function", [zeros_of_a_scalar, filled_from_a_difference, two_dimensions, constant]
)
def test_negative_dimensions_are_told_with_their_line(function: object) -> None:
    program = compiled(function, "void(float32[::1], int32)")
    line = function.__code__.co_firstlineno + 1  # type: ignore[attr-defined]
    for n in (-(2**31), -1):
        with pytest.raises(SimulationError, match="negative dimensions not allowed") as error:
            vividc.simulate(program, np.zeros(2, np.float32), n)
        assert f"{Path(__file__).name}:{line}:" in str(error.value)


@pytest.mark.parametrize(
    "statement",
    [
        "x[::2] -= 3",
        "p[:, :0:-1] %= 255",
        "p[:0:-1, :0:-1] += n",
        "x[:0:-1] = ~x[:0:-1]",
        "x[1::3] += y[1::3]",
        "x[::-2] += y[-1::-2]",
        "for i in range(len(x)): x[:i] += y[:i]",
        "for i in range(2, len(x), 3): x[:i] += y[:i] * 2",
        "for i in range(len(x) - 1, -1, -1): x[i:] += y[: len(x) - i]",
        "for i in range(n & 15): x[: len(np.ones(i, np.int32))] += i",
    ],
)
def test_sizes_of_steps_and_counters_are_bounded(statement: str, tmp_path: Path) -> None:
    source = f"""
import numpy as np
from vividc.frontend import kernel
SHAPES = {{'x': ('L',), 'y': ('L',), 'p': ('L', 'M')}}
FIXED = False

@kernel("void(int32[::1], int32[::1], int32[:, ::1], int32)")
def program(x, y, p, n):
    {statement}
"""
    verdict = judge(source, 5, tmp_path, simulate="blocks")
    assert verdict.kind == "agrees", verdict.text


def every_second_in_place(x, n):
    x[::2] *= np.float32(2)


def half(x, n):
    y = np.zeros(len(x) // 2, np.float32)
    for i in range(len(y)):
        y[i] = x[2 * i]
    x[: len(y)] = y


def rounded_up(x, n):
    y = np.zeros((len(x) + 2) // 3, np.float32)
    y[:] = x[::3]
    x[: len(y)] = y + np.float32(np.zeros(n >> 1, np.float32).size)


def quotient_of_two(x, n):
    x[0] = np.zeros(n // len(x), np.float32).size


def from_a_variable(x, n):
    y = x[n::-2] + np.float32(3)
    x[: len(y)] = y


@pytest.mark.parametrize(
    "function", [every_second_in_place, half, rounded_up, quotient_of_two, from_a_variable]
)
def test_sizes_may_be_quotients(function: object) -> None:
    kernel = KernelFunction(function, "void(float32[::1], int32)", None)
    lowered = lower(kernel)
    for length in (1, 2, 3, 7, 8):
        for n in (-1, 0, 6) if function is from_a_variable else (0, 1, 6):
            x = np.arange(1, length + 1, dtype=np.float32)
            y = x.copy()
            kernel(x, n)
            run_regions(lowered, [y, np.int32(n)])
            np.testing.assert_array_equal(y, x)


def windows_of_a_width(x, n):
    y = np.zeros(len(x) - n + 1, np.float32)
    for i in range(len(y)):
        y[i] = np.sum(x[i : i + n])
    x[: len(y)] = y


def all_but_the_larger(x, n):
    y = np.zeros(len(x) - max(n, 2 - n), np.float32)
    y += 1
    x[: len(y)] += y


def grown_up_to_a_scalar(x, n):
    for k in range(1, n + 1):
        y = np.full(k, np.float32(k))
        x[0] += y.sum()


def grown_up_to_a_difference(x, n):
    for k in range(len(x) - n + 1):
        y = np.full(k, np.float32(k))
        x[0] += y.sum()


@pytest.mark.parametrize(
    "function",
    [windows_of_a_width, all_but_the_larger, grown_up_to_a_scalar, grown_up_to_a_difference],
)
def test_sizes_may_be_differences_of_shapes_and_scalars(function: object) -> None:
    for kind in ("int32", "int64", "uint8"):
        kernel = KernelFunction(function, f"void(float32[::1], {kind})", None)
        lowered = lower(kernel)
        for length, n in itertools.product((3, 7, 8), (1, 2, 3)):
            x = np.arange(1, length + 1, dtype=np.float32)
            y = x.copy()
            kernel(x, n)
            run_regions(lowered, [y, np.dtype(kind).type(n)])
            np.testing.assert_array_equal(y, x)


def masked(x, y):
    chosen = x[x > y[0]]
    y[1] = len(chosen)
    for i in range(len(chosen)):
        x[i] = chosen[i]


def stencil(x, y):
    y[1:-1, 1:-1] = (
        (x[2:, 1:-1] - np.float32(2) * x[1:-1, 1:-1] + x[:-2, 1:-1])
        + (x[1:-1, 2:] - np.float32(2) * x[1:-1, 1:-1] + x[1:-1, :-2])
        + (x[2:, 2:] - x[:-2, :-2] + x[2:, :-2] - x[:-2, 2:])
    )


def windows(x, y):
    n, m = y.shape
    wide = np.float32(4) * x[1 : n + 3, 1 : m + 3] - x[2 : n + 4, 1 : m + 3] - x[: n + 2, 1 : m + 3]
    rest = np.where(wide[1:, 1 : m + 1] > 0, np.float32(0), wide[:-1, 1 : m + 1])
    y[:, :] = rest[1:, :] - rest[:-1, :]


@pytest.mark.parametrize("length", LENGTHS)
def test_a_mask_chooses_as_many_as_there_are_at_most(length: int) -> None:
    kernel = KernelFunction(masked, "void(float32[::1], float32[::1])", None)
    lowered = lower(kernel)
    x = np.random.default_rng(1).standard_normal(length).astype(np.float32)
    theirs, mine = [x.copy(), np.zeros(2, np.float32)], [x.copy(), np.zeros(2, np.float32)]
    kernel(*theirs)
    run_regions(lowered, mine)
    assert all(map(np.array_equal, mine, theirs))


@pytest.mark.parametrize(("function", "more"), [(stencil, 0), (windows, 4)])
def test_slices_with_negative_and_omitted_ends_have_sizes(function: object, more: int) -> None:
    kernel = KernelFunction(function, "void(float32[:, ::1], float32[:, ::1])", None)
    lowered = lower(kernel)
    for shape in ((3, 7), (8, 5)):
        wide = tuple(size + more for size in shape)
        x = np.random.default_rng(2).standard_normal(wide).astype(np.float32)
        theirs, mine = [x, np.zeros(shape, np.float32)], [x, np.zeros(shape, np.float32)]
        kernel(*theirs)
        run_regions(lowered, mine)
        assert np.allclose(mine[1], theirs[1], atol=1e-5)  # FMAs round once


@pytest.mark.parametrize(
    ("formula", "short"),
    [
        (("u:n", "u:n", -2, "+", "max"), ("u:n",)),
        (("s:n", "s:n", -2, "+", "min", 0, "max"), ("s:n", -2, "+", 0, "max")),
        (("s:x.shape0", 0, "max", "s:x.shape0", 2, "*", "max"), ("s:x.shape0", 2, "*")),
        (("s:n", "s:n", "*", "s:n", "s:n", "*", "+"), ("s:n", "s:n", "*", 2, "*")),
        (
            ("s:m", "s:n", "min", "s:m", "s:n", 1, "+", "min", "max"),
            ("s:m", "s:n", 1, "+", "min"),
        ),
    ],
)
def test_formulas_are_made_shorter(formula: Formula, short: Formula) -> None:
    found = shortened(formula)
    assert len(found) <= len(short)
    for n in (-3, 0, 1, 9):
        for m in (-1, 4, 20):
            inputs = {"n": n & 0xFFFFFFFF, "m": m & 0xFFFFFFFF, "x.shape0": abs(n)}
            if n >= 0 or "u:n" not in formula:
                assert evaluate_formula(found, inputs) == evaluate_formula(formula, inputs)


def test_random_formulas_keep_their_value() -> None:
    random = Random(3)
    inputs = {"n": 5, "m": 0xFFFFFFFD, "x.shape0": 7}
    for _ in range(300):
        stack: list[Formula] = []
        for _ in range(random.randint(1, 14)):
            if len(stack) > 1 and random.random() < 0.5:
                right, left = stack.pop(), stack.pop()
                stack.append((*left, *right, random.choice(["+", "*", "max", "min"])))
            else:
                stack.append((random.choice(["u:n", "s:m", "s:x.shape0", 0, -2, 3]),))
        formula = stack.pop()
        assert evaluate_formula(shortened(formula), inputs) == evaluate_formula(formula, inputs)


def chosen(x, y):
    """Sizes of the operands along other dimensions bound nothing here."""
    inner = x[1:, :] * x[:-1, :]
    kept = np.where(inner > 0, 0, inner)
    y[:-1] = kept


def shaped(x, y, n):
    """-1 elements stand for as many as there are."""
    flat = np.reshape(x * np.float32(2), (n, x.size // n))
    y[:n] = flat @ y


def sizes_of(function: object, signature: str) -> list[Formula]:
    lowered = KernelFunction(function, signature, None).lower()
    return [array.size for array in lowered.locals if array.size]


def test_sizes_are_of_their_own_dimensions() -> None:
    sizes = sizes_of(chosen, "void(float32[:, ::1], float32[:, ::1])")
    inputs = {"x.shape0": 5, "x.shape1": 9, "y.shape0": 5, "y.shape1": 9}
    assert max(evaluate_formula(size, inputs) for size in sizes) == 2 * 4 * 9  # of float64


def test_a_size_that_may_be_left_open_bounds_a_product() -> None:
    sizes = sizes_of(shaped, "void(float32[:, ::1], float32[:, ::1], int64)")
    inputs = {"x.shape0": 4, "x.shape1": 3, "y.shape0": 4, "y.shape1": 3, "n": 4, "n.high": 0}
    assert 12 <= max(evaluate_formula(size, inputs) for size in sizes) <= 48
