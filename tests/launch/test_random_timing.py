"""Random launch graphs on random accelerators: machine code and plain Python tell the same times,
cycle by cycle.
"""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.launch.kernels import double, program, saxpy, total
from tests.launch.plain_timing import PlainTiming
from vividc import arch
from vividc.arch import Accelerator, TileGroup
from vividc.launch.functional import Outcome
from vividc.launch.hazards import predecessors
from vividc.launch.steps import Configure, Execute, Listed, Pieces, Step, Transfer
from vividc.launch.timing import schedule

CAUSES = ("dma", "configuration", "dependency", "launch", "scratchpad")
MOVED = ("dram_read", "dram_written", "dram_wanted", "noc", "scratchpad_in", "scratchpad_out")


def random_machine(rng: np.random.Generator) -> Accelerator:
    """Of 1 to 16 tiles, and sometimes groups of them."""
    rows, cols = (int(rng.choice([1, 2, 4])) for _ in range(2))
    text = (
        f"extends: vivid\nname: test\ntiles: {{rows: {rows}, cols: {cols}}}\n"
        f"dram: {{bytes_per_cycle: {rng.choice([4, 32, 48, 128])},"
        f" latency: {rng.choice([0, 3, 100])}, granule_bytes: {rng.choice([4, 32, 64])}}}\n"
        f"noc: {{bytes_per_cycle: {rng.choice([4, 24, 32, 128])}, latency: {rng.choice([0, 8])}}}\n"
        f"dma: {{engines: {rng.integers(1, 6)}, setup_cycles: {rng.choice([0, 1, 16])},"
        f" burst_bytes: {rng.choice([64, 256])}}}\n"
        f"configuration: {{entries_per_cycle: {rng.choice([1, 16, 4096])},"
        f" double_buffered: {rng.choice(['true', 'false'])}}}\n"
    )
    machine = arch.load_accelerator_text(text)
    if len(machine.tiles) > 1 and rng.random() < 0.4:
        pair, everything = TileGroup(machine.fabric, (0, 1)), range(len(machine.tiles))
        machine = replace(machine, groups=(pair, TileGroup(machine.fabric, tuple(everything))))
    return machine


def random_pieces(rng: np.random.Generator, most: int) -> Pieces:
    count = int(rng.integers(0, most))
    spans = np.stack((rng.integers(0, 5000, count), rng.choice([0, 4, 36, 256, 900], count)), 1)
    return Pieces(0, spans.astype(np.int64))


class RandomJob:
    """Steps that each wait for some before, and what their runs and transfers by a list did."""

    def __init__(self, rng: np.random.Generator, machine: Accelerator) -> None:
        self.rng, self.machine = rng, machine
        self.steps: list[Step] = []
        self.outcome = Outcome()
        self.held: dict[int, int] = {}
        for _ in range(int(rng.integers(1, 60))):
            self.add()

    def add(self) -> None:
        rng, units = self.rng, len(self.machine.units)
        number = len(self.steps)
        after = {int(n) for n in number - 1 - rng.integers(0, 12, 3) if n >= 0}
        chosen: dict[str, Any] = {"after": tuple(sorted(after)[: rng.integers(0, 4)])}
        transfers = ["move in", "move out", "gather", "scatter"]
        kind = rng.choice(["configure", "run", "run", "run", *transfers])
        several: tuple[int, ...] = ()
        for unit in {int(tile) for tile in rng.integers(0, units, 3)}:
            if self.machine.sharing[unit].isdisjoint(several):
                several += (unit,)
        tile = int(rng.integers(0, units))
        if kind == "run" and tile in self.held:
            cycles = int(rng.choice([0, 1, 40, 700, 5000]))
            self.outcome.runs[number] = SimpleNamespace(cycles=cycles)
            by = self.held[tile]
            code = self.steps[by].programs[0]
            self.steps.append(Execute(tile, code, code, {}, {}, {}, by, **chosen))
        elif kind in ("configure", "run"):
            code = program([saxpy, double, total][int(rng.integers(3))])
            self.steps.append(Configure(several, (code,) * len(several), **chosen))
            for unit in several:
                for other in self.machine.sharing[unit]:
                    self.held.pop(other, None)
            self.held.update(dict.fromkeys(several, number))
        else:
            self.steps.append(self.transfer(kind, several, number, chosen))

    def transfer(self, kind, several, number, chosen) -> Transfer:
        tiles = several[:1] if kind in ("move out", "scatter") else several
        if kind in ("gather", "scatter"):
            self.outcome.chosen[number] = random_pieces(self.rng, 30)
            if len(tiles) == 1 and self.rng.random() < 0.5:
                chosen["listed"] = Listed(int(self.rng.choice([0, 36])), 900)
                self.outcome.listed[number] = int(self.rng.choice([0, 1, 60, 200]))
            else:
                chosen["index_pieces"] = random_pieces(self.rng, 4)
        elif kind == "move out" and self.rng.random() < 0.5:
            chosen["count_at"] = int(self.rng.choice([0, 252]))
            self.outcome.chosen[number] = random_pieces(self.rng, 6)
        pitch = int(self.rng.choice([4, 4, 8, 64]))
        pieces = random_pieces(self.rng, 6)
        return Transfer(kind, tiles, 0, pieces, np.empty(0), pitch=pitch, **chosen)


def check(seed: int) -> None:
    rng = np.random.default_rng(seed)
    machine = random_machine(rng)
    job = RandomJob(rng, machine)
    waits = predecessors(job.steps, machine.sharing)
    plain = PlainTiming(machine, job.steps, waits, job.outcome)
    plain.run()
    timing = schedule(machine, job.steps, waits, job.outcome)
    assert timing.spans.tolist() == plain.spans
    assert timing.record.events() == tuple(plain.events)
    assert timing.cycles == max(end for _, _, end in plain.spans)
    assert timing.busy == {"dram": plain.dram.busy, "noc": plain.noc.busy}
    assert {name: getattr(timing.moved, name) for name in MOVED} == {
        name: plain.moved[name] for name in MOVED
    }
    for tile, free_from, stalls in zip(timing.tiles, plain.free_from, plain.stalls, strict=True):
        assert tile.free_from == free_from
        assert tile.stalls == {cause: stalls[cause] for cause in CAUSES}


@pytest.mark.parametrize("first", [0, 20])
def test_random_graphs(first: int) -> None:
    for seed in range(first, first + 20):
        check(seed)


@pytest.mark.slow
def test_many_random_graphs() -> None:
    for seed in range(1000, 2000):
        check(seed)
