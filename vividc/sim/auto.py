"""The engine that finishes first: the reference engine for short runs, native code otherwise."""

from __future__ import annotations

from dataclasses import replace
from threading import Lock
from typing import Final

from vividc.errors import CycleLimit
from vividc.program import Program
from vividc.sim.engine import Engine, Launch, Run
from vividc.sim.native import NativeEngine
from vividc.sim.reference.engine import ReferenceEngine

TRIAL_CYCLES: Final = 2_500
"""What the reference engine runs in about the time that compiling an ordinary kernel takes (0.04 to
0.13 s): whichever turns out the better, at most twice its time is spent.
"""


class AutoEngine:
    """Runs on the reference engine until it has cost as much as compiling would."""

    def __init__(self, program: Program) -> None:
        self._program = program
        self._engine: Engine = ReferenceEngine(program)
        self._left = TRIAL_CYCLES
        self._lock = Lock()

    def run(self, launch: Launch) -> Run:
        """Run the program once (see `Engine.run`)."""
        engine, left = self._engine, self._left
        # A trial that is given up would tell an observer of regions that run again.
        if left > 0 and launch.observer is None and isinstance(engine, ReferenceEngine):
            if launch.cycle_limit <= left:
                return self._counted(engine.run(launch))
            try:
                return self._counted(engine.run(replace(launch, cycle_limit=left, progress=None)))
            except CycleLimit:
                self._left = 0
        return self._native().run(launch)

    def _counted(self, run: Run) -> Run:
        self._left -= run.cycles
        return run

    def _native(self) -> Engine:
        with self._lock:
            if not isinstance(self._engine, NativeEngine):
                self._engine = NativeEngine(self._program)
            return self._engine
