"""Small kernels, one construct each, with arguments to run them on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vividc.frontend import KernelFunction


@dataclass(frozen=True)
class Construct:
    """A kernel, its arguments, and whether it also goes through the mapper and the simulator."""

    kernel: KernelFunction
    args: tuple[object, ...]
    mapped: bool

    def fresh(self) -> tuple[object, ...]:
        """Arguments that a run may change."""
        return tuple(a.copy() if isinstance(a, np.ndarray) else a for a in self.args)


CONSTRUCTS: dict[str, Construct] = {}


def words(*values: int) -> np.ndarray:
    return np.array(values, np.int32)


def unsigned(*values: int) -> np.ndarray:
    return np.array(values, np.uint32)


def floats(*shape: int) -> np.ndarray:
    return np.random.default_rng(3).standard_normal(shape).astype(np.float32)


A = words(5, -3, 8, 0, 7, -9, 2, 4)
"""What most kernels work on."""


def construct(
    signature: str, *args: object, mapped: bool = False
) -> Callable[[Callable[..., object]], Callable[..., object]]:
    """Register a function with its numba signature and arguments."""

    def register(function: Callable[..., object]) -> Callable[..., object]:
        assert function.__name__ not in CONSTRUCTS
        kernel = KernelFunction(function, signature, None)
        CONSTRUCTS[function.__name__] = Construct(kernel, args, mapped)
        return function

    return register
