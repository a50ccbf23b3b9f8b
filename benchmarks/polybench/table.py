"""The page of PolyBench, and its rows, which are kept beside it: a run that was broken off goes on
where it stopped, and what is measured again under the name of a new step shows the progress.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict, dataclass
from multiprocessing import get_context
from pathlib import Path
from statistics import geometric_mean
from typing import Final

from benchmarks.polybench.measure import RTOL, Row, measured
from benchmarks.polybench.suite import CASES, IMAGES, POLYBENCH, SIZES, SMALL

ROWS: Final = "polybench.jsonl"
TITLE: Final = "PolyBench: whole kernels near the array's peak"
BASELINE: Final = "baseline"
HEADER: Final = (
    "| kernel | right | operations / 16 | floor | cycles | / operations | / floor | / by hand "
    "| predicted | explained | hot loop ops | II | ResMII | RecMII | bank stalls | straight | fill "
    "| compile s | transformed |\n"
    "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"
)
NOTES: Final = f"""\
PolyBench 4.2 in Python (`benchmarks/polybench/kernels`), in float32, floyd-warshall and nussinov in
int32; sizes are in `benchmarks/polybench/suite.py`. `mini` and `small` run on `vivid-tile` and fit
its scratchpad, `medium` runs on `vivid`. All are compiled without a flag; nests of the steps
before *restructured* were not, those up to *in order, masked* by `--restructure`. A row is kept in
`{ROWS}` when it is made; the newest of each kernel is shown.

- right: floats differ from numba's by at most {RTOL:g} of the greatest number in their array, as
  FMAs round once; integers are equal.
- operations / 16: the arithmetic of the source, counted by running its text on numbers that count
  (`benchmarks/polybench/trace.py`): an FMA, a division, a root, an exponential, a comparison and a
  minimum are one operation each, `c - a * b` is an FMA, index arithmetic is none, and what is
  computed again from the same elements, unchanged, counts once.
- floor: cycles of the dataflow's critical path with unlimited PEs, free memory and branches, sums
  in strict order, and the fabric's latencies. `medium` is counted by a closed form and has none.
  A division or root counts by the path through what it expands to, as of the row's step.
- / operations, / floor: cycles over operations / 16, and over the larger of it and the floor.
- / by hand: cycles / operations over the study's figure for loops restructured by hand (in
  brackets): with exact dependences where it was tried with them, at its size, by its count.
- predicted: the estimate's formula, with IIs, spans and expected bank stalls as mapped and the
  trips of the run, over the cycles.
- explained: the estimate that `--explain` tells, made before mapping for trips that it assumes,
  over the cycles.
- hot loop: the loop region with most cycles. RecMII with a `?` rests on accesses that were not
  proved apart.
