"""Both engines on one launch: they must agree on everything, the error included."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vividc.errors import SimulationError
from vividc.program import Program
from vividc.sim import Engine, Launch, NativeEngine, ReferenceEngine, Run
from vividc.sim.accounting import work_of
from vividc.sim.bind import bind


def launch(program: Program, *args: object, cycle_limit: int = 1_000_000) -> Launch:
    """A launch with these arguments."""
    bound = bind(program, args, {})
    return Launch(bound.memory, bound.inputs, cycle_limit, bound.extents)


def outcome(engine: Engine, given: Launch) -> tuple[Run | str, bytes]:
    """The run without its engine's name, or the error's kind and text; and the final memory."""
    before = given.memory.copy()
    try:
        run = engine.run(given)
    except SimulationError as error:
        return f"{type(error).__name__}: {error}", b""
    finally:
        np.testing.assert_array_equal(given.memory, before)
    return replace(run, memory=np.zeros(0, np.uint32), engine=""), run.memory.tobytes()


def same(one: tuple[Run | str, bytes], other: tuple[Run | str, bytes]) -> None:
    """Demands equality, bit for bit."""
    if isinstance(one[0], str) or isinstance(other[0], str):
        assert other[0] == one[0]
        return
    fields = (Run.__dataclass_fields__.keys() - {"memory", "counts"}) | {"regions"}
    assert {f: getattr(other[0], f) for f in fields} == {f: getattr(one[0], f) for f in fields}
    assert other[1] == one[1]


def assert_engines_agree(program: Program, *launches: Launch) -> None:
    """Demands that both engines give the same for each launch, and for all of them together."""
    reference, native = ReferenceEngine(program), NativeEngine(program)
    outcomes = [(outcome(reference, given), outcome(native, given)) for given in launches]
    for one, other in outcomes:
        same(one, other)
    one_work, other_work = (
        work_of(program.table, [run for run, _ in some if isinstance(run, Run)])
        for some in zip(*outcomes, strict=True)
    )
    assert one_work == other_work


def agreed_run(program: Program, given: Launch) -> Run:
    """The run that both engines give."""
    assert_engines_agree(program, given)
    return NativeEngine(program).run(given)
