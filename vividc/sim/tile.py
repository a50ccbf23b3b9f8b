"""A tile that holds one program: bound once, launched often, on any engine."""

from __future__ import annotations

from collections import OrderedDict
from threading import Lock
from typing import Final

from vividc.errors import ArgumentError, quoted
from vividc.program import Program
from vividc.sim.auto import AutoEngine
from vividc.sim.engine import Engine, EngineFactory, Launch, Run
from vividc.sim.native import NativeEngine
from vividc.sim.reference.engine import ReferenceEngine

TileResult = Run
"""What a launch on a tile gives: memory, cycles, activity; `engine` names what ran it."""

AUTO: Final = "auto"
REFERENCE: Final = "reference"

ENGINES: Final[dict[str, EngineFactory]] = {
    AUTO: AutoEngine,
    "native": NativeEngine,
    REFERENCE: ReferenceEngine,
}
"""Engines by name; all give the same `Run` for the same launch, but for the name of the engine."""


def check_engine(engine: object) -> None:
    """Refuse an unknown engine.

    Raises
    ------
    ArgumentError
        The engine is unknown.
    """
    if not isinstance(engine, str) or engine not in ENGINES:
        hint = f"engines: {', '.join(sorted(ENGINES))}"
        raise ArgumentError(f"unknown engine {quoted(engine)}", hint=hint)


class Tile:
    """One tile with a program in its configuration memory.

    Decoding, and compiling to native code, happen once; launches differ in memory and inputs. A
    tile may be launched from several threads at once: launches share nothing that changes, and
    native code holds no lock of Python's.

    Parameters
    ----------
    engine
        A key of `ENGINES`; "auto": the engine that is done first.

    Raises
    ------
    ArgumentError
        The engine is unknown.
    """

    def __init__(self, program: Program, engine: str = AUTO) -> None:
        check_engine(engine)
        self.program = program
        self._engine: Engine = ENGINES[engine](program)

    def run(self, launch: Launch) -> TileResult:
        """Run the program once.

        Raises
        ------
        SimulationError
            The program did something the machine forbids, or the cycle limit was reached; the
            launch's memory is as it was.
        """
        return self._engine.run(launch)


_KEPT: Final = 64
_LOCK: Final = Lock()
_known: OrderedDict[tuple[int, str], Tile] = OrderedDict()


def shared_tile(program: Program, engine: str = AUTO) -> Tile:
    """Return the tile that holds a program, always the same one: decoding takes longer than a short
    launch.

    Raises
    ------
    ArgumentError
        The engine is unknown.
    """
    key = id(program), engine
    with _LOCK:
        if key in _known:
            _known.move_to_end(key)
            return _known[key]
    tile = Tile(program, engine)  # it keeps the program, so that its id stays in use
    with _LOCK:
        _known[key] = tile
        if len(_known) > _KEPT:
            _known.popitem(last=False)
    return tile
