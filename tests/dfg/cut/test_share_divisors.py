"""Divisors that do not change, or that several quotients have in common, are prepared once."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.cut.share_divisors import share_divisors
from vividc.dfg.interpret.interpreter import interpret
from vividc.dfg.pipeline import optimize_kernel
from vividc.machine.opcodes import Opcode
from vividc.machine.words import word_of
from vividc.ssa.check import check_function
from vividc.ssa.interpret import interpret as interpret_words
from vividc.ssa.ir import Function
from vividc.ssa.rewrite.hoist_loads import hoist_loads
from vividc.ssa.rewrite.normalize import normalize
from vividc.ssa.rewrite.tidy import tidy

V, M = "float32[::1]", "float32[:, ::1]"
COUNT = 64


@vividc.kernel(f"void({V}, float32)")
def by_a_parameter(x, d):
    for i in range(len(x)):
        x[i] /= d


@vividc.kernel(f"void({M}, {V})")
def by_a_row(x, d):
    """The inner loop does not change the divisor; the outer one does."""
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            x[i, j] /= d[i] + np.float32(1)


@vividc.kernel(f"void({V}, {V}, {V})")
def two_by_one(x, y, d):
    for i in range(len(x)):
        x[i] /= d[i]
        y[i] /= d[i]


@vividc.kernel(f"void({V}, {V})")
def one_by_one(x, d):
    for i in range(len(x)):
        x[i] /= d[i]


@vividc.kernel(f"void({V}, float32)")
def by_turns(x, d):
    """Each quotient waits for the one before: what counts is the shortest way."""
    last = x[0]
    for i in range(len(x)):
        last = (last + x[i]) / d
        x[i] = last


@vividc.kernel(f"void({V}, float32)")
def by_a_root(x, d):
    root = np.sqrt(d)
    for i in range(len(x)):
        x[i] /= root


@vividc.kernel(f"void({V}, float32)")
def many_in_an_iteration(x, d):
    for i in range(len(x) // 6):
        x[6 * i] /= d
        x[6 * i + 1] /= d
        x[6 * i + 2] /= d
        x[6 * i + 3] /= d
        x[6 * i + 4] /= d
        x[6 * i + 5] /= d


@vividc.kernel(f"void({M}, {V}, float32)")
def beside_a_loop(x, y, d):
    """One division an iteration of the outer loop."""
    for i in range(x.shape[0]):
        total = np.float32(0)
        for j in range(x.shape[1]):
            total += x[i, j]
        y[i] = total / d


@vividc.kernel(f"void({M}, {V}, float32)")
def in_a_chain(x, y, d):
    """Nine divisions, each of which waits for the one before."""
    for i in range(x.shape[0]):
        t = np.float32(0)
        for j in range(x.shape[1]):
            t += x[i, j]
        t = (((t / d + x[i, 0]) / d + x[i, 1]) / d + x[i, 2]) / d
        t = (((t + x[i, 3]) / d + x[i, 4]) / d + x[i, 5]) / d
        y[i] = ((t + x[i, 6]) / d + x[i, 7]) / d


@vividc.kernel(f"void({V}, float32)")
def by_a_constant(x, _):
    for i in range(len(x)):
        x[i] /= np.float32(3)


@vividc.kernel(f"void({V}, float32)")
def few_at_once(x, d):
    x[0] /= d
    x[1] /= d


@vividc.kernel(f"void({V}, float32)")
def many_at_once(x, d):
    x[0] /= d
    x[1] /= d
    x[2] /= d
    x[3] /= d
    x[4] /= d


@vividc.kernel(f"void({M}, {V}, float32, float32)")
def solver_rows(x, p, a, b):
    """The factors of a tridiagonal solver, and two rows that wait for less than these do."""
    factor = one = two = np.float32(0)
    for i in range(len(p)):
        around = a * factor + b
        factor = -a / around
        one = (x[0, i] - a * one) / around
        two = (x[1, i] - a * two) / around
        p[i] = factor
        x[0, i] = one
        x[1, i] = two


@vividc.kernel(f"void({M}, {V}, float32, float32)")
def longer_row(x, p, a, b):
    """A row that waits as long as the factors do, through a second quotient."""
    factor = one = np.float32(0)
    for i in range(len(p)):
        around = a * factor + b
        factor = -a / around
        one = (x[0, i] - a * (one / around)) / around
        p[i] = factor
        x[0, i] = one


@vividc.kernel(f"void({M}, {V}, float32, float32)")
def one_row(x, p, a, b):
    """Its divisor waits for nothing: in halves it would come later."""
    one = np.float32(0)
    for i in range(len(p)):
        one = (x[0, i] - a * one) / p[i]
        x[1, i] = b / p[i]
        x[0, i] = one


def shaped(kernel: vividc.KernelFunction) -> Function:
    return hoist_loads(normalize(tidy(kernel.lower())))


def divisions(function: Function) -> int:
    return sum(i.op is Opcode.FDIV for block in function.blocks for i in block.instrs)


@pytest.mark.parametrize(
    ("kernel", "left"),
    [
        (by_a_parameter, 0),
        (by_a_row, 0),
        (two_by_one, 0),
        (one_by_one, 1),
        (by_turns, 0),
        (in_a_chain, 0),
        (beside_a_loop, 0),
        (by_a_root, 0),
        (few_at_once, 2),
        (many_at_once, 0),
    ],
    ids=lambda value: getattr(value, "name", str(value)),
)
def test_what_shares_its_divisor(kernel: vividc.KernelFunction, left: int) -> None:
    function = shaped(kernel)
    shared = share_divisors(function)
    assert check_function(shared) == []
    assert divisions(shared) == left
    assert (shared is function) == (left == divisions(function))


@pytest.mark.parametrize(("kernel", "left"), [(solver_rows, 1), (longer_row, 3), (one_row, 1)])
def test_rows_wait_for_their_factors_anyway(kernel: vividc.KernelFunction, left: int) -> None:
    """A row's quotient takes twelve cycles more in few operations, which another recurrence
    hides.
    """
    assert divisions(share_divisors(shaped(kernel))) == left


def test_rows_of_a_solver_agree_with_numba() -> None:
    rows = np.random.default_rng(4).uniform(-1, 1, (2, 40)).astype(np.float32)
    mine, numbas = rows.copy(), rows.copy()
    program = vividc.compile(solver_rows)
    [loop] = [region for region in program.regions if region.kind == "loop"]
    assert loop.operations < 46 + 24 + 2 * 20  # a whole quotient, what is common, and two rests
    vividc.simulate(program, mine, np.zeros(40, np.float32), np.float32(-2), np.float32(5))
    solver_rows(numbas, np.zeros(40, np.float32), np.float32(-2), np.float32(5))
    np.testing.assert_allclose(mine, numbas, rtol=1e-5)


def test_constants_have_a_shorter_way() -> None:
    function = shaped(by_a_constant)
    assert share_divisors(function) is function


@pytest.mark.parametrize(
    ("kernel", "operations"),
    [
        (by_a_parameter, 1 + 20 + 1),
        (by_a_root, 1 + 20 + 1),
        (by_turns, 3 + 20 + 1),
        (two_by_one, 24 + 2 * 11 + 5),
        (many_in_an_iteration, 6 * (1 + 11 + 1) + 1),
    ],
)
def test_operations_of_an_iteration(kernel: vividc.KernelFunction, operations: int) -> None:
    """A load, a store and the rest of a division; the preparation, where it comes with it. One
    division in a short loop has the quotient that is there soonest, on a recurrence too.
    """
    made = optimize_kernel(build_kernel(shaped(kernel)))
    [loop] = [region for region in made.regions if region.kind == "loop"]
    assert len(loop.dfg.operations) == operations


@pytest.mark.parametrize(
    "kernel",
    [
        *(by_a_parameter, by_a_row, two_by_one, many_at_once, by_turns, by_a_root),
        *(many_in_an_iteration, beside_a_loop, in_a_chain),
    ],
)
def test_no_bit_changes(kernel: vividc.KernelFunction) -> None:
    """The semantics of `fdiv` in SSA round a quotient once: none here is subnormal."""
    rng = np.random.default_rng(5)

    def words(shape: tuple[int, ...]) -> np.ndarray:
        return rng.integers(0x38000000, 0x48000000, shape).astype(np.uint32).view(np.float32)

    rows = [(4, 8), (4,)]
    shapes = {by_a_row: rows, beside_a_loop: rows, in_a_chain: rows, two_by_one: [(COUNT,)] * 3}
    arguments = [words(shape) for shape in shapes.get(kernel, [(COUNT,)])]
    if kernel not in (by_a_row, two_by_one):
        arguments.append(np.float32(0.7 if kernel is by_a_root else -0.7))
    mine = [np.array(one) if np.ndim(one) else one for one in arguments]
    function = shaped(kernel)
    interpret_words(function, *arguments)
    interpret_words(share_divisors(function), *mine)
    for one, other in zip(arguments, mine, strict=True):
        assert np.array_equal(np.asarray(one).view(np.uint32), np.asarray(other).view(np.uint32))


def test_quotients_that_need_care_are_as_numpys() -> None:
    """Zeros, infinities, NaNs, subnormal dividends, quotients that overflow: in a whole kernel."""
    kernel = optimize_kernel(build_kernel(shaped(by_a_parameter)))
    x = np.array([1, 0.0, -0.0, np.inf, -np.inf, np.nan, 1e-45, -3e-39, 3e38, 7], np.float32)
    for divisor in (0.3, -0.3, 1e-40, -1e-45, 0.0, -0.0, np.inf, np.nan, 3e38):
        mine = x.copy()
        inputs = {"&x": 0, "x.shape0": len(x), "d": word_of(divisor)}
        interpret(kernel, mine.view(np.uint32), inputs)
        with np.errstate(all="ignore"):
            quotients = x / np.float32(divisor)
        assert np.array_equal(mine, quotients, equal_nan=True)
        numbers = ~np.isnan(quotients)
        assert np.array_equal(np.signbit(mine[numbers]), np.signbit(quotients[numbers]))
