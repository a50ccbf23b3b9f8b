"""An MLP as a job of the accelerator: configuration, transfers and runs in a TPU-like mode."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vividc import arch
from vividc.arch import Accelerator
from vividc.errors import demand_type
from vividc.gemm.chain import Chain, chain_program
from vividc.gemm.elementwise import elementwise_steps
from vividc.gemm.layer import Layer, Matrix, bands_of, check_layers
from vividc.gemm.modes import MODES, Mode, check_mode
from vividc.gemm.packed import packed
from vividc.gemm.packing import pack_steps
from vividc.gemm.passes import Layout, Pass, lay_out, units, with_arrays
from vividc.gemm.program import LINE
from vividc.gemm.systolic import BUFFER, GROUP_BYTES, Stream, SystolicArray, lanes
from vividc.launch import At, Job, JobResult
from vividc.launch.turns import Turns
from vividc.program import WORD_BYTES, Program
from vividc.sim.run import CYCLE_LIMIT
from vividc.sim.tile import AUTO

__all__ = ["MlpRun", "choose_layout", "mlp_job"]


@dataclass(frozen=True)
class MlpRun:
    """What an MLP gave as a job of the accelerator.

    Attributes
    ----------
    values
        float32 [rows, outputs of the last layer]; words, if these are packed.
    job
        The account: cycles with transfers and configuration, statistics, events.
    mode
        Which arrays ran.
    reason
        Why this mode.
    utilization
        Multiplications asked for, per PE that multiplies and cycle of the job.
    """

    values: Matrix
    job: JobResult
    mode: Mode
    reason: str
    utilization: float


def mlp_job(
    x: Matrix,
    layers: Sequence[Layer],
    *,
    mode: str = "auto",
    accelerator: str | Accelerator = "vivid",
    engine: str = AUTO,
    words: bool = False,
    cycle_limit: int = CYCLE_LIMIT,
) -> MlpRun:
    """All layers on an accelerator, one after the other, with everything a job counts.

    The input, the weights and the results are in DRAM, laid out by blocks as the arrays read them.
    Layers are chained in the scratchpads as far as weights and program fit; what does not passes
    through DRAM. Values are those of `mlp`, to the bit.

    Parameters
    ----------
    x
        float32 [rows, inputs of the first layer].
    mode
        "tpu-unified", "tpu-partitioned", or "auto", the one with fewer cycles by estimate.
    accelerator
        Its name, or an `Accelerator`: of 4x4 tiles as `vivid`.
    words
        The rows of `x` are words of the first layer's format, as `packed` makes them: bits.
    cycle_limit
        Cycles after which a run of an array is given up.

    Raises
    ------
    SimulationError
        A run took more than `cycle_limit` cycles.
    ArgumentError, SystolicError
        Wrong types or sizes, an unknown mode, or a layer that does not fit the arrays.
    ArchError
        The accelerator has no such modes.
    """
    demand_type(words, bool, "words", "give True or False")
    check_layers(x, layers, words=words)
    machine = accelerator
    if not isinstance(machine, arch.Accelerator):
        demand_type(machine, str, "the accelerator", "give its name, or what arch.load gave")
        machine = arch.load_accelerator(machine)
    machine = with_arrays(machine)
    layout, reason = choose_layout(x.shape[0], layers, mode, machine)
    job = Job(machine)
    values = add_mlp(job, x if words else packed(x, layers[0].precision), layers, layout)
    result = job.simulate(engine=engine, cycle_limit=cycle_limit)
    work = x.shape[0] * sum(layer.weights.size for layer in layers)
    array = layout.passes[0].chain.array
    pes = layout.arrays * array.rows * array.cols
    last = layers[-1].shape
    matrix = matrix_of(values, x.shape[0], -(-last.cols // lanes(last.results)))
    return MlpRun(matrix, result, layout.mode, reason, work / (result.cycles * pes))


def choose_layout(
    rows: int, layers: Sequence[Layer], mode: str, accelerator: Accelerator
) -> tuple[Layout, str]:
    """Choose how the layers run; return the layout and the reason.

    Raises
    ------
    SystolicError
        An unknown mode, or a layer that does not fit.
    """
    demand_type(mode, str, "the mode", f"modes: {', '.join(MODES)}, auto")
    shapes = [layer.shape for layer in layers]
    if mode != "auto":
        return lay_out(rows, shapes, check_mode(mode), accelerator), "asked for"
    layouts = [lay_out(rows, shapes, each, accelerator) for each in MODES]
    best = min(layouts, key=lambda layout: (layout.cycles, layout.compute))
    costs = ", ".join(f"{layout.mode} {layout.cycles} cycles" for layout in layouts)
    return best, f"fewest cycles by estimate: {costs}"


def add_mlp(job: Job, x: Matrix, layers: Sequence[Layer], layout: Layout) -> Matrix:
    """Add the steps of an MLP to a job; its results, once the job is simulated, by blocks: float32
    [blocks, columns, rows of a block].

    Parameters
    ----------
    x
        Words of the first layer's format, [rows, words].
    """
    source = blocks_of(x, layout.passes[0].chain.array)
    target = source
    before: tuple[int, ...] = ()
    done: tuple[int, ...] = ()
    for one in layout.passes:
        chain, last = one.chain, one.stop - 1
        if one.bands.start == 0:
            source = target
            before, done = done, ()
            precision = layers[one.first].precision
            if one.first and layers[one.first - 1].apart is not None and precision != "f32":
                source, before = pack_steps(job, source, chain.width(0), precision, before)
            bands = -(-layers[last].shape.cols // chain.array.cols)
            columns = bands * chain.band_width(len(chain.links) - 1)
            target = np.zeros((source.shape[0], columns, chain.array.rows), np.float32)
        first = one.bands.start * chain.band_width(len(chain.links) - 1)
        apart = layers[last].apart
        part = target[:, first : first + chain.width(len(chain.links))]
        steps = _Steps(job, one, layers, units(job.accelerator, layout.mode))
        # What the pass before left in the scratchpads has gone out before anything comes in.
        earlier = (*before, *done)
        done += steps.add(source[:, : chain.width(0)], part, layout.pieces(chain), earlier)
        whole = first + chain.width(len(chain.links)) == target.shape[1]
        if whole and apart is not None:
            done = elementwise_steps(job, target, apart, done)
    return target


class _Steps:
    """The steps of one pass."""

    def __init__(
        self, job: Job, one: Pass, layers: Sequence[Layer], units_: tuple[int, ...]
    ) -> None:
        self._job = job
        self._chain: Chain = one.chain
        self._units = units_
        self._program: Program = chain_program(one.chain)
        bands = [bands_of(layer, one.chain.array.cols) for layer in layers[one.first : one.stop]]
        if len(bands) == 1:
            bands = [bands[0][one.bands.start : one.bands.stop]]
        self._weights = np.concatenate([band.ravel() for band in bands])

    def add(
        self, source: Matrix, target: Matrix, pieces: list[range], before: tuple[int, ...]
    ) -> tuple[int, ...]:
        """Add all steps; return the numbers of the last ones.

        Parameters
        ----------
        source, target
            float32 [blocks, columns, rows of a block].
        pieces
            Blocks of each launch.
        before
            Steps that write `source`, and all of earlier passes.
        """
        job, chain = self._job, self._chain
        units_ = self._units[: len(pieces)]
        job.configure(units_, self._program)
        tables, starts = chain.tables(max(len(piece) for piece in pieces))
        parts = range(min(chain.parts, -(-len(pieces) // len(self._units))))
        ready = {part: self._fixed(part, units_, tables, before) for part in parts}
        turns, done = Turns(self._units, chain.parts), []
        for piece in pieces:
            unit, part, freed = turns.take()
            blocks = slice(piece.start, piece.stop)
            waits = [*ready[part], *before, *freed]
            first = self._address(part, Stream.A)
            moved = job.move_in(unit, source[blocks], first, after=waits, pitch=GROUP_BYTES)
            ran = self._run(unit, part, len(piece), starts, moved)
            where = self._address(part, chain.output)
            out = job.move_out(unit, where, target[blocks], after=[ran], pitch=GROUP_BYTES)
            turns.free(unit, part, out)
            done.append(out)
        return tuple(done)

    def _fixed(
        self, part: int, units_: tuple[int, ...], tables: np.ndarray, before: tuple[int, ...]
    ) -> tuple[int, ...]:
        """Weights and tables, which stay in a part."""
        place = self._address(part, Stream.B)
        weights = self._job.move_in(units_, self._weights, place, after=before, pitch=GROUP_BYTES)
        place = self._address(part, Stream.TABLE)
        return weights, self._job.move_in(units_, tables, place, after=[weights], pitch=GROUP_BYTES)

    def _address(self, part: int, stream: Stream) -> int:
        return (part * self._chain.words + stream) * WORD_BYTES

    def _run(self, unit: int, part: int, blocks: int, tables: tuple[int, ...], moved: int) -> int:
        chain = self._chain
        whole = At(part * chain.words * WORD_BYTES, (chain.words // LINE, LINE))
        arguments: dict[str, object] = {BUFFER: whole}
        arguments |= chain.scalars(part, blocks, tables)
        return self._job.run(unit, self._program, after=[moved], **arguments)


def blocks_of(x: Matrix, array: SystolicArray) -> Matrix:
    """A matrix by blocks of rows, the last one filled with zeros: float32 [blocks, columns, rows
    of a block].
    """
    blocks = -(-x.shape[0] // array.rows)
    whole = np.zeros((blocks * array.rows, x.shape[1]), np.float32)
    whole[: x.shape[0]] = x
    shaped = whole.reshape(blocks, array.rows, x.shape[1]).transpose(0, 2, 1)
    return np.ascontiguousarray(shaped)


def matrix_of(blocks: Matrix, rows: int, columns: int) -> Matrix:
    """The first rows and columns of a matrix that lies by blocks."""
    whole = blocks.transpose(0, 2, 1).reshape(-1, blocks.shape[1])
    return np.ascontiguousarray(whole[:rows, :columns])
