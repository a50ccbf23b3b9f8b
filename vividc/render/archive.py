"""Scene archives (`.npz`): arrays by name, each checked for type, shape and finite values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vividc.host.inputs import SCENE_BYTES
from vividc.host.npz import read_npz
from vividc.render.arrays import LARGEST_FLOAT32, Float32Array, Int64Array, frozen_float32
from vividc.render.errors import SceneError

Shape = tuple[int | None, ...]
"""Expected shape; None stands for any length."""
_NUMBERS = "fiu"
_INTEGERS = "iub"
_PIECE = 1 << 20


@dataclass(frozen=True, slots=True)
class Archive:
    """The arrays of one npz file; `layout` says in a hint what it should hold."""

    path: Path
    arrays: Mapping[str, npt.NDArray[Any]]
    layout: str

    def __contains__(self, name: str) -> bool:
        return name in self.arrays

    def floats(self, name: str, shape: Shape) -> Float32Array:
        """Return an array of finite numbers as read-only float32 (exact for float16).

        Raises
        ------
        SceneError
            The array is missing, of another shape, not of numbers, or holds nan or infinity.
        """
        array = self._checked(name, shape, _NUMBERS)
        wrong, count = _not_finite(array)
        if count:
            place = tuple(map(int, np.unravel_index(wrong, array.shape)))
            raise self.error(
                f"{name}{list(place)} is {array[place]}, not a finite float32 "
                f"({count} such values)",
                "the training diverged, or the file is damaged",
            )
        return frozen_float32(array)

    def integers(self, name: str, shape: Shape) -> Int64Array:
        """Return an array of integers as int64."""
        return self._checked(name, shape, _INTEGERS).astype(np.int64)

    def number(self, name: str, *, above: float | None = None) -> float:
        """Return a scalar (shape [] or [1]), greater than `above` if that is given."""
        shape: Shape = () if self._is_scalar(name) else (1,)
        value = float(self.floats(name, shape).item())
        if above is not None and not value > above:
            raise self.error(f"{name} is {value:g}, not above {above:g}")
        return value

    def whole(self, name: str, *, above: float | None = None) -> int:
        """Return a scalar that is a whole number."""
        value = self.number(name, above=above)
        if value != int(value):
            raise self.error(f"{name} is {value:g}, not a whole number")
        return int(value)

    def error(self, reason: str, hint: str = "") -> SceneError:
        """Return an error about this file."""
        return SceneError(reason, loc=str(self.path), hint=hint or self.layout)

    def _is_scalar(self, name: str) -> bool:
        return name not in self.arrays or self.arrays[name].ndim == 0

    def _checked(self, name: str, shape: Shape, kinds: str) -> npt.NDArray[Any]:
        if name not in self.arrays:
            raise self.error(f"the array `{name}` is missing")
        array = self.arrays[name]
        if array.dtype.kind not in kinds:
            wanted = "numbers" if kinds == _NUMBERS else "integers"
            raise self.error(f"the array `{name}` holds {array.dtype}, not {wanted}")
        fits = array.ndim == len(shape) and all(
            want is None or want == have for want, have in zip(shape, array.shape, strict=True)
        )
        if not fits:
            wanted = ", ".join("any" if length is None else str(length) for length in shape)
            raise self.error(f"the array `{name}` has shape {list(array.shape)}, not [{wanted}]")
        return array


def _not_finite(array: npt.NDArray[Any]) -> tuple[int, int]:
    """First index, in C order, of what is no finite float32, and how many there are."""
    flat = np.ascontiguousarray(array).reshape(-1)
    first, count = 0, 0
    for at in range(0, flat.size, _PIECE):  # piece by piece: a scene is large
        values = flat[at : at + _PIECE].astype(np.float64)
        wrong = np.flatnonzero(~(np.abs(values) <= LARGEST_FLOAT32))
        if wrong.size:
            first = first if count else at + int(wrong[0])
            count += wrong.size
    return first, count


def read_archive(path: Path | str, layout: str) -> Archive:
    """Read all arrays of an npz file; nothing in it is unpickled.

    Raises
    ------
    SceneError
        The file is missing, damaged, too large, or no npz archive of plain arrays.
    """
    path = Path(path)
    return Archive(path, read_npz(path, SCENE_BYTES, SceneError, layout), layout)
