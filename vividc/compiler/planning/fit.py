"""A kernel as its nests are given forms: with a version for sizes of arguments that agree, which
alone is transformed, and with nests flattened until the regions fit the configuration memory.

Each level of a nest takes straight regions before and behind the loops in it, of a few contexts
each. A kernel of many small nests, as array expressions make, may take more contexts for these than
there are; a flattened nest has none of them.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

from vividc.compiler.planning.candidates import Candidate
from vividc.compiler.planning.plan import Draft, Stage
from vividc.compiler.planning.state import State
from vividc.ssa.analysis.frequency import EQUAL
from vividc.ssa.loops.begun_sums import begun_sums
from vividc.ssa.loops.factored_sums import factored_sums
from vividc.ssa.loops.sizes.versions import for_sizes, without_arrays_between
from vividc.ssa.loops.taken_in import taken_in
from vividc.ssa.rewrite.tidy import tidy

_ROOMS: Final = (0.85, 0.7, 0.5)
"""Shares of the contexts that an estimate may take, if flattening does it: schedules take more than
their bounds (vadv of NPBench: 435 and 604, where constant stores are full).
"""

_HARDLY: Final = 1.3
"""Times its estimate that a kernel may take: vadv takes 587 contexts for 444."""

_FAR: Final = 1.5
"""Contexts over those that there are, from which on no form of a kernel is looked for: none would
fit, and of a long program another form saves less than bringing its contexts takes. Those of nbody
of NPBench, 956 of 512, were looked for in vain for a minute.
"""

_TOGETHER: Final = 8
"""Nests that are flattened before the kernel is estimated again: each saves about six contexts."""

_WITH_OTHERS: Final = 0.8
"""Of the contexts: two versions are no use where they leave no room for other forms of loops."""

_SURE: Final = 0.85
"""Of these: above it forms of the kernel as it is are looked for, too, as those of two versions may
take more contexts than there are (correlation of NPBench: 567 of 512, estimated to be fewer).
"""

_AS_GOOD: Final = 1.25
"""Times the cycles: what is computed again in place of an array, and fused loops that wait longer
in each iteration, are paid back by other forms (covariance of NPBench: 1.10 times before them).
"""


def version_for_sizes(draft: Draft) -> None:
    """Goes on from two versions of the kernel, if sizes decide what it asks."""
    state, most = draft.now.state, _WITH_OTHERS * draft.estimator.fabric.controller.contexts
    made = for_sizes(state.function) if draft.now.estimate.contexts <= most else None
    if made is None:
        _without_arrays(draft)
        return
    others = {new: state.hints[old] for new, old in made.others.items()}
    hints = {**state.hints, **others, made.entered: 1.0 - EQUAL}
    both = made.function
    if draft.estimator.options.reassociate:
        both = begun_sums(factored_sums(both))
    changed = replace(state, function=taken_in(tidy(both)), hints=hints)
    stage = Stage(changed, draft.estimator.estimate(changed.function, hints))
    is_as_good = stage.estimate.cycles < _AS_GOOD * draft.now.estimate.cycles
    if is_as_good and stage.estimate.contexts <= most:
        draft.fixed |= {*made.others}
        if stage.estimate.contexts > _SURE * most:
            draft.spare = draft.now
        draft.accept(stage)


def _without_arrays(draft: Draft) -> None:
    """Goes on from the kernel without arrays between nests that ask for no sizes."""
    state = draft.now.state
    made = without_arrays_between(state.function)
    if made is not None:
        changed = replace(state, function=made)
        stage = Stage(changed, draft.estimator.estimate(made, state.hints))
        if stage.estimate.cycles < _AS_GOOD * draft.now.estimate.cycles:
            draft.accept(stage)


def fitted(draft: Draft, stage: Stage) -> list[Stage]:
    """Of a stage that takes more contexts than there are: it with nests flattened, those first that
    take fewest cycles, until it may be mapped; before that, forms that are likelier to be. None if
    it does not fit so, or fits as it is. Of one that hardly fits: such forms if they are faster.
    """
    most = draft.estimator.fabric.controller.contexts
    found: list[Stage] = []
    if _HARDLY * stage.estimate.contexts <= most:
        return found
    least = math.inf if stage.estimate.contexts > most else stage.estimate.cycles
    tried: set[str] = set()
    for share in _ROOMS:
        before = stage
        while stage.estimate.contexts > share * most:
            headers = sorted(draft.around_one_loop(stage, tried), key=stage.cycles_in)
            if not headers:
                break
            tried |= {*headers[:_TOGETHER]}
            stage = _flattened(draft, stage, headers[:_TOGETHER])
        if stage is not before and stage.estimate.contexts <= most:
            found.insert(0, stage)
    return [one for one in found if one.estimate.cycles < least]


def is_far_too_long(draft: Draft) -> bool:
    """Whether the kernel takes many more contexts than there are; its nests are told so."""
    stage, most = draft.now, draft.estimator.fabric.controller.contexts
    if stage.estimate.contexts <= _FAR * most:
        return False
    reason = f"the kernel takes {stage.estimate.contexts} contexts, and there are {most}"
    for header in draft.outermost():
        draft.note(stage, Candidate("restructuring", header), None, reason)
    return True


def _flattened(draft: Draft, base: Stage, headers: list[str]) -> Stage:
    """With these nests flattened, as far as they can be and if that takes fewer contexts."""
    made, done = base.state, []
    for header in headers:
        candidate = Candidate("flattening", header)
        state = draft.applied(made, candidate)
        if isinstance(state, State):
            made = state
            done.append(candidate)
    estimate = draft.estimator.estimate(made.function, made.hints)
    if estimate.contexts >= base.estimate.contexts:
        return base
    stage = base
    for candidate in done:
        stage = Stage(made, estimate, draft.note(base, candidate, estimate, ""), stage)
    return stage
