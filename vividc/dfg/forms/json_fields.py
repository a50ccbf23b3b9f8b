"""Typed access to JSON objects that collects every problem before anything is raised."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, TypeVar

from vividc.errors import DFGError, SourceLoc, printable, quoted

T = TypeVar("T")
_MAX_DISTANCE: Final = 1 << 20
_LINE_DIGITS: Final = 9


_SHOWN = 20


class Problems(list[str]):
    """The first problems of a file, and how many there are: a large one may have millions."""

    total = 0

    def append(self, problem: str) -> None:
        """Record a problem."""
        self.total += 1
        if len(self) < _SHOWN:
            super().append(problem)


@dataclass(frozen=True, slots=True)
class Fields:
    """One JSON object at `place`; a getter that finds a wrong value records it."""

    data: Mapping[str, object]
    place: str
    problems: list[str]

    def problem(self, what: str) -> None:
        """Record a problem of this object."""
        self.problems.append(f"{self.place}: {what}" if self.place else what)

    def only(self, keys: frozenset[str]) -> None:
        """Record every key that is not among `keys`."""
        for key in self.data:
            if key not in keys:
                self.problem(f"unknown key {quoted(key)}; the keys are {', '.join(sorted(keys))}")

    def text(self, key: str, default: str | None) -> str:
        """A string; `default` None: it must be there."""
        value = self.data.get(key, default)
        if isinstance(value, str):
            return value
        self.problem(
            f"{key} is missing" if value is None else f"{key} {quoted(value)} is not a string"
        )
        return ""

    def integer(self, key: str, default: int) -> int:
        """An integer."""
        value = self.data.get(key, default)
        if isinstance(value, int) and not isinstance(value, bool):
            return value
        self.problem(f"{key} {quoted(value)} is no integer")
        return default

    def distance(self, key: str) -> int:
        """An integer that is not negative; 0 if absent."""
        value = self.integer(key, 0)
        if value < 0:
            self.problem(f"{key} {quoted(value)} is negative; it counts iterations, from 0 on")
        if value > _MAX_DISTANCE:
            self.problem(f"{key} {quoted(value)} is more than {_MAX_DISTANCE} iterations")
        return value

    def flag(self, key: str) -> bool:
        """A boolean; false if absent."""
        value = self.data.get(key, False)
        if not isinstance(value, bool):
            self.problem(f"{key} {quoted(value)} is neither true nor false")
        return value is True

    def identifier(self, key: str) -> int | str | None:
        """A node id as the file writes it: an integer from 0 on, or a string."""
        value = self.data.get(key)
        if isinstance(value, str) or (
            isinstance(value, int) and not isinstance(value, bool) and value >= 0
        ):
            return value
        shown = f"{key} is missing" if value is None else f"{key} {quoted(value)}"
        self.problem(f"{shown}: an id is a string or an integer from 0 on")
        return None

    def reference(self, key: str, numbers: Mapping[int | str, int]) -> int:
        """Number of the node that this id names."""
        value = self.identifier(key)
        if value is None:
            return -1
        if value not in numbers:
            self.problem(f"{key} {_plain(value)} is no node")
            return -1
        return numbers[value]

    def choice(self, key: str, choices: Mapping[str, T], default: T) -> T:
        """One of the named choices; `default` if absent."""
        value = self.data.get(key)
        if value is None:
            return default
        if isinstance(value, str) and value in choices:
            return choices[value]
        self.problem(f"{key} {quoted(value)} is not one of {', '.join(choices)}")
        return default

    def port(self, key: str, names: Mapping[str, int]) -> int | None:
        """A port number from 0 on, or a named port; None if absent."""
        value = self.data.get(key)
        if value is None:
            return None
        if isinstance(value, str) and value in names:
            return names[value]
        if isinstance(value, int) and not isinstance(value, bool) and value >= 0:
            return value
        self.problem(f"{key} {quoted(value)} is neither a port number nor {_listed(names)}")
        return None


def fields_of(data: Mapping[str, object], key: str, problems: list[str]) -> list[Fields]:
    """The objects of the array `key`."""
    entries = data.get(key)
    if not isinstance(entries, list):
        problems.append(f"{key} is missing" if entries is None else f"{key} is not an array")
        return []
    objects: list[Fields] = []
    for index, entry in enumerate(entries):
        place = f"{key}[{index}]"
        if isinstance(entry, dict):
            objects.append(Fields(entry, place, problems))
        else:
            problems.append(f"{place}: {quoted(entry)} is not an object")
    return objects


def parse_loc(text: str) -> SourceLoc | None:
    """The source line written `file:line`, or None if the text is none."""
    file, colon, line = text.rpartition(":")
    is_line = colon and line.isdecimal() and len(line) <= _LINE_DIGITS
    return SourceLoc(file, int(line)) if is_line else None


def raise_problems(
    file: str,
    problems: Sequence[str],
    lines: Mapping[str, int] | None = None,
    hint: str | None = None,
) -> None:
    """Raise one `DFGError` that lists all problems, if there are any.

    Parameters
    ----------
    lines
        Line of each place, such as "nodes[3]", that a problem may begin with.
    """
    if not problems:
        return
    known = {} if lines is None else lines
    places = [place_of(file, problem, known) for problem in problems[:_SHOWN]]
    first, *others = zip(places, problems, strict=False)
    shown = [first[1], *(text if at == file else f"{at}: {text}" for at, text in others)]
    total = problems.total if isinstance(problems, Problems) else len(problems)
    if total > _SHOWN:
        shown.append(f"and {total - _SHOWN} more")
    raise DFGError("\n    ".join(shown), loc=first[0], hint=hint)


def place_of(file: str, problem: str, lines: Mapping[str, int]) -> str:
    """File, and line if known, of an entry such as "nodes[3]", or of a problem that begins so."""
    line = lines.get(problem.partition(":")[0])
    return file if line is None else f"{file}:{line}"


def _plain(node_id: int | str) -> str:
    return printable(node_id) if isinstance(node_id, str) else quoted(node_id)


def _listed(names: Iterable[str]) -> str:
    *others, last = names
    return f"{', '.join(others)} or {last}" if others else last
