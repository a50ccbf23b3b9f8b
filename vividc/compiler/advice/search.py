"""What a longer search for mappings could bring."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from vividc.compiler.planning.estimate import RegionCost
from vividc.compiler.planning.plan import Plan, Stage
from vividc.errors import SourceLoc
from vividc.mapper import EFFORT_LEVELS
from vividc.program import Program


@dataclass(frozen=True, slots=True)
class Searched:
    """A higher effort, which saves so many cycles if every loop reaches what is proved of it."""

    action: str
    option: str
    loc: SourceLoc | None
    saved: float


def longer_search(plan: Plan, program: Program) -> Iterator[Searched]:
    """The next higher effort, if there are loops whose II is not proved to be the least."""
    level = next((o.value for o in program.provenance.options if o.name == "effort"), None)
    higher = EFFORT_LEVELS[EFFORT_LEVELS.index(level) + 1 :] if level in EFFORT_LEVELS else ()
    stage = next((stage for stage in reversed(plan.stages) if _is_of(program, stage)), None)
    if stage is None or not higher:
        return
    pairs = list(zip(stage.estimate.regions, program.regions, strict=True))
    loops = [(cost, report) for cost, report in pairs if report.kind == "loop"]
    if not loops:
        return

    def cycles(cost: RegionCost, ii: int) -> float:
        return replace(cost, shape=replace(cost.shape, ii=ii)).cycles

    saved = [cycles(cost, r.ii) - cycles(cost, r.lower_bound) for cost, r in loops]
    _, report = loops[saved.index(max(saved))]
    action = f"search longer for a mapping of II {report.lower_bound} instead of {report.ii}"
    yield Searched(action, f"--effort {higher[0]}", report.loc, sum(saved))


def _is_of(program: Program, stage: Stage) -> bool:
    """Whether the program is that of the stage."""
    costs = stage.estimate.regions
    return [(cost.kind, cost.loc) for cost in costs] == [(r.kind, r.loc) for r in program.regions]
