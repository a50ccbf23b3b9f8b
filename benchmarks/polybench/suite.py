"""The kernels by name, with their sizes, and what the study of restructured loops has of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import vividc
from benchmarks.polybench.inputs import INPUTS, Arguments
from benchmarks.polybench.kernels import blas, images, medley, mining, products, solvers, stencils

MINI, SMALL, MEDIUM = "mini", "small", "medium"
SIZES: Final = (MINI, SMALL, MEDIUM)
FABRICS: Final = {MINI: "vivid-tile", SMALL: "vivid-tile", MEDIUM: "vivid"}
"""Where each size runs: the first two fit a tile's scratchpad."""


@dataclass(frozen=True, slots=True)
class Case:
    """A kernel of the suite.

    Attributes
    ----------
    name
        PolyBench's.
    kernel
        The function.
    sizes
        Arguments of its initialisation, by size.
    by_hand
        Cycles over operations / 16 of the study's hand-restructured form, with exact dependences
        where it was tried with them; None: it has none.
    operations
        Closed form of what `trace` counts, for sizes that are too large for it.
    long_chains
        It is bound by chains of divisions or roots.
    """

    name: str
    kernel: vividc.KernelFunction
    sizes: dict[str, tuple[int, ...]]
    by_hand: float | None = None
    operations: Callable[..., int] | None = None
    long_chains: bool = False

    def fresh(self, size: str) -> Arguments:
        """The same arguments at every call, in new arrays."""
        return INPUTS[self.kernel.name](*self.sizes[size])

    @property
    def of_polybench(self) -> bool:
        """Not one of the images."""
        return self not in IMAGES


def _gemm(ni: int, nj: int, nk: int) -> int:
    return ni * nj * (nk + 1) + ni * nk


def _two_mm(ni: int, nj: int, nk: int, nl: int) -> int:
    return ni * nk * (nj + 1) + ni * nl * (nj + 1)


def _syrk(n: int, m: int) -> int:
    return n * (n + 1) // 2 * (m + 1) + n * m


def _covariance(n: int, m: int) -> int:
    return m * (n + 1) + n * m + m * (m + 1) // 2 * (n + 1) + 1


def _jacobi_2d(steps: int, n: int) -> int:
    return 2 * steps * 5 * (n - 2) ** 2


def _fdtd_2d(steps: int, nx: int, ny: int) -> int:
    step = 2 * (nx - 1) * ny + 2 * nx * (ny - 1) + 4 * (nx - 1) * (ny - 1)
    unchanged = nx + ny - 2  # differences along the border of hz that no step changes
    return steps * step - (steps - 1) * unchanged


def _heat_3d(steps: int, n: int) -> int:
    return 2 * steps * 10 * (n - 2) ** 3


def _case(
    kernel: vividc.KernelFunction,
    mini: tuple[int, ...],
    small: tuple[int, ...],
    by_hand: float | None = None,
    *,
    medium: tuple[int, ...] | None = None,
    operations: Callable[..., int] | None = None,
    long_chains: bool = False,
) -> Case:
    name = _NAMES.get(kernel.name, kernel.name.replace("_", "-"))
    sizes = {MINI: mini, SMALL: small} | ({} if medium is None else {MEDIUM: medium})
    return Case(name, kernel, sizes, by_hand, operations, long_chains)


_NAMES = {"two_mm": "2mm", "three_mm": "3mm"}

POLYBENCH: Final = (
    _case(blas.gemm, (8, 10, 12), (20, 25, 30), 3.46, medium=(200, 220, 240), operations=_gemm),
    _case(blas.gemver, (12,), (40,)),
    _case(blas.gesummv, (12,), (30,), 6.7),
    _case(blas.symm, (8, 12), (20, 30), 6.0),
    _case(blas.syr2k, (12, 8), (30, 20), 5.0),
    _case(blas.syrk, (12, 8), (30, 20), 6.6, medium=(240, 200), operations=_syrk),
    _case(blas.trmm, (8, 12), (20, 30), 7.6),
    _case(
        products.two_mm, (6, 7, 8, 9), (16, 18, 22, 24), 4.8,
        medium=(180, 190, 210, 220), operations=_two_mm,
    ),
    _case(products.three_mm, (6, 7, 8, 9, 10), (16, 18, 20, 22, 24)),
    _case(products.atax, (14, 16), (38, 42), 6.3),
    _case(products.bicg, (14, 16), (42, 38), 4.6),
    _case(products.doitgen, (4, 4, 6), (10, 8, 12), 5.8),
    _case(products.mvt, (16,), (40,), 3.8),
    _case(solvers.cholesky, (10,), (24,), 44.3, long_chains=True),
    _case(solvers.durbin, (14,), (40,), 85.8, long_chains=True),
    _case(solvers.gramschmidt, (8, 6), (24, 16), 38.0, long_chains=True),
    _case(solvers.lu, (10,), (24,), 20.8, long_chains=True),
    _case(solvers.ludcmp, (10,), (24,), long_chains=True),
    _case(solvers.trisolv, (10,), (24,), 97.0, long_chains=True),
    _case(mining.correlation, (10, 8), (32, 28)),
    _case(
        mining.covariance, (10, 8), (32, 28), 8.8, medium=(260, 240), operations=_covariance
    ),
    _case(medley.deriche, (8, 10), (32, 36), 3.6),
    _case(medley.floyd_warshall, (10,), (24,), 12.8),
    _case(medley.nussinov, (12,), (40,), 59.0),
    _case(stencils.adi, (2, 8), (4, 20), 14.1),
    _case(
        stencils.fdtd_2d, (4, 8, 10), (10, 20, 30), 7.1,
        medium=(10, 200, 240), operations=_fdtd_2d,
    ),
    _case(stencils.heat_3d, (2, 6), (5, 12), medium=(10, 40), operations=_heat_3d),
    _case(stencils.jacobi_1d, (4, 16), (20, 30), 5.8),
    _case(stencils.jacobi_2d, (2, 10), (6, 30), 3.5, medium=(10, 250), operations=_jacobi_2d),
    _case(stencils.seidel_2d, (2, 10), (5, 30), 22.1),
)  # fmt: skip
IMAGES: Final = (
    _case(images.bilateral, (4,), (16,)),
    _case(images.bicubic, (4,), (16,)),
    _case(images.separable_blur, (8, 5), (32, 7)),
    _case(images.sphere_tracer, (4,), (16,)),
)
CASES: Final = {case.name: case for case in (*POLYBENCH, *IMAGES)}
