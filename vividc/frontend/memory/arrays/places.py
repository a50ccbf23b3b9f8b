"""Which place each array has that a kernel makes: its own, or one of a few that arrays take in turn
of which one variable is one after the other.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from vividc.errors import KernelError
from vividc.frontend.llvm.calls import RETURNED, RETURNED_ARRAY
from vividc.frontend.memory.arrays.by_array import apart, base_of, related, roots_of
from vividc.machine.params import Formula, LocalArray
from vividc.ssa.edit import replaced
from vividc.ssa.flow import flow_of
from vividc.ssa.ir import Function, Input, Instr, Phi, Ref, Value

_KEPT: Final = (
    "an array made in a loop is kept for the next iteration",
    "make both arrays before the loop, and copy elements",
)
_RETURNED: Final = (
    "the kernel returns one of several arrays, and which one is not known where it ends",
    "return one array, and fill it here or there",
)


def is_returned(op: Instr) -> bool:
    """Whether a call is told a part of what the kernel returns."""
    return op.op == "call" and op.pred.startswith(RETURNED)


def is_returned_array(op: Instr) -> bool:
    """Whether what it is told is an array."""
    return is_returned(op) and op.pred.endswith(RETURNED_ARRAY)


@dataclass(frozen=True, slots=True)
class Placed:
    """A function without allocations, and its places, each with an allocation that may take it."""

    function: Function
    places: tuple[tuple[LocalArray, int], ...]


def placed(function: Function, made: Mapping[int, LocalArray]) -> Placed:
    """The function with a pointer parameter called "&" + name in place of each allocation, where
    each array that it returns is one array.

    Parameters
    ----------
    made
        What each allocation makes.

    Raises
    ------
    KernelError
        Code for each array that a variable may be would be too long.
    """
    kept = [phi for id_ in made for phi in _kept_between(function, id_)]
    wanted = [*kept, *_returned_choices(function)]
    choices = related(function, wanted)
    places = _Places(function, made, choices)
    if not choices:
        alone = replaced(function, {id_: places(id_, 0) for id_ in made})
        return Placed(alone, places.used)
    told = apart(function, choices, places)
    if told is None:
        what, hint = _KEPT if kept else _RETURNED
        raise KernelError(what, loc=wanted[0].loc, hint=hint)
    return Placed(told, places.used)


def _kept_between(function: Function, id_: int) -> Iterator[Phi]:
    """The header phis by which what an allocation in a loop makes is there in the next iteration:
    each iteration's array would have the same place.
    """
    home = function.block_of[id_]
    for header, body in flow_of(function).loops.items():
        for phi in function.by_name[header].phis if home in body else ():
            if phi.type == "ptr" and id_ in roots_of(function, Ref(phi.id)):
                yield phi


def _returned_choices(function: Function) -> Iterator[Phi | Instr]:
    """What chooses between arrays, one of which is returned."""
    for block in function.blocks:
        for op in filter(is_returned_array, block.instrs):
            base = base_of(function, op.operands[0])
            if isinstance(base, Ref) and len(roots_of(function, base)) > 1:
                yield function.definitions[base.id]


class _Places:
    """The places of what a function makes: arrays that a variable may be one after the other have
    places in common.
    """

    def __init__(
        self, function: Function, made: Mapping[int, LocalArray], choices: Collection[int]
    ) -> None:
        self._groups: dict[int, tuple[int, ...]] = {id_: (id_,) for id_ in made}
        self._made = made
        self._used: dict[str, tuple[LocalArray, int]] = {}
        self._carried = {id_: {*self._loops_of(function, id_)} for id_ in made}
        for id_ in choices:
            together = {root for root in roots_of(function, Ref(id_)) if root in made}
            ids = {one for root in together for one in self._groups[root]}  # type: ignore[index]
            for one in ids:
                self._groups[one] = tuple(sorted(ids, key=list(made).index))

    def _loops_of(self, function: Function, id_: int) -> Iterator[object]:
        for phi in _kept_between(function, id_):
            yield function.by_name[function.block_of[phi.id]].branch.loc

    def __call__(self, id_: int, number: int) -> Value:
        """The array that an allocation makes in place number so many of its group."""
        group = self._groups[id_]
        name = self._made[group[0]].name
        if number:
            stem, line, rest = name.partition(".line")
            more = f"{stem}.{number}{line}{rest}"
            name = self._made[group[number]].name if number < len(group) else more
        self._used[name] = (self._largest(group, name), group[0])
        return Input(f"&{name}")

    def _largest(self, group: tuple[int, ...], name: str) -> LocalArray:
        """An array as large as any of a group, that each iteration has anew of all loops where all
        of them are made and none is kept.
        """
        arrays = [self._made[id_] for id_ in group]
        kept = {loop for id_ in group for loop in self._carried[id_]}
        common = set.intersection(*(set(one.loops) for one in arrays)) - kept
        loops = tuple(loop for loop in arrays[0].loops if loop in common)
        if not any(one.size for one in arrays):
            return LocalArray(name, max(one.words for one in arrays), loops=loops)
        size: Formula = ()
        for each in dict.fromkeys(one.size or (one.words,) for one in arrays):
            size = (*size, *each, "max") if size else each
        return LocalArray(name, 0, size=size, loops=loops)

    @property
    def used(self) -> tuple[tuple[LocalArray, int], ...]:
        """All places that are taken."""
        return tuple(self._used.values())
