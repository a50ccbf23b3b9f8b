"""Kernels that ask for what an array cannot do; `# here` marks the line of the error."""

import math

import numba
import numpy as np

from tests.frontend.mistake_registry import mistake
from vividc import lang

TABLE = np.arange(4, dtype=np.float32)
SMALL = np.array([1e-300, 2 / 3])
HUGE = np.array([1, 2**40], np.int64)
SETTINGS = {"scale": 2}
NAMES = ["a", "b"]


def plain(v):
    return v + 1


@numba.njit
def factorial(n):
    return 1 if n < 2 else n * factorial(n - 1)


@mistake("a dict", "array")
def dict_display(x, n):
    d = {1: 2}  # here
    x[0] = d[n]


@mistake("a dict", "array")
def dict_call(x, n):
    d = dict()  # here
    d[n] = 1
    x[0] = d[n]


@mistake("a set", "np.bool_")
def set_display(x, n):
    s = {1, 2}  # here
    if n in s:
        x[0] = 1


@mistake("a generator expression", "loop")
def generator_expression(x, n):
    x[0] = sum(i for i in range(n))  # here


@mistake("a string", "integers")
def string(x, n):
    name = "a" + str(n)  # here
    x[0] = len(name)


@mistake("a string", "integers")
def formatted_string(x, n):
    x[0] = len(f"{n} items")  # here


@mistake("`print`", "array")
def prints(x, n):
    print(x[n])  # here


@mistake("`try`", "test the condition")
def catches(x, n):
    try:  # here
        x[0] = n
    except Exception:
        x[1] = n


@mistake("`with`", "around the kernel")
def with_statement(x, n):
    with open("file"):  # here
        x[0] = n


@mistake("`del`", "no deletion")
def deletes(x, n):
    del x[n]  # here


@mistake("`yield`", "into an array")
def generates(x, n):
    for i in range(n):
        yield x[i]  # here


@mistake("a class", "one for each field")
def defines_a_class(x, n):
    class Point:  # here
        pass

    x[0] = n


@mistake("`import`", "top of the file")
def imports(x, n):
    import math as m  # here  # noqa: PLC0415

    x[0] = m.sqrt(n)


@mistake("`global`", "return the value")
def writes_a_global(x, n):
    global counter  # here  # noqa: PLW0603
    counter = n
    x[0] = counter


@mistake("a recursive call", "array as its stack")
def recurses_in_helper(x, n):
    x[0] = factorial(n)  # here: any


@mistake("`plain` is a plain Python function", "numba.njit")
def plain_function(x, n):
    x[0] = plain(n)  # here


@mistake("`SETTINGS` is a dict", "parameters")
def global_dict(x, n):
    x[0] = SETTINGS["scale"]  # here: any


@mistake("`NAMES` is not a number, tuple or array", "tuple")
def global_list(x, n):
    x[0] = len(NAMES[n])  # here: any


@mistake("`unknown_name_of_nothing` is not defined", "import")
def unknown_name(x, n):
    x[0] = unknown_name_of_nothing(n)  # here  # noqa: F821


@mistake("frobnicate", "")
def unknown_attribute(x, n):
    x.frobnicate(n)  # here


@mistake("`reversed`", "count down")
def reversed_range(x, n):
    for i in reversed(range(n)):  # here
        x[i] = 1


@mistake("size is not known at launch", "shapes and scalar parameters")
def dynamic_size(x, n):
    a = np.zeros(int(x[n]), np.float32)  # here
    for i in range(n):
        a[i] = x[i]
    x[0] = a[0]


@mistake("does not fit float32", "scale")
def huge_element(x, n):
    a = np.zeros(4)
    a[n] = 1e300  # here
    x[0] = np.float32(a[0])


@mistake("kept for the next iteration", "before the loop")
def array_kept(x, n):
    a, b, c = x + 1, x + 2, x + 3
    d, e, f = x + 4, x + 5, x + 6
    for i in range(n):
        if x[i] > 0:
            a, b = b, a
        elif x[i] > 1:
            b, c, d = c, d, b
        else:
            e, f, a = a, e, f  # here: any
            b = x * 2  # here
    x[0] = a[0] + b[0] + c[0] + d[0] + e[0] + f[0]


@mistake("different arrays, chosen by a condition", "in each branch")
def array_chosen(x, n):
    a, b, c = np.ones(4, np.float32), np.ones(4, np.float32), np.ones(4, np.float32)
    d, e, f = np.ones(4, np.float32), np.ones(4, np.float32), np.ones(4, np.float32)
    for i in range(n):
        if x[i] > 0:
            a, b = b, a  # here: any
        elif x[i] > 1:
            b, c, d = c, d, b
        else:
            e, f, a = a, e, f
        a[0] += x[i]
    x[0] = a[0] + b[0] + c[0] + d[0] + e[0] + f[0]


@mistake("holds 1e.*-300, which float32 cannot hold", "scale them")
def doubles_in_table(x, n):
    for i in range(n):
        x[i] = SMALL[i & 1]  # here


@mistake("do not fit in 32 bits", "int32")
def longs_in_table(x, n):
    for i in range(n):
        x[i] = HUGE[i & 1]  # here


@mistake("a write to a global array", "parameter")
def writes_a_table(x, n):
    TABLE[n] = x[0]  # here


@mistake("never ends", "break|condition")
def endless(x, n):
    while True:  # here: any
        x[0] += 1


@mistake("lgamma", "")
def unknown_math(x, n):
    for i in range(n):
        x[i] = math.lgamma(x[i])  # here


@mistake("linear algebra", "loops")
def inverse(x, n):
    np.linalg.inv(x)  # here
    x[0] = n


@mistake("axis out of bounds", "an axis that")
def sum_along_no_axis(x, n):
    m = np.zeros((4, 4), np.float32)
    x[:4] = m.sum(axis=2)  # here: any


@mistake("lang.fp8 of an array of float32", "one number")
def cast_of_an_array(x, n):
    x[0] = np.float32(lang.fp8(x))  # here


@mistake("`float16` and `float32` in one operation", "cast one")
def two_formats(x, n):
    x[0] = np.float32(lang.fp16(x[1]) + x[0])  # here


@mistake("`float16` and `float8 E4M3` in one operation", "lang.fp16")
def two_narrow_formats(x, n):
    x[0] = np.float32(lang.fp16(x[1]) * lang.fp8(x[0]))  # here


@mistake("numba has no `int.lang.fp16.`", "np.float32.x.")
def integer_of_a_half(x, n):
    x[int(lang.fp16(x[1]))] = np.float32(0)  # here


@mistake("np.float16 in a kernel", "lang.fp16")
def array_of_halves(x, n):  # here: any
    values = np.zeros(4, np.float16)
    x[0] = np.float32(values[1])


@mistake("stored into an array of another format", "cast it")
def stored_without_a_cast(x, n):
    x[0] = lang.fp8(x[1])  # here


@mistake("a variable that holds numbers of two formats", "cast where it is assigned")
def variable_of_two_formats(x, n):
    total = np.float32(0)
    if n > 3:
        total = lang.fp16(x[0])
    x[0] = np.float32(total)  # here: any


@mistake("math.exp of float16", "np.float32")
def exp_of_a_half(x, n):
    x[0] = np.float32(math.exp(lang.fp16(x[0])))  # here


@mistake("`/` of float8 E5M2", "np.float32")
def quotient_of_bytes(x, n):
    x[0] = np.float32(lang.e5m2(x[0]) / lang.e5m2(x[1]))  # here
