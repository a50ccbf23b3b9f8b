"""The user's options for loop transformations."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Final, Literal, TypedDict

from vividc.errors import ArgumentError, demand_type, quoted, warn
from vividc.ssa.loops.threads.make import MOST_THREADS

_FACTORS: Final = (1, 2, 4, 8, 16, 32, 64)
_FACTOR_HINT: Final = f"a power of two up to {_FACTORS[-1]}; 1 leaves the loop as it is"
_CHOICE_HINT: Final = "True, or False to leave the loop as it is"
_LINE: Final = re.compile(r"[1-9][0-9]{0,8}")


@dataclass(frozen=True, slots=True)
class LoopOptions:
    """How `vividc.compile` transforms loops, which are named by source line.

    Attributes
    ----------
    auto
        Transform loops where an estimate says that it pays; False: only as the others say.
    unroll
        Factors by line, as in {12: 4}: 4 iterations of the loop on line 12 become one. A factor is
        a power of two up to 64; 1 leaves the loop as it is.
    jam
        Factors by line: so many iterations of the loop run together in the loop inside it. Where
        that one has a length of its own in each, they are interleaved, 8 at most.
    flatten
        Whether the loop on a line and the loop inside it become one, as in {12: True}.
    threads
        Iterations of the loop over `numba.prange` that a tile runs side by side, 1 to 8, each with
        loops and exits of its own. None: as many as the estimate says pay, if `auto`.
    restructure
        Give nests of affine loops another order, and tiles for registers, where the estimate says
        that it pays, if `auto`. Choosing takes a second or more for a nest; False: it takes less.

    Raises
    ------
    ArgumentError
        A value is none of these. A line may be given as text.
    """

    auto: bool = True
    unroll: Mapping[int, int] = field(default_factory=dict)
    jam: Mapping[int, int] = field(default_factory=dict)
    flatten: Mapping[int, bool] = field(default_factory=dict)
    threads: int | None = None
    restructure: bool = True

    def __post_init__(self) -> None:
        demand_type(self.auto, bool, "auto", "give True or False")
        demand_type(self.restructure, bool, "restructure", "give True or False")
        for name, values, hint in (
            ("unroll", _FACTORS, _FACTOR_HINT),
            ("jam", _FACTORS, _FACTOR_HINT),
            ("flatten", (False, True), _CHOICE_HINT),
        ):
            object.__setattr__(self, name, _by_line(name, getattr(self, name), values, hint))
        if self.threads is not None:
            hint = f"give 1 to {MOST_THREADS}; 1 leaves the loop over prange as it is"
            demand_type(self.threads, int, "threads", hint)
            if not 1 <= self.threads <= MOST_THREADS:
                raise ArgumentError(f"threads cannot be {quoted(self.threads)}", hint=hint)

    @property
    def idle(self) -> bool:
        """Nothing is to be transformed."""
        asked = self.unroll or self.jam or any(self.flatten.values()) or (self.threads or 1) > 1
        return not self.auto and not asked

    def __repr__(self) -> str:
        """As a user writes it."""
        given = (
            f"{one.name}={value!r}"
            for one in fields(self)
            if (value := getattr(self, one.name)) not in (one.default, {})
        )
        return f"LoopOptions({', '.join(given)})"


class FlatLoopOptions(TypedDict, total=False):
    """Keywords of `vividc.compile` that `LoopOptions` replaces."""

    transform: Literal["auto", "none"]
    unroll: Mapping[int, int] | Mapping[str, int] | None
    jam: Mapping[int, int] | Mapping[str, int] | None
    flatten: Mapping[int, bool] | Mapping[str, bool] | None
    threads: int | None


def loop_options(loops: LoopOptions | None, flat: Mapping[str, Any]) -> LoopOptions:
    """The options given to `vividc.compile`, whose caller is warned of flat ones.

    Raises
    ------
    ArgumentError
        `loops` is something else, a flat option makes no sense, or both are given.
    TypeError
        A keyword is none of `vividc.compile`'s.
    """
    if loops is not None:
        demand_type(loops, LoopOptions, "loops", "give vividc.LoopOptions(...)")
    if not flat:
        return loops or LoopOptions()
    for name in flat:
        if name not in FlatLoopOptions.__annotations__:
            raise TypeError(f"compile() got an unexpected keyword argument {name!r}")
    transform = flat.get("transform", "auto")
    if not isinstance(transform, str) or transform not in ("auto", "none"):
        hint = "loops=vividc.LoopOptions(auto=False) leaves loops as they are"
        raise ArgumentError(f"transform cannot be {quoted(transform)}", hint=hint)
    fields_given = {k: v for k, v in flat.items() if v is not None and k != "transform"}
    options = LoopOptions(transform == "auto", **fields_given)
    new = f"write loops=vividc.{options}"
    if loops is not None:
        raise ArgumentError(f"loops cannot go with {', '.join(flat)}", hint=new)
    warn(f"{', '.join(flat)}: {new}", DeprecationWarning)
    return options


def _by_line(name: str, given: object, values: tuple[object, ...], hint: str) -> dict[int, object]:
    demand_type(given, Mapping, name, f"write {name}={{12: {values[-1]}}} for the loop on line 12")
    assert isinstance(given, Mapping)
    by_line: dict[int, object] = {}
    for line, value in given.items():
        number = int(line) if isinstance(line, str) and _LINE.fullmatch(line) else line
        if isinstance(number, bool) or not isinstance(number, int) or number < 1:
            text = f"{name} cannot take {quoted(line)} for a line"
            raise ArgumentError(text, hint="lines of a file are numbered from 1")
        if type(value) is not type(values[0]) or value not in values:
            raise ArgumentError(f"{name} cannot take {quoted(value)}", hint=hint)
        by_line[number] = value
    return by_line
