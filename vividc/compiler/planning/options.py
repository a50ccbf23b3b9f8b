"""What the user says about loop transformations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from vividc.errors import ArgumentError, demand_type, quoted
from vividc.ssa.loops.threads.make import MOST_THREADS

Mode = Literal["auto", "none"]
Factors = Mapping[int, int] | Mapping[str, int]
"""Factors by source line; a line may be given as text."""

Choices = Mapping[int, bool] | Mapping[str, bool]
"""Decisions by source line; a line may be given as text."""

_MODES = ("auto", "none")
_LARGEST_FACTOR = 64


@dataclass(frozen=True, slots=True)
class TransformOptions:
    """Attributes
    ----------
    mode
        "auto": what the estimate says pays; "none": only what the others ask for.
    unroll, jam
        Factors of loops by source line; 1 leaves the loop as it is.
    flatten
        Whether to make one loop of the loop in a line and the loop inside it.
    threads
        Iterations of the loop over `prange` that run side by side; 1 leaves it as it is, None: as
        the mode says.
    """

    mode: Mode = "auto"
    unroll: Mapping[int, int] = field(default_factory=dict)
    jam: Mapping[int, int] = field(default_factory=dict)
    flatten: Mapping[int, bool] = field(default_factory=dict)
    threads: int | None = None

    @property
    def idle(self) -> bool:
        """Nothing is to be transformed."""
        asked = self.unroll or self.jam or any(self.flatten.values()) or (self.threads or 1) > 1
        return self.mode == "none" and not asked


def transform_options(
    transform: object,
    unroll: Factors | None,
    jam: Factors | None,
    flatten: Choices | None = None,
    threads: int | None = None,
) -> TransformOptions:
    """The options as given to `vividc.compile`, checked.

    Raises
    ------
    ArgumentError
        An unknown mode, a line that is no line number, a factor that is no power of two, a
        choice that is neither True nor False, or threads that are not 1 to 8.
    """
    hint = 'give transform="auto" or transform="none"'
    if not isinstance(transform, str) or transform not in _MODES:
        raise ArgumentError(f"transform cannot be {quoted(transform)}", hint=hint)
    mode: Mode = "auto" if transform == "auto" else "none"
    choices = _choices("flatten", flatten)
    factors = _factors("unroll", unroll), _factors("jam", jam)
    return TransformOptions(mode, *factors, choices, _threads(threads))


def _threads(given: object) -> int | None:
    if given is None:
        return None
    if isinstance(given, bool) or not isinstance(given, int) or not 1 <= given <= MOST_THREADS:
        hint = f"give 1 to {MOST_THREADS} threads of a tile; 1 leaves the loop over prange as it is"
        raise ArgumentError(f"threads cannot be {quoted(given)}", hint=hint)
    return given


def _choices(name: str, given: Choices | None) -> dict[int, bool]:
    hint = f"write {name}={{12: True}} for the loop in line 12, or False to leave it"
    if given is None:
        return {}
    demand_type(given, Mapping, name, hint)
    found: dict[int, bool] = {}
    for line, wanted in given.items():
        if not isinstance(wanted, bool):
            raise ArgumentError(f"{name} cannot take {quoted(wanted)}", hint=hint)
        found[_line(name, line, hint)] = wanted
    return found


def _line(name: str, line: object, hint: str) -> int:
    number = int(line) if isinstance(line, str) and line.isdecimal() else line
    if isinstance(number, bool) or not isinstance(number, int) or number < 1:
        raise ArgumentError(f"{name} cannot take {quoted(line)} for a line", hint=hint)
    return number


def _factors(name: str, given: Factors | None) -> dict[int, int]:
    hint = f"write {name}={{12: 4}} for the loop in line 12, by 4"
    if given is None:
        return {}
    demand_type(given, Mapping, name, hint)
    found: dict[int, int] = {}
    for line, factor in given.items():
        number = _line(name, line, hint)
        if not _is_factor(factor):
            text = f"{name} cannot take the factor {quoted(factor)}"
            powers = f"a power of two up to {_LARGEST_FACTOR}; 1 leaves the loop alone"
            raise ArgumentError(text, hint=powers)
        found[number] = int(str(factor))
    return found


def _is_factor(factor: object) -> bool:
    if isinstance(factor, bool) or not isinstance(factor, int):
        return False
    return 1 <= factor <= _LARGEST_FACTOR and factor & (factor - 1) == 0
