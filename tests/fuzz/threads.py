"""Random kernels with a loop over `prange`, whose iterations run as threads: against numba, and
against the kernel as written to the bit.

An iteration writes its own elements only, and reads those and arrays that nobody writes. In it are
nested loops whose lengths depend on data, exits, and an array of its own. With a loop over `range`
instead, iterations may also touch each other's elements: they run side by side where they prove
not to.
"""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path
from random import Random

import numpy as np

import vividc
from tests.fuzz.arguments import Difference, compare
from tests.fuzz.forms import OPTIONS, at_random
from tests.fuzz.witnesses import load, run_regions, words_in_blocks
from vividc.dfg.cut.build import build_kernel
from vividc.dfg.pipeline import optimize_kernel
from vividc.frontend import KernelFunction
from vividc.ssa.check import check_function
from vividc.ssa.edit import block_of
from vividc.ssa.flow import find_loops
from vividc.ssa.ir import Function
from vividc.ssa.loops.threads.make import thread
from vividc.ssa.parallel.independent import meeting_array
from vividc.ssa.rewrite.normalize import normalize
from vividc.ssa.rewrite.refusal import Refusal
from vividc.ssa.rewrite.tidy import tidy

LOADED = 64
"""Elements of the arrays that nobody writes; indices are cut to them."""

_HEAD = """import numpy as np
from numba import prange
import vividc


@vividc.kernel(
    "{result}(int32[::1], float32[::1], int32[::1], float32[::1], int32[:, ::1], int32, int32)"
)
def program(x, u, y, v, w, n, m):
"""


