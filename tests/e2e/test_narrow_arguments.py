"""What a launch with bytes, halves and flags accepts, and the message for what it refuses."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import vividc
from benchmarks.general import BYTES_AND_IMAGES, WORKLOADS
from vividc.errors import ArgumentError, KernelError
from vividc.program import Program

SHAPE = (4, 6)


@cache
def program(name: str) -> Program:
    assert name in BYTES_AND_IMAGES
    (workload,) = (w for w in WORKLOADS if w.name == name)
    return vividc.compile(workload.kernel(), effort="fast")


def image(dtype: str = "uint8") -> np.ndarray:
    return np.arange(24, dtype=np.uint8).reshape(SHAPE).astype(dtype)


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        (image("int8"), "expected a C-contiguous uint8 array with 2 dimension.s., got int8 with 2"),
        (image("bool"), "got bool with 2"),
        (image("int32"), "got int32 with 2"),
        (image("uint16").astype(">u2"), "got >u2 with 2"),
        (image().reshape(-1), "got uint8 with 1"),
        (np.asfortranarray(image()), "got one with strides"),
        (np.zeros((4, 12), np.uint8)[:, ::2], "got one with strides"),
        (image().tolist(), "got list"),
        (np.uint8(3), "got uint8"),
        (None, "got NoneType"),
    ],
)
def test_arrays_of_another_kind_are_refused(given: object, reason: str) -> None:
    with pytest.raises(ArgumentError, match=reason) as caught:
        vividc.simulate(program("box_blur"), given, image())
    assert "argument image of box_blur" in str(caught.value)


@pytest.mark.parametrize(
    ("level", "reason"),
    [(256, "256 does not fit uint8"), (-1, "-1 does not fit uint8"), (1.5, "expected uint8")],
)
def test_scalars_of_another_kind_are_refused(level: object, reason: str) -> None:
    mask = np.zeros(3, bool)
    with pytest.raises(ArgumentError, match=reason):
        vividc.simulate(program("threshold_mask"), np.zeros(3, np.uint8), level, mask)


def test_overlap_is_found_across_types() -> None:
    raw = np.zeros(64, np.uint8)
    for pixels, mask in ((raw, raw.view(bool)), (raw[:33], raw[32:].view(bool))):
        with pytest.raises(ArgumentError, match="arrays pixels and mask overlap"):
            vividc.simulate(program("threshold_mask"), pixels, 9, mask)
    assert vividc.simulate(program("threshold_mask"), raw[:32], 9, raw[32:].view(bool)).value == 0


def test_read_only_arrays_may_be_read() -> None:
    pixels, mask = np.arange(9, dtype=np.uint8), np.zeros(9, bool)
    pixels.flags.writeable = False
    assert vividc.simulate(program("threshold_mask"), pixels, 4, mask).value == mask.sum() == 4
    mask.flags.writeable = False
    with pytest.raises(ArgumentError, match="read-only"):
        vividc.simulate(program("threshold_mask"), pixels, 4, mask)


def test_bytes_take_bytes() -> None:
    """Two images of 16,000 bytes fit in 32 KiB."""
    pixels, mask = np.full(16_000, 7, np.uint8), np.zeros(16_000, bool)
    assert vividc.simulate(program("threshold_mask"), pixels, 6, mask).value == 16_000
    assert mask.all()


@pytest.mark.parametrize("dtype", ["float64", "int64", "uint64", "complex128"])
def test_element_types_the_memory_does_not_hold(dtype: str) -> None:
    def nothing(x):
        pass

    with pytest.raises(KernelError, match="which the array cannot hold") as caught:
        vividc.kernel(f"void({dtype}[::1])")(nothing)
    assert "int16, uint16, int8, uint8, bool or complex64" in str(caught.value)
