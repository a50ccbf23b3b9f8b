"""`python -m tests.fuzz.slices`: random programs that assign slices to slices, against numba; exit
code 1 on a find.

Bounds lie inside and outside their axes, count from either end, and are constants or computed from
a parameter, which is 3; steps are negative, too. Parts are views of views, rows, transposed, or
named before they are used; they overlap what is assigned to. Most parts have the lengths of what
they are assigned to, the others broadcast or are refused by both. Nothing is mapped: what is
lowered is interpreted.
"""

from __future__ import annotations

import linecache
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

import click
import numpy as np

import vividc
from vividc.errors import KernelError, VividcError, VividcWarning
from vividc.ssa.interpret import interpret
from vividc.ssa.results import named_leaves

SIGNATURE = "(float32[:, ::1], float32[:, ::1], int32)"
_SIDE = 6
_N = 3
_BOUNDS = (None, *range(-_SIDE - 2, _SIDE + 3))
_STEPS = (None, None, None, -1, 2, -2)
_PARTS = (("=", 3), ("+=", 1), ("-=", 1), ("*=", 1))


def random_source(random: Random) -> str:
    """A kernel `program(a, b, n)` of two to five statements."""
    lines = ["def program(a, b, n):"]
    for _ in range(random.randint(2, 5)):
        lines += [f"    {line}" for line in _statement(random)]
    return "\n".join(lines) + "\n"


def _statement(random: Random) -> list[str]:
    height, width = random.choice([*range(_SIDE), _SIDE, _SIDE]), random.choice(range(1, _SIDE + 1))
    into = random.choice("ab")
    target = f"{into}[{_slice(random, height)}, {_slice(random, width)}]"
    operator = random.choices(*zip(*_PARTS, strict=True))[0]
    if random.random() < 0.3:
        height = width = _SIDE
        target = f"{into}[:]" if operator == "=" else into
    value = _operand(random, height, width)
    for _ in range(random.randint(0, 2)):
        value += random.choice([" + ", " * ", " - "]) + _operand(random, height, width)
    if random.random() > 0.2:
        return [f"{target} {operator} {value}"]
    return [f"v = {value}", f"{target} {operator} v{random.choice(['', ' * 0.5'])}"]


def _operand(random: Random, height: int, width: int) -> str:
    kind = random.random()
    if kind < 0.3:
        return random.choice(["2.0", "n"])
    return _part(random, random.choice("ab"), height, width)


def _part(random: Random, array: str, height: int, width: int) -> str:
    """A part of so many rows and columns, or one that broadcasts to them."""
    rows, columns = _slice(random, height), _slice(random, width)
    forms = [
        *[f"{array}[{rows}, {columns}]"] * 4,
        f"{array}[{_slice(random, _SIDE)}][{rows}, {columns}]",
        f"{array}[{random.randrange(-_SIDE, _SIDE)}, {columns}]",
        f"{array}[n, {columns}]",
        f"{array}[{rows}, 1:2]",
    ]
    forms += [f"{array}[{columns}, {rows}].T"] if height == width else []
    forms += [f"{array}[{rows}]"] if width == _SIDE else []
    forms += [array] * 3 if height == width == _SIDE else []
    return random.choice(forms)


def _slice(random: Random, length: int) -> str:
    """A slice that leaves so many elements of an axis."""
    found = [
        (start, stop, step)
        for step in _STEPS
        for start in _BOUNDS
        for stop in _BOUNDS
        if len(range(_SIDE)[slice(start, stop, step)]) == length
    ]
    start, stop, step = random.choice(found)
    text = f"{_bound(random, start)}:{_bound(random, stop)}"
    return text if step is None else f"{text}:{step}"


def _bound(random: Random, bound: int | None) -> str:
    if bound is None:
        return ""
    return f"n{bound - _N:+d}" if random.random() < 0.25 else str(bound)


@dataclass
class Search:
    """What was run; `folder` is for sources, which numba reads.

    Attributes
    ----------
    make
        The source of a program.
    counts
        Of programs that agree, that both refuse when they run, and that are not compiled.
    finds
        Sources of programs that differ, with their seeds.
    """

    folder: Path
    make: Callable[[Random], str] = random_source
    counts: Counter[str] = field(default_factory=Counter)
    finds: list[str] = field(default_factory=list)

    def run(self, seed: int) -> None:
        """The program of one seed."""
        source = self.make(Random(seed))
        kernel = vividc.kernel(SIGNATURE)(_loaded(source, self.folder / "slices.py"))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", VividcWarning)  # of 0.5 in float32
                lowered = kernel.lower()
        except KernelError as error:
            self.counts[f"refused: {error.reason}"] += 1
            return
        numbas, theirs = _run(kernel, seed)
        ours, mine = _run(lambda a, b, n: interpret(lowered, a, b, n), seed)
        same = all(np.array_equal(*pair, equal_nan=True) for pair in zip(mine, theirs, strict=True))
        if ours != numbas or not (ours or same):
            self.finds.append(f"seed {seed} ({ours or 'ends'}, numba {numbas or 'ends'})\n{source}")
        self.counts["raise" if ours else "agree"] += 1


def _loaded(source: str, path: Path) -> Callable[..., object]:
    path.write_text(source)
    linecache.checkcache(str(path))
    names: dict[str, Callable[..., object]] = {}
    exec(compile(source, str(path), "exec"), names)
    return names["program"]


def _run(function: Callable[..., object], seed: int) -> tuple[bool, list[np.ndarray]]:
    """Whether it raises, and what it leaves and returns."""
    drawn = np.random.default_rng(seed).integers(-4, 5, (2, _SIDE, _SIDE))
    a, b = drawn.astype(np.float32)
    try:
        with np.errstate(all="ignore"):
            value = function(a, b, np.int32(_N))
    except (ValueError, VividcError):
        return True, [a, b]
    return False, [a, b, *(leaf for _, leaf in named_leaves(value))]


def searched(make: Callable[[Random], str], seed: int, count: int) -> bool:
    """Run random programs and print what was found; whether all agree."""
    with tempfile.TemporaryDirectory() as folder:
        search = Search(Path(folder), make)
        for one in range(seed, seed + count):
            known = len(search.finds)
            search.run(one)
            for find in search.finds[known:]:
                click.echo(f"FIND {find}")
        found = ", ".join(f"{n} {what}" for what, n in search.counts.most_common())
        click.echo(f"seed {seed + count - 1}: {found}")
    return not search.finds


def command(make: Callable[[Random], str], what: str) -> click.Command:
    """The command that runs random programs of `make`, which are called `what`."""

    @click.command(help=f"Run random {what}; exit code 1 on a find.")
    @click.option("--seed", default=1, show_default=True, help="Of the first program.")
    @click.option("--count", default=1000, show_default=True, help="Programs.")
    def main(seed: int, count: int) -> None:
        sys.exit(0 if searched(make, seed, count) else 1)

    return main


if __name__ == "__main__":
    command(random_source, "programs of slices")()
