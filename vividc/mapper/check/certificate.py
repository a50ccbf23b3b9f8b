"""Checks a result's certificate without a solver: its mapping, its bounds, and what they prove.

What a solver refuted is not proved again: it is listed as taken on trust, like all else that
nothing in the document can show.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from vividc.errors import demand_type
from vividc.mapper.check.bounds import check_bounds
from vividc.mapper.check.finding import Finding, Verdict, own_words
from vividc.mapper.check.objective import check_objective
from vividc.mapper.check.verify import violations
from vividc.mapper.mapping import Subject
from vividc.mapper.result import MapResult


def check_certificate(result: MapResult, subject: Subject) -> tuple[Finding, ...]:
    """Check everything that `result` says about mapping a graph onto a fabric.

    Returns
    -------
    tuple of Finding
        "wrong" findings contradict the result, or are given no reason; "trusted" ones rest on the
        word of a solver, or of who wrote the result.
    """
    demand_type(result, MapResult, "the result", "give what map_dfg or read_result gave")
    demand_type(subject, Subject, "the subject", "give the graph and the fabric as a Subject")
    mapping = tuple(_check_mapping(result, subject))
    bounds = check_bounds(result.bounds, subject)
    legal = all(finding.verdict == "confirmed" for finding in mapping)
    pairs = zip(result.bounds, bounds, strict=True)
    proved = max([1, *(bound.ii for bound, finding in pairs if finding.verdict == "confirmed")])
    reach = _reach_of(result, subject, proved)
    return (
        *mapping,
        *bounds,
        *(_bounds_above(result) if legal else ()),
        *_check_refuted(result, reach),
        *_check_lower_bound(result, reach),
        *_check_status(result, reach),
        *(check_objective(result, subject) if legal else ()),
        *_taken_on_trust(result),
    )


def _check_mapping(result: MapResult, subject: Subject) -> Iterator[Finding]:
    mapping = result.mapping
    if mapping is None:
        if result.ii is not None:
            yield Finding("wrong", f"II {result.ii} is claimed without a mapping")
        return
    faults = violations(
        subject.dfg,
        subject.fabric,
        mapping,
        allowed=subject.allowed,
        resident=subject.resident,
    )
    yield from (Finding("wrong", f"the mapping breaks a rule: {broken}") for broken in faults)
    if not faults:
        yield Finding("confirmed", f"the mapping is legal at II {mapping.ii}")
    if mapping.ii != result.ii:
        yield Finding("wrong", f"the mapping has II {mapping.ii}, the result says {result.ii}")


def _bounds_above(result: MapResult) -> Iterator[Finding]:
    """Bounds that the mapping, which is legal, disproves."""
    for bound in result.bounds:
        if result.mapping is not None and bound.ii > result.mapping.ii:
            text = f"{own_words(bound.name)} {bound.ii} is above the II {result.mapping.ii}"
            yield Finding("wrong", f"{text} of the mapping")


@dataclass(frozen=True, slots=True)
class _Reach:
    """How far the proofs of a result go.

    Attributes
    ----------
    proved
        By bounds that were confirmed: the II is at least that.
    follows
        The same with the refutations, which are taken on trust.
    contexts
        The largest II that the fabric can hold.
    """

    proved: int
    follows: int
    contexts: int

    @property
    def verdict(self) -> Verdict:
        return "trusted" if self.follows > self.proved else "confirmed"

    def excludes(self, ii: int) -> bool:
        """Whether an II is impossible without anything being taken on trust."""
        return ii < self.proved or ii > self.contexts


def _reach_of(result: MapResult, subject: Subject, proved: int) -> _Reach:
    mapped = None if result.mapping is None else result.mapping.ii
    refuted = {item.ii for item in result.refuted} - {mapped}
    follows = proved
    while follows in refuted:
        follows += 1
    return _Reach(proved, follows, subject.fabric.controller.contexts)


def _check_refuted(result: MapResult, reach: _Reach) -> Iterator[Finding]:
    for item in result.refuted:
        if result.mapping is not None and item.ii == result.mapping.ii:
            yield Finding("wrong", f"II {item.ii} is said to be refuted, and is mapped")
        elif item.ii < reach.proved:
            text = f"II {item.ii} cannot work: the II is at least {reach.proved}"
            yield Finding("confirmed", text)
        elif item.ii > reach.contexts:
            text = f"II {item.ii} cannot work: there are {reach.contexts} contexts"
            yield Finding("confirmed", text)
        else:
            yield Finding("trusted", f"II {item.ii} refuted by {own_words(item.by)}")


def _check_lower_bound(result: MapResult, reach: _Reach) -> Iterator[Finding]:
    lower, follows = result.lower_bound, reach.follows
    if lower > follows:
        text = f"the lower bound {lower} is given no reason: nothing refutes II {follows}"
        yield Finding("wrong", text)
    elif lower < follows:
        text = f"the lower bound {lower} is not the one that follows, which is {follows}"
        yield Finding("wrong", text)
    else:
        none = ": no II works" if lower > reach.contexts else ""
        yield Finding(reach.verdict, f"the II is at least {lower}{none}")


def _check_status(result: MapResult, reach: _Reach) -> Iterator[Finding]:
    ii, lower = result.ii, result.lower_bound
    if ii is not None and lower > ii:
        yield Finding("wrong", f"the lower bound {lower} exceeds the II {ii} of the mapping")
    if result.status == "optimal" and (ii is None or min(lower, reach.follows) < ii):
        proved = min(lower, reach.follows)
        yield Finding("wrong", f"optimal is claimed at II {ii} with a lower bound of {proved}")
    if result.status == "feasible" and ii is not None and reach.follows >= ii:
        yield Finding("wrong", f"feasible is claimed at II {ii}, but no smaller II is open")
    if (result.status in ("optimal", "feasible")) != (result.mapping is not None):
        held = "no" if result.mapping is None else "a"
        yield Finding("wrong", f"the status is {result.status}, but there is {held} mapping")
    if result.status == "timeout" and reach.follows > reach.contexts:
        yield Finding("wrong", "a timeout is claimed, but no II is open")
    if result.status == "infeasible" and reach.follows <= reach.contexts:
        yield _infeasible_alone(result, reach)


def _infeasible_alone(result: MapResult, reach: _Reach) -> Finding:
    """What "infeasible" means where some II is open: the one that was asked for was refuted."""
    if not result.refuted:
        return Finding("wrong", "infeasible is claimed, but no II is refuted")
    asked = ", ".join(str(item.ii) for item in result.refuted)
    trusted = any(not reach.excludes(item.ii) for item in result.refuted)
    text = f"infeasible is said of II {asked} only, which was asked for"
    return Finding("trusted" if trusted else "confirmed", text)


def _taken_on_trust(result: MapResult) -> Iterator[Finding]:
    if result.constrained:
        text = "constraints were added that are not in the result: what is mapped keeps to them"
        yield Finding("trusted", f"{text}, and what is refuted is so within them")
    about = f"mapped by {own_words(result.mapper)} in {result.wall_s:.1f} s"
    yield Finding("trusted", f"{about}; statistics, versions, words and source lines of bounds")
