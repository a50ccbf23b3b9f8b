"""Random kernels with a loop over `prange`, spread over sixteen tiles: against numba, which runs
the iterations one after the other.

Unlike those of `threads`, iterations may depend on each other, and the loop stands in conditions,
loops and behind returns: what is spread must be what one tile computes, whatever is written.
"""

from __future__ import annotations

import functools
import warnings
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from random import Random

import numpy as np

from tests.fuzz.arguments import Difference, compare
from tests.fuzz.beside import COLS, beside, makes, raising, returned, rows_of_made, wide_columns
from tests.fuzz.witnesses import Verdict, load, words_in_blocks
from vividc import arch
from vividc.arch import Accelerator
from vividc.errors import (
    ArgumentError,
    InternalError,
    KernelError,
    KernelRaised,
    VividcError,
    VividcWarning,
)
from vividc.frontend import KernelFunction
from vividc.launch import JobResult, SpreadOptions, spread
from vividc.program import Program
from vividc.ssa.parallel.cut import cut_parallel_loop

_SMALL = ("int8", "uint8", "bool", "int16", "uint16", "int32", "float32")

_HEAD = """import numpy as np
from numba import prange
import vividc


@vividc.kernel(
    "{result}(int32[::1], {small}[::1], {small}[::1], int32[::1], "
    "int32[:, ::1], int32[:, ::1], int32, int32)"
)
def program(x, a, b, y, v, w, n, m):
"""


