"""Arrays made of tuples, nested or not, of constants and values in any mixture: what numba gets."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import vividc
from tests.e2e.constructs.registry import Construct
from tests.e2e.test_constructs import interpreted
from vividc.frontend import KernelFunction


def make(expression: str, dims: int, dtype: str) -> KernelFunction:
    """A kernel that makes the array and copies it, element by element, to its last argument."""
    loops = "".join(f"{' ' * (1 + k)}for i{k} in range(t.shape[{k}]):\n" for k in range(dims))
    place = ", ".join(f"i{k}" for k in range(dims))
    body = f"{' ' * (1 + dims)}o[n] = t[{place}]\n{' ' * (1 + dims)}n += 1"
    scope: dict[str, object] = {"np": np}
    source = f"def program(a, b, x, o):\n t = np.array({expression})\n n = 0\n{loops}{body}"
    exec(source, scope)  # the tuple is part of the program
    signature = f"void({dtype}, {dtype}, {dtype}[::1], {dtype}[::1])"
    return KernelFunction(scope["program"], signature, "program")  # type: ignore[arg-type]


def arguments(dtype: str) -> tuple[object, ...]:
    kind = np.dtype(dtype).type
    return kind(11), kind(22), np.arange(31, 39, dtype=dtype), np.zeros(64, dtype)


def drawn(seed: int) -> tuple[str, int, str]:
    """An expression, its number of dimensions, and the type of its parameters."""
    rng = np.random.default_rng(seed)
    dtype = str(rng.choice(["float32", "int32"]))
    dims = int(rng.integers(1, 4))
    shape = [int(n) for n in rng.integers(1, (9, 5, 4)[dims - 1], dims)]
    typed = f"np.{dtype}" if rng.random() < 0.6 else ""
    leaves = ["a", "b", "x[0]", "x[2]", f"{typed}(0)", f"{typed}(7)", f"{typed}(1)"]
    leaves = leaves[: int(rng.integers(2, len(leaves) + 1))][:: int(rng.choice([-1, 1]))]
    few = leaves[: int(rng.integers(1, len(leaves) + 1))]

    def nested(left: list[int]) -> str:
        if not left:
            return str(rng.choice(few))
        return f"({''.join(nested(left[1:]) + ', ' for _ in range(left[0]))})"

    cast = f", np.{dtype}" if not typed or rng.random() < 0.5 else ""
    return nested(shape) + cast, dims, dtype


def agrees(kernel: KernelFunction, dtype: str, run: Callable[..., object]) -> None:
    expected, found = arguments(dtype), arguments(dtype)
    kernel(*expected)
    run(kernel, found)
    np.testing.assert_array_equal(found[-1], expected[-1])


def interpret(kernel: KernelFunction, args: tuple[object, ...]) -> None:
    interpreted(Construct(kernel, (), False), args)


def simulate(kernel: KernelFunction, args: tuple[object, ...]) -> None:
    vividc.simulate(vividc.compile(kernel, time_limit_s=10), *args)


@pytest.mark.parametrize(
    "items",
    [
        "(a, a, b)",
        "(np.float32(0), np.float32(0), a)",
        "(a, a, b, x[2])",
        "(a, b, a)",
        "(a, b, b, x[0], x[0])",
        "(x[0], x[0], x[0], x[0], x[0], a, a)",
        "((1.0, 0.0), (0.0, 1.0)), np.float32",
        "((np.float32(1), np.float32(0)), (np.float32(0), x[1]))",
        "((1, 0), (0, 1)), np.float32",
    ],
)
def test_an_array_of_a_tuple_has_its_elements(items: str) -> None:
    """LLVM makes a switch over the index of an integer of few bits."""
    agrees(make(items, 2 if items.startswith("((") else 1, "float32"), "float32", interpret)


@pytest.mark.parametrize("items", ["(x[0], x[1], x[2], x[3]), np.float32", "((1, a), (x[3], 0))"])
def test_the_simulator_has_them_too(items: str) -> None:
    agrees(make(items, 2 if items.startswith("((") else 1, "float32"), "float32", simulate)


@pytest.mark.parametrize("seed", range(5))
def test_random_tuples(seed: int) -> None:
    expression, dims, dtype = drawn(seed)
    agrees(make(expression, dims, dtype), dtype, interpret)


@pytest.mark.slow
def test_many_random_tuples() -> None:
    for seed in range(100, 300):
        expression, dims, dtype = drawn(seed)
        try:
            agrees(make(expression, dims, dtype), dtype, interpret)
        except Exception as error:
            raise AssertionError(f"{seed}: np.array({expression})") from error
