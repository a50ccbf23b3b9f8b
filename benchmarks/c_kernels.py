"""The C kernels of `kernels/c/`, with small inputs; seeds are fixed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import vividc
from benchmarks.workloads import KERNELS, Arguments, Workload

Maker = Callable[[np.random.Generator], Arguments]


@dataclass(frozen=True)
class CWorkload(Workload):
    """A C function of `kernels/c/`; `file`: the `.ll` file, without that."""

    def kernel(self) -> vividc.LLKernel:
        """The function of this name in its file."""
        return vividc.load_ll(KERNELS / "c" / f"{self.file}.ll", self.name)


def _floats(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return rng.standard_normal(shape).astype(np.float32)


def _ints(rng: np.random.Generator, low: int, high: int, *shape: int) -> np.ndarray:
    return rng.integers(low, high, shape, dtype=np.int32)


def _words(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return rng.integers(0, 1 << 32, shape, dtype=np.uint32)


def _bytes(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return rng.integers(0, 256, shape, dtype=np.uint8)


def _halves(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return rng.integers(-(1 << 15), 1 << 15, shape, dtype=np.int16)


def _blank(*shape: int) -> np.ndarray:
    return np.zeros(shape, np.float32)


def _zeros(*shape: int) -> np.ndarray:
    return np.zeros(shape, np.int32)


def _distances(rng: np.random.Generator, n: int) -> np.ndarray:
    distance = _ints(rng, 1, 100, n, n)
    distance[rng.integers(0, 2, (n, n)) == 0] = 1 << 20
    np.fill_diagonal(distance, 0)
    return distance


def _trisolv(rng: np.random.Generator) -> Arguments:
    lower = np.tril(_floats(rng, 12, 12) * np.float32(0.3)) + 2 * np.eye(12, dtype=np.float32)
    return np.int32(12), lower, _blank(12), _floats(rng, 12)


def _find(rng: np.random.Generator) -> Arguments:
    text = _ints(rng, 0, 3, 150)
    return text, np.int32(150), text[120:126].copy(), np.int32(6)


def _binary_search(rng: np.random.Generator) -> Arguments:
    values = np.sort(_ints(rng, 0, 1000, 200))
    return values, np.int32(200), values[133]


LINEAR_ALGEBRA: dict[str, Maker] = {
    "gemm": lambda r: (
        *(np.int32(8), np.int32(9), np.int32(10), np.float32(1.5), np.float32(-0.5)),
        *(_floats(r, 8, 9), _floats(r, 8, 10), _floats(r, 10, 9)),
    ),
    "atax": lambda r: (
        *(np.int32(9), np.int32(12), _floats(r, 9, 12)),
        *(_floats(r, 12), _blank(12), _blank(9)),
    ),
    "mvt": lambda r: (
        *(np.int32(11), _floats(r, 11), _floats(r, 11)),
        *(_floats(r, 11), _floats(r, 11), _floats(r, 11, 11)),
    ),
    "transpose": lambda r: (_ints(r, -99, 99, 12, 12), np.int32(12)),
    "trisolv": _trisolv,
}
SIGNALS: dict[str, Maker] = {
    "fir": lambda r: (_ints(r, -99, 99, 80), _ints(r, -9, 9, 8), _zeros(73), np.int32(80)),
    "biquad": lambda r: (
        np.array([0.2, 0.4, 0.2, -0.6, 0.3, 0.1, -0.1], np.float32),
        *(_floats(r, 150), _blank(150), np.int32(150)),
    ),
    "jacobi2d": lambda r: (np.int32(8), np.int32(11), _floats(r, 8, 11), _blank(8, 11)),
    "prefix_sum": lambda r: (_ints(r, -99, 99, 150), np.int32(150)),
}
INTEGERS: dict[str, Maker] = {
    "crc32": lambda r: (_words(r, 12), np.int32(12)),
    "sha256_schedule": lambda r: (_words(r, 64),),
    "sha256_rounds": lambda r: (_words(r, 8), _words(r, 64), _words(r, 64)),
    "mandelbrot": lambda _: (
        np.linspace(-2, 0.5, 24, dtype=np.float32),
        *(np.float32(0.3), _zeros(24), np.int32(24), np.int32(30)),
    ),
}
SEARCHING: dict[str, Maker] = {
    "insertion_sort": lambda r: (_ints(r, -99, 99, 30), np.int32(30)),
    "bubble_sort": lambda r: (_ints(r, -99, 99, 20), np.int32(20)),
    "binary_search": _binary_search,
    "partition": lambda r: (_ints(r, -99, 99, 80), np.int32(80)),
    "find": _find,
    "floyd_warshall": lambda r: (np.int32(8), _distances(r, 8)),
    "count_ends": lambda r: (
        r.choice(np.array([32, 44, 46, 33, 97, 98, 99], np.int32), 150),
        *(np.int32(150), _zeros(4)),
    ),
}
BYTES: dict[str, Maker] = {
    "crc32_table": lambda r: (_bytes(r, 60), np.int32(60)),
    "string_length": lambda r: (np.append(_bytes(r, 90) | 1, np.uint8(0)).view(np.int8),),
    "find_byte": lambda r: (_bytes(r, 90) | 1, np.int32(90), np.int32(40)),
    "mix_pcm": lambda r: (
        *(np.zeros(60, np.int16), _halves(r, 60), _halves(r, 60)),
        *(np.int32(200), np.int32(150), np.int32(60)),
    ),
    "fnv1a": lambda r: (_bytes(r, 40), np.int32(40), np.uint64(0xCBF29CE484222325)),
    "xorshift64": lambda _: (np.uint64(0x9E3779B97F4A7C15), np.int32(40)),
    "digits": lambda _: (np.uint32(4000000007), np.uint32(36), np.zeros(32, np.uint8)),
    "counting_sort": lambda r: (_bytes(r, 60), np.zeros(60, np.uint8), np.int32(60)),
    "distinct_bytes": lambda r: (_bytes(r, 60), np.int32(60), np.zeros(256, np.bool_)),
}
FILES = {
    "linear_algebra": LINEAR_ALGEBRA,
    "signals": SIGNALS,
    "integers": INTEGERS,
    "searching": SEARCHING,
    "bytes": BYTES,
}
WORKLOADS = tuple(
    CWorkload(name, make, file) for file, table in FILES.items() for name, make in table.items()
)