class _Writer:
    """Statements of one kernel. `x`, `a` and `v` are read; `b`, `y` and `w` read and written."""

    def __init__(self, seed: int) -> None:
        self.random = Random(seed)
        self.lines: list[str] = []
        self.small = self.random.choice(_SMALL)
        self.before = self.random.random() < 0.2  # a local array made before the loop
        self.within = self.random.random() < 0.2
        self.sum = self.random.choice(["", "", "", "add", "max", "min", "xor", "sub", "wide"])
        # Shapes of access whose iterations meet are rare, or no kernel would be spread.
        self.meets = self.random.random() < 0.12
        more = Random(f"beside {seed}")  # apart, so that other lines stay as they were
        self.made = not self.sum and more.random() < 0.3
        self.more = more

    def source(self) -> str:
        """The module."""
        roll = self.random.random
        result = "int64" if self.sum == "wide" else "int32"
        returns = bool(self.sum) or roll() < 0.4
        if self.before:
            self._array_before()
        if roll() < 0.05:
            self.say(1, f"y[{self.pick('0', 'n', 'm & 3')}] = {self.integer('m')}")
        if self.made:
            self.say(1, makes(self.more))
        self._beside(1)
        if self.sum:
            start = self.pick("3", "0", "m", "-7") if self.sum == "wide" else None
            self.say(1, f"s = {start or self.pick('np.int32(3)', 'np.int32(0)', 'm')}")
        depth = self._around(returns)
        if depth > 1:
            self._beside(depth)
        self.say(depth, f"for i in prange({self._bounds()}):")
        self._body(depth + 1)
        self._beside(depth)
        if depth > 1 and roll() < 0.1 and self.lines[-1].strip():
            self.say(depth, f"y[m & 3] += {self.pick('1', 'x[0] & 7')}")
        if roll() < 0.05:
            self.say(1, f"y[{self.pick('n', '0', 'm & 3')}] = {self.integer('m')}")
        if self.made:
            value, result = returned(self.more)
            self.say(1, f"return {value}")
        elif returns:
            self.say(1, f"return {self._value()}")
        returns = returns or self.made
        head = _HEAD.format(result=result if returns else "void", small=self.small)
        return head + "\n".join(self.lines) + "\n"

    def say(self, depth: int, text: str) -> None:
        self.lines.append("    " * depth + text)

    def pick(self, *choices: str) -> str:
        return self.random.choice(choices)

    def _beside(self, depth: int) -> None:
        """Loops that do not contain the one over `prange`."""
        while self.more.random() < 0.2:
            for inner, text in beside(self.more, self.small, self.made):
                self.say(depth + inner, text)

    def _array_before(self) -> None:
        made = self.pick("zeros", "zeros", "empty", "ones")
        size = self.pick("8", "8", "len(x)", "n + 8")
        self.say(1, f"t = np.{made}({size}, np.int32)")
        if made == "empty" and self.random.random() < 0.8:
            self.say(1, "for k in range(len(t)):")
            self.say(2, f"t[k] = {self.pick('k', '0', 'x[k & 7] & 15')}")
        elif made == "empty":
            self.say(1, "t[:] = 5")

    def _around(self, returns: bool) -> int:
        """What the loop stands in; its depth."""
        kinds = ["", "", "", "if", "for", "return", "while", "else"]
        kind = self.random.choice(kinds if not self.sum else [*[""] * 9, *kinds])
        test = self.pick("m > 3", "n > 20", "m & 1 == 1", "x[0] > 50")
        if kind == "if":
            self.say(1, f"if {test}:")
        elif kind == "else":
            self.say(1, f"if {test}:")
            self.say(2, f"y[{self.pick('0', 'n')}] = {self.pick('5', 'm')}")
            self.say(1, "else:")
        elif kind == "for":
            self.say(1, f"for q in range({self.pick('m & 3', '2', 'm - 4', 'x[0] & 1')}):")
        elif kind == "while":
            self.say(1, "r = m")
            self.say(1, "while r > 3:")
            self.say(2, "r -= 2")
        elif kind == "return":
            self.say(1, f"if {test}:")
            early = " out" if self.made else f" {self.pick('7', 'm', '0')}" if returns else ""
            self.say(2, "return" + early)
        if kind == "for" and self.sum and self.random.random() < 0.3:
            self.say(2, "s = " + ("5" if self.sum == "wide" else "np.int32(5)"))
        return 2 if kind in ("if", "else", "for", "while") else 1

    def _bounds(self) -> str:
        last = self.pick("n", "n", "n", "n // 3", "n - 1", "(n + 1) // 2", "min(n, 37)", "n >> 1")
        last = self.pick(last, last, last, "len(x) // 2", "w.shape[0] - 8", "n // (m + 1)", "n - m")
        first = self.pick("", "", "", "1, ", "m, ", "n // 4, ", "x[0] & 1, ")
        if any(line.strip().startswith("for q") for line in self.lines):
            last = self.pick(last, last, last, "q", "n - q")
        return first + last

    def _body(self, depth: int) -> None:
        if self.within:
            self.say(depth, f"p = np.{self.pick('zeros', 'ones')}(4, np.int32)")
            self.say(depth, f"p[{self.pick('i & 3', 'x[i] & 3', '1')}] += {self.integer('i')}")
        if self.more.random() < 0.15:
            for inner, text in raising(self.more):
                self.say(depth + inner, text)
        for _ in range(self.random.randint(1, 3)):
            self._statement(depth)
        if self.made:
            row = self.more.choice(("i", "i", "i", "i", "i + 1", "n - 1 - i", "i // 2"))
            for inner, text in rows_of_made(self.more, row, self.integer("i")):
                self.say(depth + inner, text)
        if self.sum:
            if self.random.random() < 0.4:
                self.say(depth, f"if {self._condition()}:")
                depth += 1
            self.say(depth, self._step())

    def _step(self) -> str:
        term = self.integer("i")
        cast = "{}" if self.sum == "wide" else "np.int32({})"
        form = {
            "add": f"s + {term}",
            "wide": f"s + {term}",
            "sub": f"s - {term}",
            "xor": f"s ^ {term}",
            "max": f"max(s, {term})",
            "min": f"min(s, {term})",
        }[self.sum]
        if self.random.random() < 0.05:
            form = f"({form}) + s"
        return "s = " + cast.format(form)

    def _statement(self, depth: int) -> None:
        roll = self.random.random()
        if roll < 0.25:
            self.say(depth, f"if {self._condition()}:")
            depth += 1
        kind = self.random.random()
        if kind < 0.35:
            self._rows(depth)
        elif kind < 0.55:
            index = self._own("b")
            number = self.integer("i")
            if self.random.random() < 0.3:
                number = f"b[{index}]"
            value = {
                "bool": f"({number}) & 3 == 1",
                "float32": f"np.float32({number})",
            }.get(self.small, f"({number}) & 63")
            self.say(depth, f"b[{index}] = {value}")
        elif kind < 0.7 and self.before:
            index = self.pick("i & 7", "x[i] & 7", "i % len(t)", "0")
            if self.random.random() < 0.5 and "len(x)" in self.lines[0]:
                index = "i"
            self.say(depth, f"t[{index}] {self.pick('=', '+=')} {self.integer('i')}")
        else:
            self.say(depth, f"y[{self._own('y')}] {self.pick('=', '=', '+=')} {self.integer('i')}")

    def _rows(self, depth: int) -> None:
        """An inner loop over a row of `w`, or a column."""
        line = self.pick(
            f"for j in range({COLS}):",
            f"for j in range(1, {COLS} - 1):",
            f"for j in range({COLS} - 1, -1, -1):",
            f"for j in range(0, {COLS}, 2):",
            "for j in range(w.shape[1]):",
            "for j in range(m & 3):",
            f"for j in range(x[i] & 3, min(x[i] & 7, {COLS} - 1) + 1):",
            f"for j in range(min(x[i] & 7, {COLS} - 1), (x[i] & 3) - 1, -1):",
        )
        if self.more.random() < 0.2:
            line = wide_columns(self.more)
        self.say(depth, line)
        row = self.pick("i", "i", "i", "n - 1 - i") if not self.meets else self.pick("i", "i // 2")
        number = self.pick("v[i, j]", "v[max(i - 1, 0), j]", "w[i, j] + j", f"v[i, {COLS - 1} - j]")
        number = self.pick(number, number, "v[(i + 1) % v.shape[0], j]", "v[x[i] & 7, j] + i")
        self.say(depth + 1, f"w[{row}, j] = {number} + {self.pick('m', 'i', 'x[i]')}")
        if self.random.random() < 0.1:
            self.say(depth + 1, "if w[i, j] > 90:")
            self.say(depth + 2, "break")

    def _own(self, array: str) -> str:
        """An index of what an iteration writes."""
        if self.meets and self.random.random() < 0.6:
            return self.pick("x[i] & 7", "i // 2", "m & 3", "(3 * i) % (n + 1)", "i & 7", "i % 5")
        if not hasattr(self, "form"):
            self.form = self.pick("i", "i", "i", "i + 1", "n - 1 - i", "2 * i", "2 * i + 1")
            self.form = self.pick(self.form, self.form, self.form, f"len({array}) - 1 - i", "i + m")
        return self.form.replace("len(b)", f"len({array})").replace("len(y)", f"len({array})")

    def integer(self, index: str) -> str:
        """An integer of at most 16 bits."""
        if index != "i":
            return self.pick("m", "5", "x[0]", "n")
        forms = [
            "x[i]",
            "x[max(i - 1, 0)] + x[i]",
            "x[n - 1 - i]",
            "x[i // 2]",
            "x[(i * 7) % (n + 1)]",
            "x[x[i] & 7]",
            "np.int32(a[i]) + 1",
            "np.int32(a[len(a) - 1 - i]) * 2",
            "v[i, 2]",
            f"v[i, i % {COLS}]",
            "v[i & 7, 0]",
            "i",
            "m + i",
        ]
        if self.before:
            forms += ["t[i & 7]", "t[x[i] & 7] + i", "t[i % len(t)]"]
        if self.within:
            forms += ["p[i & 3]"] * 2
        if self.random.random() < 0.03:
            forms = ["y[i]", "y[n - 1 - i]", "y[0]", "w[i, 0]", "w[0, 1]"]
        return f"(({self.random.choice(forms)}) & 1023)"

    def _condition(self) -> str:
        return self.pick("x[i] > 40", "i & 1 == 0", "m > 2", "np.int32(a[i]) > 3", "i > 4", "i < m")

    def _value(self) -> str:
        if self.sum:
            return self.pick(*["s"] * 12, "s + 1", "s * m", "y[0]")
        forms = ["m", "n + 1", "x[m]", "x[n]", "m * n", self.pick("y[m & 3]", "m", "w[0, 0]", "n")]
        if self.before:
            forms += ["t[0]", "t[0] + t[len(t) - 1]", "t[m & 7]"] * 2
        return self.random.choice(forms)


