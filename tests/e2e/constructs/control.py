"""Loops, conditions and expressions."""

import numba
import numpy as np

from tests.e2e.constructs.registry import A, construct, floats, words


@construct("void(int32[::1])", A)
def range_one(x):
    for i in range(len(x)):
        x[i] += 1


@construct("void(int32[::1])", A)
def range_two(x):
    for i in range(2, 6):
        x[i] = i


@construct("void(int32[::1])", A)
def range_three(x):
    for i in range(1, len(x), 3):
        x[i] = -1


@construct("void(int32[::1])", A)
def range_down(x):
    for i in range(len(x) - 2, -1, -1):
        x[i] += x[i + 1]


@construct("void(int32[::1], int32)", A, 3)
def range_variable_step(x, step):
    if step < 1:
        return
    for i in range(0, len(x), step):
        x[i] = 0


@construct("void(int32[::1])", A, mapped=True)
def prange(x):
    for i in numba.prange(len(x)):
        x[i] *= 2


@construct("int32(int32[::1])", A)
def for_over_array(x):
    total = np.int32(0)
    for value in x:
        total += value
    return total


@construct("void(int32[::1], int32[::1])", A, A[::-1].copy(), mapped=True)
def for_enumerate(x, y):
    for i, value in enumerate(x):
        y[i] = value + i


@construct("void(int32[::1], int32[::1])", A, words(1, 1, 1, 1, 1, 1, 1, 1))
def for_enumerate_start(x, y):
    for i, value in enumerate(x, 1):
        y[i - 1] = value * i


@construct("int32(int32[::1], int32[::1])", A, A[::-1].copy(), mapped=True)
def for_zip(x, y):
    total = np.int32(0)
    for a, b in zip(x, y):  # noqa: B905 - numba knows no `strict`
        total += a * b
    return total


@construct("int32(int32[::1], int32[::1])", A, A[:3].copy())
def for_zip_unequal(x, y):
    count = 0
    for _a, _b in zip(x, y):  # noqa: B905 - numba knows no `strict`
        count += 1
    return np.int32(count)


@construct("void(int32[:, ::1])", np.arange(12, dtype=np.int32).reshape(3, 4))
def for_over_rows(m):
    for row in m:
        for j in range(len(row)):
            row[j] += 1


@construct("int32(int32[::1], int32)", A, 8, mapped=True)
def for_else(x, wanted):
    for i in range(len(x)):
        if x[i] == wanted:
            found = i
            break
    else:
        found = -1
    return np.int32(found)


@construct("int32(int32[::1], int32)", A, 77)
def for_else_missing(x, wanted):
    for i in range(len(x)):
        if x[i] == wanted:
            return np.int32(i)
    return np.int32(-1)


@construct("int32(int32)", 100)
def while_else(n):
    steps = 0
    while n > 1:
        n >>= 1
        steps += 1
        if steps > 20:
            break
    else:
        steps += 1000
    return np.int32(steps)


@construct("int32(int32[::1])", A, mapped=True)
def while_true(x):
    i = 0
    while True:
        if x[i] == 0:
            break
        i += 1
    return np.int32(i)


@construct("int32(int32[::1])", A)
def while_condition(x):
    i = 0
    while i < len(x) and x[i] != -9:
        i += 1
    return np.int32(i)


@construct("int32(int32[::1])", A)
def loop_continue(x):
    total = np.int32(0)
    for i in range(len(x)):
        if x[i] < 0:
            continue
        total += x[i]
    return total


@construct("int32(int32[::1])", A)
def chained_comparison(x):
    count = 0
    for i in range(len(x)):
        if -4 < x[i] <= 5:
            count += 1
    return np.int32(count)


@construct("void(int32[::1])", A, mapped=True)
def conditional_expression(x):
    for i in range(len(x)):
        x[i] = x[i] if x[i] > 0 else -x[i]


@construct("void(int32[::1])", A)
def elif_chain(x):
    for i in range(len(x)):
        v = x[i]
        if v < -5:
            x[i] = 0
        elif v < 0:
            x[i] = 1
        elif v == 0:
            x[i] = 2
        else:
            x[i] = 3


@construct("int32(int32[::1], bool)", A, True)
def boolean_logic(x, flag):
    count = 0
    for i in range(len(x)):
        if (x[i] > 0 and not flag) or (x[i] < 0 and flag):
            count += 1
    return np.int32(count)


@construct("int32(int32)", 6)
def or_value(n):
    return np.int32((n - 6) or 5)


@construct("int32(int32)", 6)
def truth_of_integer(n):
    return np.int32(1) if n & 2 else np.int32(2)


@construct("bool(int32[::1])", A)
def return_bool(x):
    return x[0] > x[1]


@construct("float32(float32[::1])", floats(9))
def return_float(x):
    best = x[0]
    for i in range(1, len(x)):
        best = max(best, x[i])
    return best


@construct("int32(int32)", 4)
def early_return(n):
    if n < 3:
        return np.int32(1)
    if n < 5:
        return np.int32(2)
    return np.int32(3)


@construct("void(int32[::1])", A)
def return_nothing(x):
    if x[0] == 5:
        x[1] = 99
        return
    x[2] = 99


@construct("void(int32[::1])", A)
def parallel_assignment(x):
    a, b = np.int32(0), np.int32(1)
    for i in range(len(x)):
        x[i] = a
        a, b = b, a + b


@construct("void(int32[::1])", A)
def swap_elements(x):
    n = len(x)
    for i in range(n // 2):
        x[i], x[n - 1 - i] = x[n - 1 - i], x[i]


@construct("void(int32[::1])", A)
def multiple_targets(x):
    a = b = x[3]
    x[0] = a
    x[1] = b


@construct("void(int32[::1])", A)
def augmented_all(x):
    x[0] += 2
    x[1] -= 2
    x[2] *= 3
    x[3] |= 6
    x[4] &= 3
    x[5] ^= 15
    x[6] <<= 2
    x[7] >>= 1


@construct("void(float32[::1])", floats(5))
def augmented_divide(x):
    for i in range(len(x)):
        x[i] /= 4


@construct("void(int32[::1])", A)
def pass_and_docstring(x):
    """A docstring."""
    for _ in range(3):
        pass
    x[0] = 1


@construct("int32(int32[::1])", A)
def nested_functions_of_loops(x):
    count = 0
    for i in range(len(x)):
        for j in range(i):
            if x[j] > x[i]:
                count += 1
            else:
                continue
            if count > 20:
                break
    return np.int32(count)


@construct("int32(int32)", 3)
def match_statement_as_ifs(n):
    kind = 0
    if n in (1, 3, 5):
        kind = 1
    return np.int32(kind)


@construct("void(int32[::1], float32)", A, 1.5)
def variable_changes_type(x, f):
    v = 3
    v = v + f
    x[0] = np.int32(v * 2)


@construct("int32(int32[::1])", A)
def loop_variable_after_loop(x):
    for i in range(len(x)):
        if x[i] == 7:
            break
    return np.int32(i)


@construct("int32(int32[::1])", A)
def assert_that_holds(x):
    total = np.int32(0)
    for i in range(len(x)):
        assert i >= 0
        total += x[i]
    return total
