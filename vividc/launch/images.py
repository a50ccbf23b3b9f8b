"""Programs as tiles take them: mirrored, as a tile is in its corner of a cluster."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from threading import Lock
from typing import Final, Generic, TypeVar

from vividc import arch
from vividc.arch import Accelerator, Fabric
from vividc.arch.accelerator import Orientation
from vividc.errors import ArgumentError, demand_type
from vividc.program import Program
from vividc.program.encoder.reflect import reflected_program

Made = TypeVar("Made")


class Kept(Generic[Made]):
    """Values by program and key, the ones used last, as making one takes longer than a run.
    Programs are told apart by identity, which needs no hash of their words; they are frozen, and
    held as long as their values are.

    Parameters
    ----------
    most
        Values that are kept.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._values: OrderedDict[tuple[int, Hashable], tuple[Program, Made]] = OrderedDict()
        self._lock = Lock()

    def get(self, program: Program, key: Hashable, make: Callable[[], Made]) -> Made:
        """Return the value of `program` and `key`; `make` makes it if it is not there."""
        where = (id(program), key)
        with self._lock:
            if where in self._values:
                self._values.move_to_end(where)
                return self._values[where][1]
        made = make()
        with self._lock:
            self._values[where] = (program, made)
            while len(self._values) > self._most:
                self._values.popitem(last=False)
        return made


_MIRRORED: Final[Kept[tuple[Fabric, Fabric, Program]]] = Kept(256)
"""By program and corner, with the fabrics between which they were mirrored."""


class Images:
    """The images of programs on the units of an accelerator."""

    def __init__(self, accelerator: Accelerator) -> None:
        self._accelerator = accelerator
        self._known: dict[tuple[int, str], Program] = {}

    def of(self, program: Program, unit: int) -> Program:
        """Return the program as a tile or a group of tiles takes it.

        Raises
        ------
        ArgumentError
            It was not compiled for that, or has more contexts than it holds.
        """
        demand_type(program, Program, "the program", "compile a kernel with vividc.compile")
        grouped = unit >= len(self._accelerator.tiles)
        home = self._accelerator.units[unit] if grouped else self._accelerator.fabric
        corner = self._accelerator.orientation(unit)
        key = (id(program), f"{corner} {home.name}")
        if key not in self._known:
            self._demand_fit(program, home, f"unit {unit} of" if grouped else "the tiles of")
            image = program
            if not grouped:
                image = _mirrored(program, home, self._accelerator.tiles[unit], corner)
            self._known[key] = image
            self._known[id(program), ""] = program  # keeps the id from being used again
        return self._known[key]

    def _demand_fit(self, program: Program, home: Fabric, which: str) -> None:
        name, most = self._accelerator.name, home.controller.contexts
        if not arch.is_isomorphism(program.fabric, home, tuple(range(len(home.pes)))):
            verb = "are" if which == "the tiles of" else "is"
            raise ArgumentError(
                f"{program.name} was compiled for {program.fabric_name}, and {which} {name} {verb} "
                f"{home.name}",
                hint=f"compile it with fabric={name!r}",
            )
        if len(program.words) > most:
            raise ArgumentError(
                f"{program.name} has {len(program.words)} contexts, and a tile of {name} holds "
                f"{most}",
                hint=f"compile it with fabric={name!r}, or simulate it on one tile, which brings "
                "contexts: leave the fabric out",
            )


def _mirrored(program: Program, home: Fabric, there: Fabric, corner: Orientation) -> Program:
    """The program of the tile in a corner; kept for the next job."""

    def mirrored() -> tuple[Fabric, Fabric, Program]:
        places = arch.reflection(home, corner)
        return home, there, reflected_program(program, there, places)

    kept = _MIRRORED.get(program, corner, mirrored)
    return (kept if kept[:2] == (home, there) else mirrored())[2]
