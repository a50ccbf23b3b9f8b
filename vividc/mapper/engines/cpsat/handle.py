"""The research door: what a caller's constraints see of the joint model."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Number
from typing import Final

from ortools.sat.python.cp_model import CpModel, IntVar, LinearExpr, LinearExprT

from vividc.errors import VividcError, printable, quoted
from vividc.mapper.engines.cpsat.problem import Prepared
from vividc.mapper.engines.cpsat.variables import Variables

_SHOWN: Final = 12


@dataclass(frozen=True, slots=True)
class ModelHandle:
    """A model of time, place and route at one II, before it is solved.

    A caller's function gets one for every model that is built: at each II, and at each II for
    several windows of start times. Sums over what the windows leave out are 0, so one function
    does for all. It must add the same constraints to each, and may not add an objective with
    `model.minimize` (`minimize` of this class keeps it for the last step).

    Attributes
    ----------
    model
        The CP-SAT model: `add`, `new_bool_var` and all else of ortools.
    problem
        Graph and fabric (`problem.task`), II, windows of start times.
    variables
        Every Boolean by its key; words are named by their producers (`cpsat.variables`).
    objectives
        What `minimize` was given.
    """

    model: CpModel
    problem: Prepared
    variables: Variables
    objectives: list[LinearExprT]

    @property
    def ii(self) -> int:
        """The II of this model."""
        return self.problem.ii

    def start(self, node: int) -> LinearExprT:
        """Cycle in which a node issues, counted from the start of its iteration."""
        self._check_node(node, "start")
        return self._sum(self.variables.start, lambda key: key[0] == node, times=True)

    def on_pe(self, node: int, pe: int) -> LinearExprT:
        """1 where the node lies on the PE, else 0."""
        self._check_node(node, "on_pe")
        self._check_pe(pe, "on_pe")
        return self._sum(self.variables.start, lambda key: key[:2] == (node, pe))

    def in_slot(self, pe: int, slot: int) -> LinearExprT:
        """Number of nodes that issue on the PE in a slot (cycle modulo II)."""
        self._check_pe(pe, "in_slot")
        return self._sum(self.variables.start, lambda key: self._is_at(key, pe, slot))

    def on_link(self, link: int, word: int | None = None) -> LinearExprT:
        """Slots in which a link carries a word (of one producer, or any)."""
        _check(link, range(len(self.problem.fabric.links)), "on_link", "link", "the fabric")
        if word is not None:
            self._check_node(word, "on_link")
        return self._sum(self.variables.link, lambda key: key[1] == link and word in (None, key[0]))

    def held(self, pe: int, slot: int) -> LinearExprT:
        """Words that the registers of a PE hold in a slot."""
        self._check_pe(pe, "held")
        return self._sum(self.variables.held, lambda key: self._is_at(key, pe, slot))

    def hops(self) -> LinearExprT:
        """Links driven and moves made by all words of one iteration."""
        return LinearExpr.sum([*self.variables.link.values(), *self.variables.move.values()])

    def minimize(self, expression: LinearExprT) -> None:
        """Minimise an expression once the II is found; several expressions are summed."""
        if not isinstance(expression, LinearExpr | Number) or isinstance(expression, bool):
            reason = f"{quoted(expression)} is not an expression"
            hint = "give a sum of variables, as handle.start(3) or handle.hops()"
            raise VividcError(reason, loc="minimize", hint=hint)
        self.objectives.append(expression)

    def _check_node(self, node: int, loc: str) -> None:
        nodes = [node.id for node in self.problem.nodes]
        _check(node, nodes, loc, "placed node", printable(self.problem.task.dfg.name))

    def _check_pe(self, pe: int, loc: str) -> None:
        _check(pe, range(len(self.problem.fabric.pes)), loc, "PE", self.problem.fabric.name)

    def _is_at(self, key: tuple[int, int, int], pe: int, slot: int) -> bool:
        return key[1] == pe and key[2] % self.ii == slot

    def _sum(
        self,
        literals: Mapping[tuple[int, int, int], IntVar],
        wanted: Callable[[tuple[int, int, int]], bool],
        *,
        times: bool = False,
    ) -> LinearExprT:
        terms = [(literal, key[2]) for key, literal in literals.items() if wanted(key)]
        factors = [time if times else 1 for _, time in terms]
        return LinearExpr.weighted_sum([literal for literal, _ in terms], factors)


def _check(given: int, known: Sequence[int], loc: str, what: str, where: str) -> None:
    """Refuse a number that names nothing: a sum over nothing would be 0."""
    if given in known:
        return
    shown = ", ".join(map(str, known[:_SHOWN])) + (", ..." if len(known) > _SHOWN else "")
    if isinstance(known, range):
        shown = f"0 to {len(known) - 1}" if known else "none"
    reason = f"{where} has no {what} {quoted(given)}"
    raise VividcError(reason, loc=loc, hint=f"{what}s are {shown}")


Extension = Callable[[ModelHandle], None]
"""A caller's function that adds constraints, or an objective, to a model."""