def random_spread_source(seed: int) -> str:
    """A module whose `program` is a kernel with a loop over `prange`."""
    return _Writer(seed).source()


def _arguments(kernel: KernelFunction, seed: int, trial: int) -> list[object]:
    """Random arguments: many iterations, few or none, some hundreds; more than a scratchpad."""
    rng = np.random.default_rng([seed, trial])
    n = int(rng.integers(*((20, 80), (1, 4), (100, 500), (4000, 6000), (0, 40))[trial]))
    dtype = np.dtype(str(kernel.params[1].dtype.value))
    low, high = (0, 2) if dtype == np.bool_ else (0 if dtype.kind == "u" else -50, 100)
    length = 2 * n + 40
    return [
        rng.integers(0, 100, length).astype(np.int32),
        rng.integers(low, high, length).astype(dtype),
        rng.integers(low, high, length).astype(dtype),
        rng.integers(-9, 99, length).astype(np.int32),
        rng.integers(-9, 99, (n + 24, COLS)).astype(np.int32),
        rng.integers(-9, 99, (n + 24, COLS)).astype(np.int32),
        np.int32(n),
        np.int32(rng.integers(0, 9)),
    ]


def _programs(kernel: KernelFunction, wants_one: bool) -> tuple[Program | None, Program | None]:
    """The kernel for one tile if that is wanted, or for all if its loop is proved to be spread."""
    try:
        function, parallel = cut_parallel_loop(kernel.lower(spread=True), kernel.prange_lines)
    except KernelError:
        return words_in_blocks(kernel.lower()) if wants_one else None, None
    return None, replace(words_in_blocks(function), parallel=parallel)


