"""Kernels that the accelerator's tests run; each is compiled once."""

from __future__ import annotations

import functools

import numpy as np

import vividc
from vividc.frontend import KernelFunction
from vividc.program import Program


@vividc.kernel("void(float32[::1], float32[::1], int32)")
def saxpy(x, y, n):
    for i in range(n):
        y[i] += np.float32(2.0) * x[i]


@vividc.kernel("void(int32[::1], int32)")
def double(x, n):
    for i in range(n):
        x[i] = x[i] + x[i]


@vividc.kernel("int32(int32[::1])")
def total(x):
    result = np.int32(0)
    for i in range(x.shape[0]):
        result += x[i]
    return result


@functools.cache
def program(kernel: KernelFunction) -> Program:
    """The kernel's program for the tiles of `vivid`."""
    return vividc.compile(kernel, fabric="vivid", time_limit_s=20)
