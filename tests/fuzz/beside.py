"""Loops before and after the one over `prange`, and arrays that a kernel makes and returns: lines
of random kernels for `spreads`.
"""

from __future__ import annotations

from collections.abc import Iterator
from random import Random

COLS = 5
"""Columns of the matrices."""
_MADE = (
    "np.zeros((n + 24, {cols}), np.int32)",
    "np.zeros((n + 24, {cols}), np.int32)",
    "np.full((w.shape[0], {cols}), np.int32(7))",
    "np.ones(w.shape, np.int32)",
    "np.zeros_like(w)",
    "np.full_like(v, m)",
    "w.copy()",
    "np.zeros(w.shape[0] * 2, np.int32).reshape(w.shape[0], 2)",
    "(v + m).astype(np.int32)",
)
_RETURNED = (
    "out",
    "out",
    "out",
    "(out * 2).astype(np.int32)",
    "(out + out[:1]).astype(np.int32)",
    "np.maximum(out, np.int32(0))",
    "out[1:]",
    "out, y[m & 3]",
    "out, w",
)


def makes(random: Random) -> str:
    """The line that makes the array `out`; at least two columns."""
    return f"out = {random.choice(_MADE).format(cols=COLS)}"


def returned(random: Random) -> tuple[str, str]:
    """What is returned of `out`, and its type."""
    value = random.choice(_RETURNED)
    kind = {"out, y[m & 3]": "Tuple((int32[:, ::1], int32))"}.get(value, "int32[:, ::1]")
    return value, "Tuple((int32[:, ::1], int32[:, ::1]))" if value == "out, w" else kind


def rows_of_made(random: Random, row: str, value: str) -> Iterator[tuple[int, str]]:
    """Lines in an iteration of the loop, with their depth, that write a row of `out`."""
    sign = random.choice(("=", "=", "+="))
    columns = random.choice(("out.shape[1]", "2", "out.shape[1] - 1"))
    if random.random() < 0.3:
        yield 0, f"out[{row}, 0] {sign} {value}"
        yield 0, f"out[{row}, 1] {random.choice(('=', '-='))} {value} + 1"
        return
    if random.random() < 0.2:
        yield 0, f"out[{row}] = {value}"
        return
    yield 0, f"for c in range({columns}):"
    if random.random() < 0.3:
        yield 1, f"if {value} & 3 > c:"
        yield 2, f"out[{row}, c] {sign} {value} + c"
    else:
        yield 1, f"out[{row}, c] {sign} {value} + c"


def beside(random: Random, small: str, made: bool) -> Iterator[tuple[int, str]]:
    """A loop, or a whole array assigned: lines with their depth."""
    kinds = ["words", "words", "rows", "rows", "small", "slices"]
    kind = random.choice([*kinds, *["made"] * 3] if made else kinds)
    step = random.choice(("=", "=", "=", "+="))
    head = random.choice(("range", "range", "range", "prange"))
    if kind == "slices":
        forms = ("y[:] = 3", "y[:n] = x[:n]", "w[:] = v", "w[:, :] = m", "w[1:, :2] = v[:-1, :2]")
        yield 0, random.choice(forms)
    elif kind == "words":
        last = random.choice(("n", "n", "len(y)", "len(x) - 1", "n - m", "m", "(n + 1) // 2"))
        places, values = ["k", "k", "k", "n - 1 - k", "k // 2", "x[k] & 7"], ["x[k]", "x[k] + m"]
        values += ["k", "5", "y[k] & 255", "x[len(x) - 1 - k]", "v[k // 2, 0]"]
        if "len" not in last:
            places, values = [*places, "k + 1", "2 * k"], [*values, "w[k, 1] & 63"]
        place, value = random.choice(places), random.choice(values)
        yield 0, f"for k in {head}({last}):"
        if random.random() < 0.2:
            yield 1, "if x[k] > 30:"
            yield 2, f"y[{place}] {step} {value}"
        else:
            yield 1, f"y[{place}] {step} {value}"
        if random.random() < 0.1:
            yield 1, "y[0] = k"
    elif kind == "small":
        value = {"bool": "x[k] > 9", "float32": "np.float32(k)"}.get(small, "x[k] & 63")
        yield 0, f"for k in {head}({random.choice(('n', 'len(b)', 'm, n'))}):"
        yield 1, f"b[k] = {value}"
    else:
        array = "out" if kind == "made" else "w"
        value = random.choice(("v[k, 0] + m", "k", f"{array}[k, 1] + 1", "w[k, 0] & 127", "9"))
        last = random.choice(("w.shape[0]", "n", "n + 3", "1, n"))
        yield 0, f"for k in {head}({last}):"
        yield 1, f"for c in range({random.choice((f'{array}.shape[1]', '2', '1, 2'))}):"
        row = "k" if last == "w.shape[0]" else random.choice(("k", "k", "k", "k + 1"))
        yield 2, f"{array}[{row}, c] {step} {value}"


def raising(random: Random) -> Iterator[tuple[int, str]]:
    """What an iteration does that may raise: a user's exception, or one of rows that must be of one
    size, which they are.
    """
    kind = random.choice(("raise", "raise", "unpack", "sum", "dot"))
    if kind == "raise":
        test = random.choice(("x[i] > 97", "x[i] == 50 + m", "i == n - 1", "v[i, 1] > 97"))
        error = random.choice(("ValueError", "IndexError", "ZeroDivisionError"))
        yield 0, f"if {test}:"
        yield 1, f'raise {error}("{test}")'
    elif kind == "unpack":
        names = [f"part{n}" for n in range(COLS)]
        yield 0, f"{', '.join(names)} = v[i]"
        yield 0, f"w[i, {random.randrange(COLS)}] = {' + '.join(random.sample(names, 2))}"
    elif kind == "sum":
        yield 0, "w[i] = v[i] - w[i]"
    else:
        yield 0, f"w[i, 0] = np.sum(v[i] * v[i, {random.randrange(COLS)}])"


def wide_columns(random: Random) -> str:
    """A loop over columns whose ends are sums of 64 bits."""
    forms = (
        f"range(m, {COLS} - m)",
        f"range(max(m - 9, -{COLS}), min(m + 1, {COLS}))",
        f"range(min(m + 1, {COLS}))",
        f"range(max(m - 4, -{COLS}), 1)",
        f"range({COLS} - 1 - (m >> 2), {COLS})",
    )
    return f"for j in {random.choice(forms)}:"
