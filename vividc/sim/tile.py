"""A tile that holds one program: bound once, launched often, on either engine."""

from __future__ import annotations

from vividc.errors import ArgumentError
from vividc.program import Program
from vividc.sim.engine import Engine, EngineFactory, Launch, Run
from vividc.sim.reference import ReferenceEngine

TileResult = Run
"""What a launch on a tile gives: memory, cycles, activity; `engine` names what ran it."""

ENGINES: dict[str, EngineFactory] = {"reference": ReferenceEngine}
"""Engines by name; all give the same `Run` for the same launch."""

AUTO = "auto"


class Tile:
    """One tile with a program in its configuration memory.

    Decoding, and compiling to native code, happen once; launches differ in memory and inputs. A
    tile may be launched from several threads at once: launches share nothing that changes.

    Parameters
    ----------
    engine
        A key of `ENGINES`, or "auto": the one that is done first.

    Raises
    ------
    ArgumentError
        The engine is unknown.
    """

    def __init__(self, program: Program, engine: str = AUTO) -> None:
        if engine != AUTO and engine not in ENGINES:
            names = ", ".join(sorted([AUTO, *ENGINES]))
            raise ArgumentError(f"unknown engine {engine!r}", hint=f"engines: {names}")
        self.program = program
        self._engine: Engine = ENGINES["reference" if engine == AUTO else engine](program)

    def run(self, launch: Launch) -> TileResult:
        """Run the program once.

        Raises
        ------
        SimulationError
            The program did something the machine forbids, or the cycle limit was reached; the
            launch's memory is as it was.
        """
        return self._engine.run(launch)
