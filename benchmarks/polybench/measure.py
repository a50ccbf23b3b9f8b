"""One row: a kernel of the suite, compiled, run, compared with numba, in a process of its own."""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

import vividc
from benchmarks import EFFORT, PATIENCE
from benchmarks.kernels import predicted
from benchmarks.polybench.suite import CASES, FABRICS, MEDIUM, Case
from benchmarks.polybench.trace import traced
from benchmarks.workloads import transformations
from vividc.errors import InternalError, VividcError
from vividc.program import Program
from vividc.program.tables import RegionReport
from vividc.sim import Stats

RTOL: Final = 1e-4
"""FMAs round once, elementary functions are within `docs/math.md`: a result may differ from numba's
by so much of the greatest number in its array. Integers are equal.
"""

_FUS: Final = 16


@dataclass(frozen=True, slots=True)
class Row:
    """A kernel at a size; what is None was not measured, or has no meaning there.

    Attributes
    ----------
    step
        Of the compiler's progress, in which it was measured.
    operations, floor
        See `trace`.
    error
        Largest difference from numba, as a share of the greatest number in the array.
    predicted
        Cycles by the estimate's formula, with the II, span and expected stalls of each region and
        how often the run entered it and went round.
    explained
        The estimate of the program that was chosen, as `--explain` tells it: with assumed trips.
    stalls, straight, fill
        Cycles of bank stalls, of straight regions and switches between regions, and of prologues
        and epilogues of loops.
    hot, ii, res_mii, rec_mii, assumed
        The loop region with most cycles: its operations, II and bounds, and whether its recurrence
        is one of accesses that were not proved apart.
    compile_s
        Seconds of user CPU.
    refused
        Why there is no run.
    known
        It was compiled for its sizes only (`like=`).
    reassociate
        It was compiled with `reassociate=True`.
    """

    step: str
    kernel: str
    size: str
    operations: int
    floor: int | None = None
    error: float | None = None
    cycles: int | None = None
    predicted: int | None = None
    explained: int | None = None
    stalls: int | None = None
    straight: int | None = None
    fill: int | None = None
    hot: int | None = None
    ii: int | None = None
    res_mii: int | None = None
    rec_mii: int | None = None
    assumed: bool = False
    compile_s: float | None = None
    hurried: bool = False
    transformed: str = ""
    refused: str = ""
    known: bool = False
    reassociate: bool = False

    @property
    def is_right(self) -> bool:
        """It ran, and agrees with numba."""
        return self.error is not None and self.error <= RTOL

    @property
    def ideal(self) -> float:
        """Cycles in which sixteen PEs start all operations."""
        return self.operations / _FUS

    @property
    def ratio(self) -> float | None:
        """Cycles over the ideal."""
        return None if self.cycles is None else self.cycles / self.ideal

    @property
    def ratio_to_floor(self) -> float | None:
        """Cycles over what binds more, the operations or the floor."""
        return None if self.cycles is None else self.cycles / max(self.ideal, self.floor or 0)


def measured(
    step: str, name: str, size: str, known: bool = False, reassociate: bool = False
) -> Row:
    """The row of a kernel at a size, perhaps `known` to the compiler, perhaps with float sums in
    another order; a refusal is one too.
    """
    case = CASES[name]
    counted = _counted(case, size)
    row = Row(step, name, size, *counted, known=known, reassociate=reassociate)
    like = case.fresh(size) if known else None
    with warnings.catch_warnings(), vividc.patient(PATIENCE):
        warnings.simplefilter("ignore")  # what is not as in numba shows in the results
        try:
            start = os.times().user
            program = vividc.compile(
                case.kernel,
                fabric=FABRICS[size],
                like=like,
                reassociate=reassociate,
                effort=EFFORT,
            )
            took = round(os.times().user - start, 2)
            return _ran(replace(row, compile_s=took, hurried=program.hurried), case, program)
        except VividcError as error:
            return replace(row, refused=error.reason)
        except InternalError as error:
            return replace(row, refused=f"internal error: {error}")


def _counted(case: Case, size: str) -> tuple[int, int | None]:
    if size == MEDIUM:
        assert case.operations is not None
        return case.operations(*case.sizes[size]), None
    trace = traced(case.kernel, case.fresh(size))
    return trace.operations, trace.floor


def _ran(row: Row, case: Case, program: Program) -> Row:
    row = replace(row, transformed=transformations(program), explained=_explained(program))
    mine, numbas = case.fresh(row.size), case.fresh(row.size)
    case.kernel(*numbas)
    if row.size == MEDIUM:
        cycles = vividc.simulate(program, *mine, fabric=FABRICS[row.size]).cycles
    else:
        result = vividc.simulate(program, *mine)
        cycles = result.cycles
        row = _with_regions(row, program, result.stats)
    return replace(row, cycles=cycles, error=largest_error(mine, numbas))


def largest_error(mine: tuple[object, ...], numbas: tuple[object, ...]) -> float:
    """The largest difference, as a share of the greatest number of its array; infinite where
    integers differ, or where only one is a number.
    """
    worst = 0.0
    for one, other in zip(mine, numbas, strict=True):
        if not isinstance(one, np.ndarray) or not isinstance(other, np.ndarray):
            continue
        if one.dtype.kind != "f" or not np.array_equal(np.isfinite(one), np.isfinite(other)):
            worst = max(worst, 0.0 if np.array_equal(one, other) else np.inf)
            continue
        away = np.abs(one.astype(np.float64) - other).max(initial=0.0)
        worst = max(worst, float(away / max(np.abs(other).max(initial=0.0), 1e-30)))
    return worst


def _with_regions(row: Row, program: Program, stats: Stats) -> Row:
    regions = stats["regions"]
    uses = stats["cycles_by_use"]
    loops = [index for index, region in enumerate(regions) if region["kind"] == "loop"]
    row = replace(
        row,
        stalls=stats["stalls"]["bank_conflict"],
        straight=uses["straight"] + uses["switch"],
        fill=uses["prologue_epilogue"],
        predicted=round(predicted(program, stats)),
    )
    if not loops:
        return row
    hot = program.regions[max(loops, key=lambda index: regions[index]["cycles"])]
    return _with_hot(row, hot)


def _with_hot(row: Row, hot: RegionReport) -> Row:
    bounds = {bound.name: bound.ii for bound in hot.bounds}
    others = [ii for name, ii in bounds.items() if name != "RecMII"]
    return replace(
        row,
        hot=hot.operations,
        ii=hot.ii,
        res_mii=max(others, default=None),
        rec_mii=bounds.get("RecMII"),
        assumed=hot.rests_on_assumed,
    )


def _explained(program: Program) -> int | None:
    """The estimate after the last transformation, or before the first that was not chosen."""
    tried = [item for loop in program.loops for item in loop.transforms]
    after = [item.after for item in tried if item.chosen and item.after is not None]
    before = [item.before for item in tried]
    least = min(after or before, default=None)
    return None if least is None else round(least)
