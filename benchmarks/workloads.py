"""The kernels beside the blend, with inputs of a useful size; seeds are fixed."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import vividc

KERNELS = Path(__file__).resolve().parents[1] / "kernels"
Arguments = tuple[object, ...]


@dataclass(frozen=True)
class Workload:
    """A kernel of `kernels/` and a function that makes fresh arguments for it.

    `file`: where it is, without `.py`; empty for the file of the kernel's name.
    """

    name: str
    arguments: Callable[[np.random.Generator], Arguments]
    file: str = ""

    def kernel(self) -> vividc.KernelFunction | vividc.LLKernel:
        """The kernel of this name in its file."""
        path = KERNELS / f"{self.file or self.name}.py"
        spec = importlib.util.spec_from_file_location(self.name, path)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        kernel = getattr(module, self.name)
        assert isinstance(kernel, vividc.KernelFunction)
        return kernel

    def fresh(self) -> Arguments:
        """The same arguments at every call, in new arrays."""
        return self.arguments(np.random.default_rng(7))


def transformations(program: vividc.Program) -> str:
    """What was done to which source lines, in short."""
    return ", ".join(
        f"{item.kind}{f' by {item.factor}' if item.factor else ''} (line {loop.loc.line})"
        for loop in program.loops
        for item in loop.transforms
        if item.chosen and loop.loc is not None
    )


def _floats(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return rng.standard_normal(shape).astype(np.float32)


def _ints(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return rng.integers(-1000, 1000, shape, dtype=np.int32)


def _saxpy(rng: np.random.Generator) -> Arguments:
    return np.float32(1.5), _floats(rng, 2000), _floats(rng, 2000), np.int32(2000)


def _dot(rng: np.random.Generator) -> Arguments:
    return _floats(rng, 2000), _floats(rng, 2000), np.int32(2000)


def _fir(rng: np.random.Generator) -> Arguments:
    return _ints(rng, 271), _ints(rng, 16), np.zeros(256, np.int32)


def _prefix_sum(rng: np.random.Generator) -> Arguments:
    return (_ints(rng, 2000),)


def _relu_gemv(rng: np.random.Generator) -> Arguments:
    return _floats(rng, 32, 64), _floats(rng, 64), _floats(rng, 32), np.zeros(32, np.float32)


def _count_until(rng: np.random.Generator) -> Arguments:
    x = rng.integers(0, 1000, 2000, dtype=np.int32)
    x[1900] = -1
    return x, np.zeros(2000, np.int32), np.int32(500)


def _gs_blend(rng: np.random.Generator) -> Arguments:
    """A made-up list of 200 splats over 8x8 pixels; `make demo` blends a real scene."""
    n, pixels = 200, 64
    conic = np.abs(rng.normal(0.1, 0.05, n)).astype(np.float32)
    return (
        rng.uniform(-4, 12, n).astype(np.float32),
        rng.uniform(-4, 12, n).astype(np.float32),
        conic,
        rng.normal(0, 0.02, n).astype(np.float32),
        conic[::-1].copy(),
        rng.uniform(0.02, 0.9, n).astype(np.float32),
        *(rng.uniform(0, 1, n).astype(np.float32) for _ in range(3)),
        np.zeros(4 * pixels, np.float32),
        *(np.int32(value) for value in (0, 0, 8, 8, n)),
    )


WORKLOADS = (
    Workload("saxpy", _saxpy),
    Workload("dot", _dot),
    Workload("fir", _fir),
    Workload("prefix_sum", _prefix_sum),
    Workload("relu_gemv", _relu_gemv),
    Workload("count_until", _count_until),
    Workload("gs_blend", _gs_blend),
)