- straight: in straight regions, and switches between regions. fill: in prologues and epilogues.
- compile s: seconds of user CPU.
""".splitlines()


@dataclass(frozen=True, slots=True)
class Wanted:
    """What to measure: kernels by name (none: all), sizes, processes at once, and the name of the
    step (none: the last one); `known`: compiled for their sizes only; `reassociate`: with float
    sums in another order.
    """

    only: tuple[str, ...] = ()
    sizes: tuple[str, ...] = SIZES
    jobs: int = 1
    step: str = ""
    known: bool = False
    reassociate: bool = False

    def tasks(self) -> Iterator[tuple[str, str]]:
        """Kernels and sizes, in the order of the page."""
        for size in self.sizes:
            for case in CASES.values():
                if size in case.sizes and (not self.only or case.name in self.only):
                    yield case.name, size


@dataclass(frozen=True, slots=True)
class Step:
    """A step of progress: its name, and the subject of the commit that it was first measured at."""

    name: str
    commit: str


class Kept:
    """The file of rows and steps, or none."""

    def __init__(self, output: Path | None) -> None:
        self.path = None if output is None else output / ROWS
        self.steps: dict[str, Step] = {}
        self.rows: list[Row] = []
        if self.path is not None and self.path.exists():
            for line in self.path.read_text(encoding="utf-8").splitlines():
                fields = json.loads(line)
                if "commit" in fields:
                    self.steps[fields["name"]] = Step(**fields)
                else:
                    self.rows.append(Row(**fields))

    def begin(self, step: str) -> str:
        """The name of the step to measure, which is entered if it is new."""
        step = step or next(reversed(self.steps), BASELINE)
        if step not in self.steps:
            self.steps[step] = Step(step, _subject())
            self._append(asdict(self.steps[step]))
        return step

    def add(self, row: Row) -> None:
        """Keep a row."""
        self.rows.append(row)
        self._append(asdict(row))

    def has(
        self, step: str, kernel: str, size: str, *, known: bool, reassociate: bool = False
    ) -> bool:
        """Whether it was measured in this step."""
        wanted = (step, kernel, size, known, reassociate)
        rows = ((r.step, r.kernel, r.size, r.known, r.reassociate) for r in self.rows)
        return any(row == wanted for row in rows)

    def newest(
        self, upto: str, *, known: bool = False, reassociate: bool = False
    ) -> dict[tuple[str, str], Row]:
        """The newest row of each kernel and size, as it was after a step."""
        names = [*self.steps]
        past = set(names[: names.index(upto) + 1])
        way = (known, reassociate)
        rows = (r for r in self.rows if r.step in past and (r.known, r.reassociate) == way)
        return {(row.kernel, row.size): row for row in rows}

    def _append(self, fields: dict[str, object]) -> None:
        if self.path is not None:
            with self.path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(fields) + "\n")


def sections(wanted: Wanted, output: Path | None) -> Iterator[list[str]]:
    """The page's lines, again after each row: with all rows that are kept.

    Parameters
    ----------
    output
        Folder of the file of rows; None: rows are neither read nor kept.
    """
    kept = Kept(output)
    step = kept.begin(wanted.step)
    way = {"known": wanted.known, "reassociate": wanted.reassociate}
    tasks = [task for task in wanted.tasks() if not kept.has(step, *task, **way)]
    for row in _rows(step, tasks, wanted.jobs, way):
        kept.add(row)
        print(line(row), file=sys.stderr)
        yield list(page(kept))
    yield list(page(kept))


def _rows(
    step: str, tasks: Sequence[tuple[str, str]], jobs: int, way: dict[str, bool]
) -> Iterator[Row]:
    """Each row from a process of its own."""
    context = get_context("spawn")
    with ProcessPoolExecutor(jobs, context, max_tasks_per_child=1) as pool:
        asked = [pool.submit(measured, step, *task, **way) for task in tasks]
        for done in as_completed(asked):
            try:
                yield done.result()
            except BrokenProcessPool:
                print("a process died: run the command again for what is left", file=sys.stderr)
                return


def page(kept: Kept) -> Iterator[str]:
    """The sections: small, mini and medium sizes, images, progress."""
    last = next(reversed(kept.steps))
    newest = kept.newest(last)
    names = [case.name for case in POLYBENCH]
    for size in (SMALL, *(size for size in SIZES if size != SMALL)):
        rows = [newest[name, size] for name in names if (name, size) in newest]
        if rows:
            yield from (
                f"## {size}",
                "",
                *_means(rows),
                "",
                *HEADER.splitlines(),
                *map(line, rows),
                "",
            )
    images = [row for case in IMAGES for size in SIZES if (row := newest.get((case.name, size)))]
    if images:
        yield from ("## Images", "", *HEADER.splitlines(), *map(line, images), "")
    yield from _apart("Known sizes", _KNOWN, kept.newest(last, known=True), newest)
    reassociated = kept.newest(last, reassociate=True)
    yield from _apart("Float sums in another order", _REASSOCIATED, reassociated, newest)
    yield from _progress(kept)


_KNOWN: Final = """\
Compiled with `like=` the arguments, so that shapes and integers are constants
(docs/known-sizes.md); no figure elsewhere on this page is. any: the newest row for any
sizes.""".splitlines()

_REASSOCIATED: Final = """\
Compiled with `reassociate=True`; no figure elsewhere on this page is. any: the newest row with
sums in the order of the source.""".splitlines()


def _apart(
    title: str,
    notes: Sequence[str],
    newest: Mapping[tuple[str, str], Row],
    others: Mapping[tuple[str, str], Row],
) -> Iterator[str]:
    """The section of kernels compiled in another way, beside the same without it."""
    keys = [(case.name, size) for size in SIZES for case in POLYBENCH]
    rows = [newest[key] for key in keys if key in newest]
    if not rows:
        return
    yield from (
        f"## {title}",
        "",
        *notes,
        "",
        "| kernel | right | cycles | any | / operations | any | compile s | any | transformed |",
        "|---|---|---|---|---|---|---|---|---|",
    )
    for row in rows:
        other = others.get((row.kernel, row.size), Row("", row.kernel, row.size, 0))
        cells = [
            row.kernel if row.size == SMALL else f"{row.kernel}, {row.size}",
            f"refused: {row.refused}" if row.refused else "yes" if row.is_right else "NO",
            _shown(row.cycles, ",d"),
            _shown(other.cycles, ",d"),
            _shown(row.ratio, ".1f"),
            _shown(other.ratio, ".1f"),
            _shown(row.compile_s, ".1f"),
            _shown(other.compile_s, ".1f"),
            row.transformed or "-",
        ]
        yield f"| {' | '.join(cells)} |"
    yield ""
    both = [row for row in rows if row.is_right and row.size == SMALL]
    both = [row for row in both if _is_right(others.get((row.kernel, SMALL)))]
    if both:
        beside = [others[row.kernel, SMALL] for row in both]
        yield f"Geometric means of the {len(both)} at small sizes that are right both ways: cycles"
        yield f"over operations / 16 {_mean(both)}, any: {_mean(beside)}."
        yield ""


def _is_right(row: Row | None) -> bool:
    return row is not None and row.is_right


def line(row: Row) -> str:
    """A row of the table."""
    name = (
        row.kernel
        if row.size == SMALL or CASES[row.kernel].of_polybench
        else f"{row.kernel}, {row.size}"
    )
    head = f"| {name} | "
    if row.refused:
        return f"{head}refused: {row.refused} | {row.ideal:,.0f} |" + " - |" * 16
    recurrence = _shown(row.rec_mii, "d") + ("?" if row.assumed else "")
    seconds = _shown(row.compile_s, ".1f") + (", by the clock" if row.hurried else "")
    cells = [
        "yes" if row.is_right else f"NO: {row.error:.1e}",
        f"{row.ideal:,.0f}",
        _shown(row.floor, ",d"),
        _shown(row.cycles, ",d"),
        _shown(row.ratio, ".1f"),
        _shown(row.ratio_to_floor, ".1f"),
        _to_hand(row),
        _share(row.predicted, row.cycles),
        _share(row.explained, row.cycles),
        _shown(row.hot, "d"),
        _shown(row.ii, "d"),
        _shown(row.res_mii, "d"),
        recurrence,
        _share(row.stalls, row.cycles, "%"),
        _share(row.straight, row.cycles, "%"),
        _share(row.fill, row.cycles, "%"),
        seconds,
        row.transformed or "-",
    ]
    return head + " | ".join(cells) + " |"


def _to_hand(row: Row) -> str:
    by_hand = CASES[row.kernel].by_hand
    if by_hand is None or row.ratio is None or row.size != SMALL:
        return "-"
    return f"{row.ratio / by_hand:.1f} ({by_hand:g})"


def _means(rows: Sequence[Row]) -> Iterator[str]:
    """Geometric means, over all that are right and over those without long chains."""
    right = [row for row in rows if row.is_right]
    short = [row for row in right if not CASES[row.kernel].long_chains]
    yield f"{len(right)} of {len(rows)} kernels are right. Geometric means over those, and over the"
    yield f"{len(short)} without chains of divisions or roots: cycles over operations / 16"
    yield f"{_mean(right)} and {_mean(short)}, over the larger of it and the floor"
    yield f"{_mean(right, floor=True)} and {_mean(short, floor=True)}."


def _mean(rows: Sequence[Row], *, floor: bool = False) -> str:
    ratios = [row.ratio_to_floor if floor else row.ratio for row in rows]
    known = [ratio for ratio in ratios if ratio is not None]
    return f"{geometric_mean(known):.1f}" if known else "-"


def _progress(kept: Kept) -> Iterator[str]:
    yield from (
        "## Progress",
        "",
        "Geometric means at the small sizes as they were after each step; without chains: without",
        "the kernels that are bound by divisions or roots.",
        "",
        "| step | commit | measured | right | cycles / (operations / 16) | without chains "
        "| cycles / floor | without chains | compile s, most |",
        "|---|---|---|---|---|---|---|---|---|",
    )
    ours = {case.name for case in POLYBENCH}
    for step in kept.steps.values():
        newest = kept.newest(step.name).values()
        rows = [row for row in newest if row.size == SMALL and row.kernel in ours]
        right = [row for row in rows if row.is_right]
        short = [row for row in right if not CASES[row.kernel].long_chains]
        fresh = sum(row.step == step.name for row in rows)
        slowest = max((row.compile_s for row in right if row.compile_s is not None), default=None)
        cells = [
            step.name,
            step.commit,
            str(fresh),
            f"{len(right)} of {len(rows)}",
            _mean(right),
            _mean(short),
            _mean(right, floor=True),
            _mean(short, floor=True),
            _shown(slowest, ".0f"),
        ]
        yield f"| {' | '.join(cells)} |"


def _shown(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)


def _share(part: int | None, whole: int | None, form: str = ".2f") -> str:
    if part is None or not whole:
        return "-"
    return f"{part / whole:.0%}" if form == "%" else format(part / whole, form)


def _subject() -> str:
    """The subject of the commit that is measured; "-" outside a repository."""
    command = ("git", "log", "-1", "--format=%s")
    try:
        done = subprocess.run(
            command, cwd=Path(__file__).parent, capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return "-"
    return done.stdout.strip()
