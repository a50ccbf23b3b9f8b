"""Random arguments of a kernel, and the comparison of what two runs left."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from tests.fuzz.places import FIXED, MOST, fixed_length
from vividc.frontend import KernelFunction
from vividc.machine.params import DType

LENGTH = 16
"""Of every dimension of a kernel whose module does not say more."""

RELATIVE, ABSOLUTE = 1e-6, 2e-38
"""Elementary functions are within some 8 ulp of numba's; some of ours have no subnormal results."""


class Difference(Exception):
    """A witness disagrees: which one and how."""


@dataclass(frozen=True, slots=True)
class Shapes:
    """Dimensions of the arrays by name, whether their lengths are `places.FIXED`, and the greatest
    values of scalars that are natural numbers.
    """

    dims: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    is_fixed: bool = True
    most: Mapping[str, int] = field(default_factory=dict)

    def lengths(self, rng: np.random.Generator, trial: int) -> dict[str, int]:
        """Lengths of a trial: middling ones, tiny ones with 0 and 1, any."""
        if self.is_fixed:
            return FIXED
        least, most = ((3, 99), (0, 3), (0, 99))[trial % 3]
        return {
            dim: int(rng.integers(min(least, limit - 1), min(most, limit) + 1))
            for dim, limit in MOST.items()
        }


def arguments(kernel: KernelFunction, shapes: Shapes, seed: int, trial: int) -> list[object]:
    """Random arguments; those of the second trial are nearer to 0."""
    rng = np.random.default_rng([seed, trial])
    lengths = shapes.lengths(rng, trial)
    limit = (2**64, 40, 2**64)[trial % 3]
    found: list[object] = []
    for param in kernel.params:
        dims = shapes.dims.get(param.name, ())
        size = tuple(fixed_length(d) or lengths[d] for d in dims) or (LENGTH,) * param.ndim
        if param.name in shapes.most:
            found.append(np.int32(rng.integers(shapes.most[param.name] + 1)))
        elif param.name[0] == "n" and param.name[1:] in lengths:
            found.append(np.int32(lengths[param.name[1:]]))
        elif param.ndim:
            found.append(_draw(rng, param.dtype, size, limit))
        else:
            found.append(_draw(rng, param.dtype, (1,), limit)[0])
    return found


def _draw(rng: np.random.Generator, dtype: DType, size: tuple[int, ...], limit: int) -> np.ndarray:
    if dtype is DType.F32:
        return rng.integers(-64, 64, size).astype(np.float32) / np.float32(8)
    if dtype is DType.C64:
        real, imag = (_draw(rng, DType.F32, size, limit) for _ in range(2))
        return real + np.complex64(1j) * imag
    if dtype is DType.BOOL:
        return rng.random(size) < 0.5
    info = np.iinfo(dtype.value)
    most = 2**62 if dtype is DType.I64 else info.max  # leaves room for sums
    low, high = max(info.min, -limit, -most - 1), min(most, limit)
    return rng.integers(low, high, size, info.dtype, endpoint=True)


def compare(
    what: str, found: list[object], expected: list[object], rough: frozenset[int] = frozenset()
) -> None:
    """Demands equality, bit for bit but for what a NaN holds; those in `rough` may differ a bit."""
    for number, (one, other) in enumerate(zip(found, expected, strict=True)):
        if not _are_same(one, other, number in rough):
            raise Difference(f"{what}: value {number} is {_told(one)}, not {_told(other)}")


def _are_same(one: object, other: object, is_rough: bool) -> bool:
    if isinstance(one, tuple) or isinstance(other, tuple):
        alike = isinstance(one, tuple) and isinstance(other, tuple) and len(one) == len(other)
        return alike and all(_are_same(a, b, is_rough) for a, b in zip(one, other, strict=True))
    if one is None or other is None:
        return one is other
    first, second = np.asarray(one), np.asarray(other)
    if isinstance(other, np.ndarray) and first.dtype != second.dtype:
        return False
    return _near(first, second) if is_rough else _same(first, second)


def _told(value: object) -> object:
    if isinstance(value, tuple):
        return tuple(map(_told, value))
    return None if value is None else np.asarray(value).tolist()


def _near(first: np.ndarray, second: np.ndarray) -> bool:
    return np.allclose(first, second, rtol=RELATIVE, atol=ABSOLUTE, equal_nan=True)


def _same(first: np.ndarray, second: np.ndarray) -> bool:
    if first.dtype.kind == second.dtype.kind == "c":
        return _same(first.real, second.real) and _same(first.imag, second.imag)
    is_float = second.dtype.kind == "f"
    if not np.array_equal(first, second, equal_nan=is_float):
        return False
    if not is_float:
        return True
    # 0.0 == -0.0, but they differ in their sign.
    return bool((np.signbit(first) == np.signbit(second))[~np.isnan(second)].all())
