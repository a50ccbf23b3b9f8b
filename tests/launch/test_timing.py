"""Cycles from first principles: what the rules of docs/accelerator.md say, computed by hand."""

from __future__ import annotations

import numpy as np
import pytest

import vividc
from tests.launch.kernels import double, program, saxpy
from vividc import arch
from vividc.arch import Accelerator
from vividc.launch import At, Job, JobResult, Listed, SpreadOptions, spread
from vividc.sim.engine import Launch
from vividc.sim.tile import Tile

SETUP, DRAM_LATENCY, NOC_LATENCY, BURST = 16, 100, 8, 256
CYCLES_A_BURST = BURST // 32  # DRAM, NoC and a scratchpad's line alike


def machine(text: str = "") -> Accelerator:
    """`vivid` with other numbers; programs are there at once unless `text` says otherwise."""
    fast = "" if "configuration" in text else "configuration: {entries_per_cycle: 65536}\n"
    return arch.load_accelerator_text(f"extends: vivid\nname: test\n{fast}{text}")


def move_in(size: int) -> int:
    """Cycles of one transfer of whole bursts from DRAM, alone."""
    first = SETUP + CYCLES_A_BURST + DRAM_LATENCY + CYCLES_A_BURST + NOC_LATENCY
    return first + (size // BURST - 1) * CYCLES_A_BURST


def move_out(size: int) -> int:
    """The same to DRAM: NoC, its latency, DRAM."""
    first = SETUP + CYCLES_A_BURST + NOC_LATENCY + CYCLES_A_BURST
    return first + (size // BURST - 1) * CYCLES_A_BURST


def accounted(result: JobResult) -> None:
    """Every tile's cycles are told, to the last."""
    for tile in result.stats["tiles"]:
        assert sum(tile["cycles"].values()) + sum(tile["stalls"].values()) == result.cycles


@pytest.mark.parametrize("bursts", [1, 2, 5])
def test_a_transfer_alone(bursts: int) -> None:
    x = np.arange(64 * bursts, dtype=np.int32)
    job = Job(machine())
    job.move_in(0, x, 0)
    assert job.simulate().cycles == move_in(x.nbytes)
    job = Job(machine())
    job.move_out(0, 0, x)
    assert job.simulate().cycles == move_out(x.nbytes)


def test_a_burst_takes_whole_granules() -> None:
    x = np.arange(256, dtype=np.int32)
    job = Job(machine())
    job.move_in(0, x[7:9], 0)  # 8 bytes over two granules of 32
    result = job.simulate()
    assert result.cycles == SETUP + 2 + DRAM_LATENCY + 1 + NOC_LATENCY
    assert result.stats["bytes"]["dram_read"] == 64
    assert result.stats["bytes"]["dram_wanted"] == 8


def test_a_strided_transfer_is_a_burst_for_each_row() -> None:
    x = np.zeros((10, 64), np.int32)
    job = Job(machine())
    job.move_in(0, x[:, :8], 0)
    # A row is a granule, which DRAM gives in a cycle and the NoC takes in one.
    assert job.simulate().cycles == SETUP + 1 + DRAM_LATENCY + 1 + NOC_LATENCY + 9


def test_a_gather_reads_its_indices_first() -> None:
    table = np.arange(800, dtype=np.int32).reshape(100, 8)
    rows = np.array([3, 99, 3, 0], np.int32)
    job = Job(machine())
    job.gather(0, table, rows, 0)
    result = job.simulate()
    indices = SETUP + 1 + DRAM_LATENCY
    assert result.cycles == indices + 1 + DRAM_LATENCY + 1 + NOC_LATENCY + 3
    assert result.stats["bytes"]["dram_read"] == 32 + 4 * 32


@pytest.mark.parametrize("listed", [False, True])
def test_a_scatter_reads_its_indices_first(listed: bool) -> None:
    table = np.zeros((100, 8), np.int32)
    numbers = np.array([4, 3, 99, 3, 0], np.int32)
    job = Job(machine())
    moved = job.move_in(0, numbers, 2048)
    job.scatter(0, 0, table, Listed(2048, 7) if listed else numbers[1:], after=[moved])
    result = job.simulate()
    cycles = [event.end - event.start for event in result.events if event.kind == "scatter"]
    # A granule from DRAM, or a line of the scratchpad; then four lines, one granule each.
    indices = SETUP + 1 + (NOC_LATENCY if listed else DRAM_LATENCY)
    assert cycles == [indices + 1 + NOC_LATENCY + 1 + 3]
    moved_bytes = result.stats["bytes"]
    assert moved_bytes["dram_written"] == 4 * 32
    assert moved_bytes["dram_read"] == (32 if listed else 2 * 32)
    assert moved_bytes["scratchpad_out"] == 4 * 32 + (20 if listed else 0)
    assert moved_bytes["noc"] == 20 + moved_bytes["scratchpad_out"]


def test_a_scatter_of_no_rows_is_done_when_its_length_is_read() -> None:
    """Without indices it is, after its setup."""
    table = np.zeros((4, 8), np.int32)
    job = Job(machine())
    zero = job.move_in(0, np.zeros(1, np.int32), 2048)
    listed = job.scatter(0, 0, table, Listed(2048, 2), after=[zero])
    given = job.scatter(0, 0, table, np.zeros(0, np.int32), after=[listed])
    cycles = {event.step: event.end - event.start for event in job.simulate().events}
    assert (cycles[listed], cycles[given]) == (SETUP + 1 + NOC_LATENCY, SETUP)


def test_rows_that_are_no_whole_granules_are_written_as_by_a_move_out() -> None:
    """Of 12 bytes: one in two granules of 32, and one in a single one."""
    table = np.zeros((100, 3), np.int32)
    both = [Job(machine()), Job(machine())]
    both[0].move_out(0, 0, table[2:10:7])
    both[1].scatter(0, 0, table, np.array([2, 9], np.int32))
    moved, scattered = (job.simulate() for job in both)
    assert moved.cycles == SETUP + 1 + NOC_LATENCY + 2 + 1
    assert scattered.cycles == moved.cycles + 1 + DRAM_LATENCY
    assert moved.stats["bytes"]["dram_written"] == 3 * 32
    assert scattered.stats["bytes"]["dram_written"] == 3 * 32


@pytest.mark.parametrize("bursts", [0, 1, 3])
def test_a_counted_transfer_reads_its_count_first(bursts: int) -> None:
    x = np.zeros((5, 64), np.int32)
    job = Job(machine())
    counts = job.move_in(0, np.array([bursts], np.int32), 2048)
    job.move_out(0, 0, x, count_at=2048, after=[counts])
    result = job.simulate()
    word = SETUP + 1 + NOC_LATENCY
    moved = [e.end - e.start for e in result.events if e.kind == "move out"]
    assert moved == [word if not bursts else word + move_out(bursts * BURST) - SETUP]
    assert result.stats["bytes"]["scratchpad_out"] == 4 + bursts * BURST


@pytest.mark.parametrize(
    ("rows", "granules", "cycles"),
    [
        pytest.param([5, 9, 6, 1, 13], 5, 5, id="another granule each time"),
        pytest.param([4, 5, 6, 7, 9], 2, 2, id="adjacent"),
        pytest.param([2, 3, 4, 5, 6], 2, 3, id="adjacent, in two granules"),
        pytest.param([6, 4, 7, 9, 9], 2, 2, id="in one granule, in any order"),
        pytest.param([4, 4, 4, 4, 4], 5, 5, id="more than a granule holds"),
        pytest.param([7, 8, 8, 11, 1], 4, 4, id="one that reaches into the next granule"),
    ],
)
def test_rows_that_lie_together_are_one_piece(rows: list[int], granules: int, cycles: int) -> None:
    """A granule holds four of them."""
    table = np.arange(200, dtype=np.int32).reshape(100, 2)
    indices = SETUP + 1 + DRAM_LATENCY
    job = Job(machine())
    job.gather(0, table, np.array(rows, np.int32), 0)
    result = job.simulate()
    assert result.cycles == indices + cycles + DRAM_LATENCY + NOC_LATENCY + 1
    assert result.stats["bytes"]["dram_read"] == 32 * (1 + granules)
    assert result.stats["bytes"]["dram_wanted"] == 4 * 5 + 40
    assert result.stats["bytes"]["scratchpad_in"] == 40
    job = Job(machine())
    job.scatter(0, 0, table, np.array(rows, np.int32))
    result = job.simulate()
    assert result.cycles == indices + cycles + NOC_LATENCY + 1
    assert result.stats["bytes"]["dram_read"] == 32
    assert result.stats["bytes"]["dram_written"] == 32 * granules
    assert result.stats["bytes"]["dram_wanted"] == 4 * 5 + 40
    assert result.stats["bytes"]["scratchpad_out"] == 40


def test_two_engines_share_the_channel() -> None:
    x = np.zeros((2, 256), np.int32)
    job = Job(machine())
    job.move_in(0, x[0], 0)
    job.move_in(1, x[1], 0)
    result = job.simulate()
    # Eight bursts pass the channel one after the other; setup and latencies overlap.
    assert result.cycles == move_in(8 * BURST)
    assert [event.end for event in result.events] == [move_in(4 * BURST), move_in(8 * BURST)]


def test_one_engine_does_one_transfer_after_the_other() -> None:
    x = np.zeros((2, 256), np.int32)
    job = Job(machine("dma: {engines: 1}\n"))
    job.move_in(0, x[0], 0)
    job.move_in(1, x[1], 0)
    assert job.simulate().cycles == 2 * move_in(1024)


def test_ports_of_tiles_work_in_parallel() -> None:
    """A trunk of 128 bytes a cycle feeds four scratchpads, which take 32 each."""
    wide = machine("dram: {bytes_per_cycle: 128}\nnoc: {bytes_per_cycle: 128}\n")
    x = np.zeros((4, 256), np.int32)
    beyond = SETUP + 2 + DRAM_LATENCY + NOC_LATENCY
    for tiles in ((0, 1, 2, 3), (0, 0, 0, 0)):
        job = Job(wide)
        for row, tile in enumerate(tiles):
            job.move_in(tile, x[row], 1024 * row)
        # The last tile's first burst leaves DRAM behind twelve others; or all pass one port.
        last = 12 * 2 + 4 * CYCLES_A_BURST if len(set(tiles)) == 4 else 16 * CYCLES_A_BURST
        assert job.simulate().cycles == beyond + last


def test_a_slow_port_does_not_hold_the_trunk() -> None:
    """Words eight lines apart meet in one bank: their tile takes a word a cycle, others do not."""
    x = np.zeros(64, np.int32)
    job = Job(machine())
    slow = job.move_in(0, x, 0, pitch=32)
    fast = job.move_in(1, x, 0)
    ends = {event.step: event.end for event in job.simulate().events}
    assert ends[fast] == SETUP + 2 * CYCLES_A_BURST + DRAM_LATENCY + CYCLES_A_BURST + NOC_LATENCY
    assert ends[slow] == SETUP + CYCLES_A_BURST + DRAM_LATENCY + NOC_LATENCY + 64


def test_a_broadcast_crosses_the_network_once() -> None:
    x = np.arange(256, dtype=np.int32)
    job = Job(machine())
    job.move_in(range(16), x, 0)
    result = job.simulate()
    assert result.cycles == move_in(x.nbytes)
    assert result.stats["bytes"]["noc"] == x.nbytes
    assert result.stats["bytes"]["scratchpad_in"] == 16 * x.nbytes


def test_a_full_reload_is_the_papers_2560_cycles() -> None:
    """Equations 4 and 5: 256 PEs, ten contexts, an entry a cycle; nothing runs meanwhile."""
    code = program(saxpy)
    assert code.words.shape[0] == 10
    job = Job("vivid")
    job.configure(range(16), code)
    assert job.simulate().cycles == 2560


def two_programs(iterations: int) -> JobResult:
    """All tiles run one program and then another, each of ten contexts."""
    x = np.zeros(1024, np.int32)
    first, second = program(saxpy), program(saxpy.__class__(saxpy.py_func, SAXPY, "again"))
    job = Job("vivid")
    here = job.move_in(range(16), x, 0)
    arguments = {"x": At(0, (1024,)), "y": At(4096, (1024,)), "n": iterations}
    job.configure(range(16), first)
    for tile in range(16):
        job.run(tile, first, after=[here], **arguments)
    job.configure(range(16), second)
    for tile in range(16):
        job.run(tile, second, **{**arguments, "n": 1})
    return job.simulate()


SAXPY = "void(float32[::1], float32[::1], int32)"


def test_what_of_a_switch_does_not_fit_behind_the_kernel_is_a_bubble() -> None:
    result = two_programs(16)
    loads = [event for event in result.events if event.kind == "configure"]
    assert [(event.start, event.end) for event in loads] == [(0, 2560), (2560, 5120)]
    for tile in range(16):
        runs = [e for e in result.events if e.kind == "run" and e.index == tile]
        assert runs[0].start == 2560
        assert runs[1].start == 5120
        bubble = 5120 - runs[0].end
        assert result.stats["tiles"][tile]["stalls"]["configuration"] == 2560 + bubble
    accounted(result)


def test_a_switch_hides_behind_a_long_kernel() -> None:
    result = two_programs(1000)
    for tile in range(16):
        runs = [e for e in result.events if e.kind == "run" and e.index == tile]
        if runs[0].end >= 5120:
            assert runs[1].start == runs[0].end
            assert result.stats["tiles"][tile]["stalls"]["configuration"] == 2560
        else:
            assert runs[1].start == 5120


def test_without_a_shadow_memory_a_reload_waits_for_the_kernel() -> None:
    text = "configuration: {double_buffered: false, entries_per_cycle: 1}\n"
    job = Job(machine("tiles: {rows: 1, cols: 1}\n" + text))
    x = np.zeros(64, np.int32)
    code, other = program(saxpy), program(double)
    moved = job.move_in(0, x, 0)
    arguments = {"x": At(0, (64,)), "y": At(256, (64,)), "n": 64}
    job.run(0, code, after=[moved], **arguments)
    job.run(0, other, x=At(0, (64,)), n=64)
    result = job.simulate()
    run = next(e for e in result.events if e.kind == "run")
    load = [e for e in result.events if e.kind == "configure"][1]
    assert load.start == run.end
    assert load.end == run.end + 16 * other.words.shape[0]


def tile_cycles(n: int) -> int:
    """Cycles of `double` on n words, alone on a tile."""
    code = program(double)
    inputs = {"n": n, "&x": 0, "x.shape0": n}
    memory = np.zeros(code.fabric.scratchpad.words, np.uint32)
    return Tile(code).run(Launch(memory, inputs, 100_000)).cycles


def test_a_job_without_overlap_is_the_sum_of_its_parts() -> None:
    code = program(double)
    x = np.arange(4 * 256, dtype=np.int32)
    one = machine("tiles: {rows: 1, cols: 1}\ndma: {engines: 1}\n")
    job = Job(one)
    last: list[int] = []
    for part in np.split(x, 4):
        here = job.move_in(0, part, 0, after=last)
        run = job.run(0, code, x=At(0, (256,)), n=256, after=[here])
        last = [job.move_out(0, 0, part, after=[run])]
    result = job.simulate()
    launch = int(code.images_set.sum()) + len(code.launch)
    each = move_in(1024) + launch + tile_cycles(256) + move_out(1024)
    assert result.cycles == 4 * each
    assert result.stats["stalls"]["dma"] == 4 * move_in(1024) + 3 * move_out(1024)
    assert result.stats["stalls"]["scratchpad"] == 0
    assert (x == 2 * np.arange(1024)).all()
    accounted(result)


def pipelined(one: Accelerator, parts: int) -> JobResult:
    """Two halves: while the tile works on one, the other is emptied and filled."""
    code = program(double)
    x = np.arange(parts * WORDS, dtype=np.int32)
    job = Job(one)
    last: dict[int, list[int]] = {}
    for number, part in enumerate(np.split(x, parts)):
        half = part.nbytes * (number % 2)
        here = job.move_in(0, part, half, after=last.get(half, []))
        run = job.run(0, code, x=At(half, (WORDS,)), n=WORDS, after=[here])
        last[half] = [job.move_out(0, half, part, after=[run])]
    result = job.simulate()
    assert (x == 2 * np.arange(parts * WORDS)).all()
    accounted(result)
    return result


WORDS = 1024
BURSTS = 4 * WORDS // BURST


def test_a_compute_bound_job_hides_its_transfers() -> None:
    """The first slice is waited for, and then never one; bursts that arrive or leave during a run
    take its banks.
    """
    result = pipelined(machine("tiles: {rows: 1, cols: 1}\n"), 6)
    code = program(double)
    launch = int(code.images_set.sum()) + len(code.launch)
    first = move_in(4 * WORDS)  # the second slice's bursts wait behind it
    stolen = result.stats["stalls"]["scratchpad"]
    runs = 6 * (launch + tile_cycles(WORDS)) + stolen
    assert result.stats["stalls"]["dma"] == first
    assert result.cycles == first + runs + move_out(4 * WORDS)
    # All slices but the first arrive, and all but the last leave, during runs; the second's bursts
    # and those that pass while launch words are written take nothing.
    assert 0 < stolen <= 10 * BURSTS * CYCLES_A_BURST


def test_a_dma_bound_job_takes_as_long_as_its_transfers() -> None:
    """The channel is the bottleneck: it never rests between the first burst and the last."""
    slow = "tiles: {rows: 1, cols: 1}\ndram: {bytes_per_cycle: 1, latency: 0}\n"
    result = pipelined(machine(slow + "noc: {latency: 0}\ndma: {setup_cycles: 0}\n"), 6)
    moved = 2 * 6 * 4 * WORDS
    assert result.stats["busy"]["dram"] == moved
    # At most the first run has nothing to move beside it, and the last.
    assert moved <= result.cycles < moved + 2 * (tile_cycles(WORDS) + 100)
    assert result.stats["stalls"]["dma"] > result.stats["cycles_by_use"]["steady"]


def test_double_buffering_of_a_spread_loop_saves_cycles_and_changes_no_bit() -> None:
    from tests.e2e.test_prange import scale  # noqa: PLC0415

    code = program(scale)
    cycles = []
    one = machine("tiles: {rows: 1, cols: 1}\n")
    for double_buffer in (False, True):
        x, y = np.arange(8000, dtype=np.int32), np.zeros(8000, np.int32)
        options = SpreadOptions(chunk=1000, double_buffer=double_buffer)
        result = spread(code, (x, y), {}, one, options).simulate()
        assert (y == 3 * x).all()
        accounted(result)
        cycles.append(result.cycles)
    assert cycles[1] < cycles[0]


def test_bank_conflicts_known_by_hand() -> None:
    """Both loads are eight words apart, so in one bank: a cycle that has both costs one more."""
    from tests.e2e.test_prange import same_bank  # noqa: PLC0415

    code = vividc.compile(
        same_bank, fabric="vivid", time_limit_s=20, loops=vividc.LoopOptions(auto=False)
    )
    loop = next(row for row in code.table if row.kind == "loop" and row.ii == 1)
    issues = [e.issue for e in code.entries[loop.context] if e.issue is not None]
    stages = [issue.stage for issue in issues if issue.op.value == "load"]
    assert len(stages) == 2
    n = 100
    x, y = np.arange(1000, dtype=np.int32), np.zeros(n, np.int32)
    one = machine("tiles: {rows: 1, cols: 1}\n")
    result = spread(code, (x, y), {}, one, SpreadOptions(chunk=n)).simulate()
    # Word 8 i and word i: the store meets them where i is in their bank, unless it is alone.
    assert result.stats["stalls"]["bank"] >= n - abs(stages[0] - stages[1])
    accounted(result)