class _Writer:
    """Statements of one kernel."""

    def __init__(self, seed: int, loop: str = "prange") -> None:
        self.random = Random(seed)
        self.loop_over = loop
        self.is_apart = loop == "prange" or self.random.random() < 0.7
        self.lines: list[str] = []
        self.counters = 0
        self.own_array = self.random.random() < 0.25

    def source(self) -> str:
        """The module."""
        random = self.random
        kind = random.choice(["", "", "", "sum", "largest", "float"])
        result = {"": "void", "float": "float32"}.get(kind, "int32")
        start = random.choice(["0", "0", "1", "m & 3"])
        bound = random.choice(["n", "n", "n", "8", "y.shape[0] // 4"])
        self.say(1, "total = " + ("np.float32(0.5)" if kind == "float" else "np.int32(3)"))
        outer = 1
        if random.random() < 0.15 and not kind:
            self.say(1, "for s in range(m & 3):")
            outer = 2
        self.say(
            outer,
            f"for i in {self.loop_over}({start + ', ' if start != '0' else ''}{bound}):",
        )
        inside = outer + 1
        for name in "abc":
            self.say(
                inside, f"{name} = np.int32({random.choice(['i', 'm', '5', 'x[i & 63] & 15'])})"
            )
        for name in "fg":
            self.say(inside, f"{name} = np.float32({random.choice(['i', '0.25', 'u[i & 63]'])})")
        if self.own_array:
            self.say(inside, "t = np.empty(4, np.int32)")
            for index in range(4):
                self.say(inside, f"t[{index}] = np.int32((b + {index}) & 7)")
        self.block(inside, 3, loops=())
        self.store(inside)
        if kind:
            step = {
                "sum": "total = np.int32(total + (a & 255))",
                "largest": "total = max(total, a)",
                "float": "total += f",
            }[kind]
            if random.random() < 0.4:
                self.say(inside, f"if {self.condition()}:")
                inside += 1
            self.say(inside, step)
        if kind:
            self.say(1, "return total")
        return _HEAD.format(result=result) + "\n".join(self.lines) + "\n"

    def say(self, depth: int, text: str) -> None:
        self.lines.append("    " * depth + text)

    def block(self, depth: int, budget: int, loops: tuple[str, ...]) -> None:
        """Some statements; `loops` are the counters of the loops around."""
        for _ in range(self.random.randint(1, 1 + budget)):
            self.statement(depth, budget, loops)

    def statement(self, depth: int, budget: int, loops: tuple[str, ...]) -> None:
        roll = self.random.random()
        if roll < 0.22 and budget > 0:
            self.loop(depth, budget - 1, loops)
        elif roll < 0.42 and budget > 0:
            self.branch(depth, budget - 1, loops)
        elif roll < 0.5 and loops:
            self.say(depth, f"if {self.condition()}:")
            if self.random.random() < 0.4:
                self.assign(depth + 1)
            # a `while` counts at its end
            words = ["break"] if loops[-1].startswith("q") else ["break", "continue"]
            self.say(depth + 1, self.random.choice(words))
        elif roll < 0.6:
            self.store(depth)
        else:
            self.assign(depth)

    def loop(self, depth: int, budget: int, loops: tuple[str, ...]) -> None:
        self.counters += 1
        if self.random.random() < 0.6:
            name = f"k{self.counters}"
            bound = self.random.choice(
                ["m", "3", f"{self.integer()} & 7", "x[i & 63] & 7", "m & 7"]
            )
            start = self.random.choice(["", "", "", "1, ", "a & 1, "])
            self.say(depth, f"for {name} in range({start}{bound}):")
            self.block(depth + 1, budget, (*loops, name))
            if self.random.random() < 0.3:
                self.say(depth + 1, f"b = np.int32({name} + (b & 31))")
            return
        name = f"q{self.counters}"
        self.say(depth, f"{name} = np.int32(0)")
        test = f"{name} < ({self.integer()} & 7)" if self.random.random() < 0.5 else f"{name} < m"
        if self.random.random() < 0.4:
            test += f" and {self.condition()}"
        self.say(depth, f"while {test}:")
        self.block(depth + 1, budget, (*loops, name))
        step = self.random.choice(["1", "1", "1 + (a & 1)", "1 + (x[(b + i) & 63] & 3)"])
        self.say(depth + 1, f"{name} = np.int32({name} + {step})")

    def branch(self, depth: int, budget: int, loops: tuple[str, ...]) -> None:
        self.say(depth, f"if {self.condition()}:")
        self.block(depth + 1, budget, loops)
        if self.random.random() < 0.5:
            self.say(depth, "else:")
            self.block(depth + 1, budget, loops)

    def assign(self, depth: int) -> None:
        if self.random.random() < 0.6:
            name = self.random.choice("abc")
            self.say(depth, f"{name} = np.int32({self.integer()})")
        else:
            name = self.random.choice("fg")
            self.say(depth, f"{name} = {self.real()}")

    def store(self, depth: int) -> None:
        place = self.random.choice(["0", "1", "2", "3", "(a & 3)"])
        own = self.own(place)
        stores = [
            f"y[{own}] = {self.integer()}",
            f"y[{own}] += np.int32(b & 7)",
            f"v[{own}] = {self.real()}",
            f"w[i, {place}] = {self.integer()}",
        ]
        if not self.is_apart:
            stores += [f"y[4 * i + {place} + 1] = {self.integer()}", f"w[a & 3, i & 3] = {place}"]
        if self.own_array:
            stores.append(f"t[{place}] = {self.integer()}")
        self.say(depth, self.random.choice(stores))

    def own(self, place: object) -> str:
        """The index of one of four elements; one without a sign where it is to be seen that all are
        the iteration's own.
        """
        index = f"4 * i + {place}"
        return index if self.loop_over == "prange" else f"np.uint32({index})"

    def integer(self) -> str:
        a, b = self.random.choice("abc"), self.random.choice("abc")
        loaded = [
            f"x[({a} + {b}) & 63]",
            f"x[{a} & 63]",
            "x[m & 63]",
            f"y[{self.own(f'({b} & 3)')}]",
            f"w[i, {a} & 3]",
        ]
        if not self.is_apart:
            loaded += ["y[4 * i + 2 - (b & 1)]", "w[i & 3, 1]"]
        if self.own_array:
            loaded += [f"t[{a} & 3]"] * 2
        forms = [
            f"(({a} + {b}) & 1023)",
            f"(({a} * 3 - {b}) & 511)",
            f"({a} ^ 5)",
            f"min({a}, {b})",
            f"(({self.random.choice(loaded)} + {a}) & 255)",
            f"(({self.random.choice(loaded)} ^ {b}) & 255)",
        ]
        return self.random.choice(forms)

    def real(self) -> str:
        f, g, a = self.random.choice("fg"), self.random.choice("fg"), self.random.choice("abc")
        forms = [
            f"np.float32({f} * np.float32(0.5) + {g})",
            f"np.float32({f} - u[{a} & 63])",
            f"np.float32({f} * np.float32(0.25) + u[({a} + i) & 63])",
            f"np.float32({f} * np.float32(0.125) + v[{self.own(1)}])",
            f"max({f}, np.float32({g} * np.float32(0.5)))",
        ]
        return self.random.choice(forms)

    def condition(self) -> str:
        a, b, f, g = *self.random.choices("abc", k=2), *self.random.choices("fg", k=2)
        forms = [
            f"{a} > {b}",
            f"({a} & 3) == 1",
            f"x[({a} + i) & 63] & 1 == 0",
            f"{f} < {g}",
            "m > 3",
            f"(i & 1) == {self.random.randint(0, 1)}",
        ]
        return self.random.choice(forms)


