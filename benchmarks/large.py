"""Kernels larger than a scratchpad, without `prange`, on the sixteen tiles of `vivid`."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

import vividc
from benchmarks import EFFORT
from benchmarks.polybench.measure import RTOL, largest_error
from benchmarks.polybench.suite import CASES, MEDIUM
from vividc.errors import VividcError
from vividc.launch import JobResult, nests_cycles
from vividc.launch.steps import Execute

TITLE: Final = "Kernels larger than a scratchpad"
NOTES: Final = f"""\
Whole kernels without `prange`, compiled for `vivid` without a flag, and launched once: blocks of
their nests on sixteen tiles (docs/accelerator.md), or the arrays of docs/gemm.md where those are
predicted to be faster. The last ones are the medium sizes of PolyBench.

- right: floats differ from numba's by at most {RTOL:g} of the greatest number in their array.
- roof: the larger of DRAM's cycles, at 32 bytes each, and operations / 256. A nest reads what it
  reads of DRAM once, and writes what it writes once, each time that it runs.
- share: the roof over the cycles. moved: bytes of DRAM over those of the roof.
- way: what ran: blocks of nests, or, for products, arrays of tiles where they are faster.
- predicted: cycles that a launch of blocks expects before it runs, over the cycles.
- seconds are of user CPU.
""".splitlines()
HEADER: Final = (
    "| kernel | sizes | right | cycles | roof | which | share | moved | way | runs | predicted "
    "| compile s | simulate s |\n"
    "|---|---|---|---|---|---|---|---|---|---|---|---|---|"
)
MATRIX, VECTOR = "float32[:, ::1]", "float32[::1]"
_SIDE: Final = 1024
_WORD: Final = 4
Matrix = NDArray[np.float32]


@vividc.kernel(f"void({MATRIX}, {MATRIX})")
def blur(x: Matrix, y: Matrix) -> None:
    for i in range(1, x.shape[0] - 1):
        for j in range(1, x.shape[1] - 1):
            ends = x[i - 1, j] + x[i + 1, j] + x[i, j - 1] + x[i, j + 1]
            y[i, j] = np.float32(0.2) * (x[i, j] + ends)


@vividc.kernel(f"void(float32, {MATRIX}, {MATRIX})")
def saxpy(a: np.float32, x: Matrix, y: Matrix) -> None:
    for i in range(x.shape[0]):
        for j in range(x.shape[1]):
            y[i, j] += a * x[i, j]


@vividc.kernel(f"void({MATRIX}, {VECTOR}, {VECTOR})")
def gemv(a: Matrix, x: Matrix, y: Matrix) -> None:
    for i in range(a.shape[0]):
        total = np.float32(0)
        for j in range(a.shape[1]):
            total += a[i, j] * x[j]
        y[i] = total


@vividc.kernel(f"void({MATRIX}, {MATRIX}, {MATRIX})")
def gemm(a: Matrix, b: Matrix, c: Matrix) -> None:
    for i in range(c.shape[0]):
        for j in range(c.shape[1]):
            total = np.float32(0)
            for k in range(a.shape[1]):
                total += a[i, k] * b[k, j]
            c[i, j] = total


@dataclass(frozen=True, slots=True)
class Large:
    """A kernel with its arguments; `words` that its nests read and write, and its operations."""

    name: str
    kernel: vividc.KernelFunction
    sizes: str
    fresh: Callable[[], tuple[object, ...]]
    words: int
    operations: int

    @property
    def roof(self) -> tuple[int, str]:
        """Cycles, and what binds."""
        return max((_WORD * self.words // 32, "DRAM"), (self.operations // 256, "operations"))


def _floats(*shape: int) -> Matrix:
    return np.random.default_rng(sum(shape)).standard_normal(shape).astype(np.float32)


def _square(count: int) -> tuple[Matrix, ...]:
    return tuple(_floats(_SIDE, _SIDE) for _ in range(count))


def _vectors() -> tuple[object, ...]:
    return (*_square(1), _floats(_SIDE), _floats(_SIDE))


_AREA: Final = _SIDE * _SIDE
_OURS: Final = (
    Large("blur", blur, "1024x1024", lambda: _square(2), 2 * _AREA, 5 * _AREA),
    Large("saxpy", saxpy, "1024x1024", lambda: (np.float32(2), *_square(2)), 3 * _AREA, _AREA),
    Large("gemv", gemv, "1024x1024", _vectors, _AREA + 2 * _SIDE, _AREA),
    Large("gemm", gemm, "1024x1024 by 1024", lambda: _square(3), 3 * _AREA, _AREA * _SIDE),
)
_WORDS: Final[dict[str, Callable[..., int]]] = {
    "gemm": lambda n, m, k: n * k + k * m + 2 * n * m,
    "2mm": lambda n, m, k, p: n * k + k * m + 2 * n * m + m * p + 2 * n * p,
    "syrk": lambda n, m: n * m + n * (n + 1),
    "covariance": lambda n, m: 4 * n * m + m * m,
    "jacobi-2d": lambda steps, n: 4 * steps * n * n,
    "fdtd-2d": lambda steps, n, m: 10 * steps * n * m,
    "heat-3d": lambda steps, n: 4 * steps * n**3,
}
"""Words that the nests of medium kernels read and write, in the order of their sizes."""


def cases() -> Iterator[Large]:
    """All kernels of the table."""
    yield from _OURS
    for name, words in _WORDS.items():
        case = CASES[name]
        sizes = case.sizes[MEDIUM]
        assert case.operations is not None
        fresh = lambda case=case: case.fresh(MEDIUM)  # noqa: E731 - of this case
        text = "x".join(map(str, sizes))
        yield Large(name, case.kernel, text, fresh, words(*sizes), case.operations(*sizes))


def rows() -> Iterator[str]:
    """Yield the lines of the table, as they are measured."""
    for case in cases():
        yield row(case)


def row(case: Large) -> str:
    """One line: the kernel compiled, run, and compared with numba."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what is not as in numba shows in the results
        try:
            cells = _measured(case)
        except VividcError as error:
            reason = " ".join(error.reason.split())
            cells = [f"refused: {reason}", *["-"] * 10]
    return f"| {case.name} | {case.sizes} | {' | '.join(cells)} |"


def _measured(case: Large) -> list[str]:
    start = os.times().user
    program = vividc.compile(case.kernel, fabric="vivid", effort=EFFORT)
    compiled = os.times().user
    mine, numbas = case.fresh(), case.fresh()
    result = vividc.simulate(program, *mine)
    assert isinstance(result, JobResult)
    done = os.times().user
    case.kernel(*numbas)
    error = largest_error(mine, numbas)
    roof, which = case.roof
    moved = result.stats["bytes"]["dram_read"] + result.stats["bytes"]["dram_written"]
    ran = [step.program.fabric for step in result.record.steps if isinstance(step, Execute)]
    arrays = any(len(fabric.pes) != len(program.fabric.pes) for fabric in ran)
    expected = None if arrays else nests_cycles(program, mine, {}, "vivid")
    way = "arrays" if arrays else "blocks"
    return [
        "yes" if error <= RTOL else f"NO: {error:.1e}",
        f"{result.cycles:,}",
        f"{roof:,}",
        which,
        f"{roof / result.cycles:.1%}",
        f"{moved / (_WORD * case.words):.2f}",
        way,
        f"{result.stats['runs']:,}",
        "-" if expected is None else f"{expected / result.cycles:.2f}",
        f"{compiled - start:.1f}",
        f"{done - compiled:.1f}",
    ]
