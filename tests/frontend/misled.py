"""Kernels that numba compiles by means a user wrote nothing of; `# here` marks the line."""

import numba
import numpy as np

from tests.frontend.mistake_registry import mistake


@numba.njit
def even(n):
    return 1 if n == 0 else odd(n - 1)  # here: recursion


@numba.njit
def odd(n):
    return 0 if n == 0 else even(n - 1)


@numba.njit
def square(v):
    return v * v


@numba.njit
def cube(v):
    return v * v * v


FUNCTIONS = (square, cube)


@mistake(r"`np\.moveaxis` cannot run", "exchanged")
def moveaxis(x, n):
    y = x.reshape((2, 4))
    x[0] = np.moveaxis(y, 0, 1)[n, 0]  # here


@mistake(r"`np\.isin` cannot run", "loop")
def isin(x, n):
    x[n] = np.isin(x, x)[0]  # here


@mistake(r"numba has no `np\.tile`", "fill it in a loop")
def tile(x, n):
    x[n] = np.tile(x, 2)[0]  # here


@mistake(r"`map` cannot run", "loop")
def maps(x, n):
    for v in map(abs, x):  # here
        x[n] += v


@mistake("recursive call", "stack")
def mutual_recursion(x, n):  # see: recursion
    x[0] = even(n)


@mistake("function", "if and elif")
def function_of_a_tuple(x, n):
    x[0] = FUNCTIONS[0](x[n])  # here


@mistake("the functions square and cube", "if and elif")
def function_picked(x, n):
    for i in range(n):
        x[i] = FUNCTIONS[i](x[i])  # here


@mistake(r"`\.tolist`", "loops")
def tolist(x, n):
    x[0] = x.tolist()[n]  # here