def random_parallel_source(seed: int) -> str:
    """A module whose `program` is a kernel with a loop over `prange`."""
    return _Writer(seed).source()


def random_serial_source(seed: int) -> str:
    """The same with a loop over `range`, of which nothing is promised."""
    return _Writer(seed, "range").source()


def arguments(seed: int, trial: int) -> list[object]:
    """Random arguments; the second trial has few iterations, or none."""
    rng = np.random.default_rng([seed, trial])
    n = int(rng.integers(0, 4)) if trial == 1 else int(rng.integers(4, 12))
    rows = max(n, 8)
    return [
        rng.integers(-40, 200, LOADED).astype(np.int32),
        rng.standard_normal(LOADED).astype(np.float32),
        rng.integers(-9, 99, 4 * rows + 1).astype(np.int32),  # one more: `y[4 * i + 3 + 1]`
        rng.standard_normal(4 * rows).astype(np.float32),
        rng.integers(-9, 99, (rows, 4)).astype(np.int32),
        np.int32(n),
        np.int32(rng.integers(0, 9)),
    ]


def threaded(kernel: KernelFunction, count: int) -> Function | Refusal:
    """The kernel's function with threads of its outermost loop over `prange`; without one, of the
    outermost loop whose iterations prove to be independent.
    """
    function = tidy(kernel.lower())
    for loop in reversed(find_loops(function)):
        if not kernel.prange_lines:
            if meeting_array(function, loop.header) is None:
                done = thread(function, loop.header, count)
                if not isinstance(done, Refusal):
                    return done.function
            continue
        loc = block_of(function, loop.header).branch.loc
        if loc is not None and loc.line in kernel.prange_lines:
            done = thread(function, loop.header, count)
            return done if isinstance(done, Refusal) else done.function
    return Refusal("no loop is there whose iterations are independent")


def judge_threads(source: str, seed: int, folder: Path, *, simulate: bool = False) -> str:
    """Whether the witnesses agree on a kernel with threads.

    Returns
    -------
    Why there are no threads, or "".

    Raises
    ------
    Difference
        If they do not agree.
    """
    random = Random(seed)
    kernel: KernelFunction = load(source, folder).program
    count = random.choice([2, 3, 4, 4, 8])
    made = threaded(kernel, count)
    if isinstance(made, Refusal):
        return made.reason
    forms = {"as written": kernel.lower(), f"{count} threads": made, "tidied": tidy(made)}
    text, other = at_random(made, random)
    if text:
        forms[f"{count} threads; {text}"] = other
    built = {}
    for name, function in forms.items():
        broken = check_function(function)
        if broken:
            raise Difference(f"{name}: {broken}")
        built[name] = optimize_kernel(build_kernel(normalize(function)), OPTIONS)
    program = words_in_blocks(forms["tidied"]) if simulate else None
    for trial in range(3):
        args = arguments(seed, trial)
        expected = deepcopy(args)
        value = kernel(*expected)
        first: list[object] = []
        for name, lowered in built.items():
            mine = deepcopy(args)
            result = run_regions(lowered, mine)
            compare(name, [result, *mine], [value, *expected], frozenset())
            first = first or [result, *mine]
            compare(f"{name}, against as written", [result, *mine], first)
        if program is not None:
            mine = deepcopy(args)
            found = vividc.simulate(program, *mine)
            compare("simulator", [found.value, *mine], first)
    return ""