def _launched(program: Program, args: list[object], chunk: int | None) -> JobResult | None:
    """None: not so many bytes."""
    try:
        return spread(program, args, {}, _machine(), SpreadOptions(chunk=chunk)).simulate(threads=1)
    except ArgumentError as error:
        if "bytes of a scratchpad" in error.reason or "the same bytes" in error.reason:
            return None
        raise


@functools.cache
def _machine() -> Accelerator:
    return arch.load_accelerator("vivid")


def judge_spread(source: str, seed: int, folder: Path) -> Verdict:
    """Whether all tiles, and one, do what numba does; `text` of one that agrees is how it ran."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", VividcWarning)
            return _judged(load(source, folder).program, seed)
    except Difference as found:
        return Verdict("differs", str(found)[:2000])
    except (InternalError, AssertionError, LookupError, TypeError, ValueError) as error:
        return Verdict("crashes", f"{type(error).__name__}: {error}")
    except VividcError as error:
        return Verdict("refused", error.reason)


def _judged(kernel: KernelFunction, seed: int) -> Verdict:
    random = Random(seed)
    alone, wide = _programs(kernel, random.random() < 0.15)
    if wide is None:
        if alone is not None:
            _compare(kernel, alone, seed, 0, None)
        return Verdict("agrees", "one tile")
    if random.random() < 0.2:
        _compare(kernel, wide, seed, 0, 1000)
    if random.random() < 0.3:
        sized = _programs(kernel.sized(_arguments(kernel, seed, 0)), wants_one=True)
        for program in sized:
            if program is not None:
                _compare(kernel, program, seed, 0, None)
    most = 0
    for trial in range(5 if random.random() < 0.3 else 3):
        length = random.choice([None, 1, 2, 3, 5, 7, 19])
        most = max(most, _compare(kernel, wide, seed, trial, length))
    return Verdict("agrees", "spread" if most > 1 else "iterations meet")


def _compare(
    kernel: KernelFunction, program: Program, seed: int, trial: int, length: int | None
) -> int:
    """A launch against numba; how many chunks it had, 0 if it does not fit."""
    args = _arguments(kernel, seed, trial)
    count = int(args[6])  # type: ignore[call-overload]
    chunk = None if length is None else max(length, count // 24)
    expected, mine = deepcopy(args), deepcopy(args)
    raised = ""
    try:
        value = kernel(*expected)
    except (ValueError, IndexError, ZeroDivisionError) as error:
        raised = f"{type(error).__name__}: {error}"
    try:
        result = _launched(program, mine, chunk)
    except KernelRaised as error:
        if raised.rstrip(": ") != error.reason:
            raise Difference(f"raises {error.reason}, and numba {raised or 'nothing'}") from error
        return 0
    if result is None:
        return 0
    if raised:
        raise Difference(f"raises nothing, and numba {raised}")
    tiles = len(result.stats["tiles"])
    what = f"{tiles} tiles, chunk {chunk}, trial {trial}"
    compare(what, [result.value, *mine], [value, *expected])
    return result.stats["runs"]
