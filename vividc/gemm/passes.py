"""An MLP on an accelerator in a TPU-like mode: which layers run together, on how many rows at once,
and the cost.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from vividc import arch
from vividc.arch import Accelerator, TileGroup
from vividc.errors import ArchError
from vividc.gemm.chain import Chain, Link
from vividc.gemm.modes import FABRICS, LayerShape, Mode, array_of, check_mode, check_sizes, padded
from vividc.gemm.systolic import STREAMS, Form, Precision, SystolicArray, SystolicError
from vividc.program import WORD_BYTES

_FEWEST_BLOCKS = 4
"""A chain is not made longer if fewer blocks of rows would fit: a launch fills the array once."""
_MOST_LINKS = 6
"""Layers of a chain: each takes entries of the constant stores."""
_PIECES = 4
"""Pieces of the rows on each array, if there are enough: transfers of one hide behind another."""


@dataclass(frozen=True)
class Pass:
    """Layers from number `first` on as one program, over all rows; of a layer whose weights do not
    fit, the blocks of columns `bands`.
    """

    first: int
    chain: Chain
    bands: range

    @property
    def stop(self) -> int:
        """The first layer after the pass."""
        return self.first + len(self.chain.links)


@dataclass(frozen=True)
class Layout:
    """How an MLP runs in a mode.

    Attributes
    ----------
    compute
        Cycles of the runs on the array with most of them.
    moved
        Cycles that DRAM's channel is busy, about.
    configured
        Cycles of the configuration stream.
    stalled
        Cycles that an array waits while transfers have its banks, if all of them pass during runs.
    """

    mode: Mode
    rows: int
    passes: tuple[Pass, ...]
    compute: int
    moved: int
    configured: int
    stalled: int

    @property
    def cycles(self) -> int:
        """Estimate for the whole job: with a scratchpad in parts, transfers hide behind runs, or
        runs behind transfers.
        """
        hides = self.passes[0].chain.parts > 1
        hidden = max(self.compute + self.stalled, self.moved)
        spent = hidden if hides else self.compute + self.moved
        return spent + self.configured

    @property
    def arrays(self) -> int:
        """Arrays side by side."""
        return FABRICS[self.mode][1]

    def pieces(self, chain: Chain) -> list[range]:
        """Blocks of rows of each launch of a pass, the arrays taking turns."""
        return _pieces(self.rows, chain, self.arrays)


def with_arrays(accelerator: Accelerator) -> Accelerator:
    """An accelerator of 4x4 ViViD tiles with the arrays of the TPU-like modes as further units:
    scratchpads may be of another size.

    Raises
    ------
    ArchError
        The accelerator is no other of this form.
    """
    if accelerator.groups:
        return accelerator
    tile = arch.load_tile("vivid-tile")
    if (accelerator.rows, accelerator.cols) != (4, 4) or not _is_like(accelerator, tile):
        raise ArchError(
            f"accelerator {accelerator.name} has no TPU-like modes: they join 4x4 tiles of "
            "vivid-tile",
            loc=accelerator.name,
            hint="choose the accelerator vivid, or a file that extends it",
        )
    size = accelerator.fabric.scratchpad.size_bytes
    whole, quarter = (array_of(mode, size).fabric for mode in ("tpu-unified", "tpu-partitioned"))
    groups = [TileGroup(whole, tuple(range(16)))]
    groups += [TileGroup(quarter, (t, t + 1, t + 4, t + 5)) for t in (0, 2, 8, 10)]
    return replace(accelerator, groups=tuple(groups))


def _is_like(accelerator: Accelerator, tile: arch.Fabric) -> bool:
    home = accelerator.fabric
    as_large = replace(tile.scratchpad, size_bytes=home.scratchpad.size_bytes)
    places = tuple(range(len(home.pes)))
    return arch.is_isomorphism(replace(tile, scratchpad=as_large), home, places)


def units(accelerator: Accelerator, mode: Mode) -> tuple[int, ...]:
    """The units of an accelerator that work in a mode."""
    name = FABRICS[mode][0]
    known = enumerate(accelerator.units)
    return tuple(number for number, fabric in known if fabric.name == name)


def lay_out(
    rows: int, shapes: Sequence[LayerShape], mode: Mode, accelerator: Accelerator
) -> Layout:
    """The better of two ways to run an MLP in a mode: with the scratchpad in one or two parts.

    Raises
    ------
    SystolicError
        A layer does not fit the array's memories, a size below 1, or an unknown mode.
    """
    check_sizes(rows, shapes)
    _, arrays = FABRICS[check_mode(mode)]
    array = array_of(mode, accelerator.fabric.scratchpad.size_bytes)
    layouts, refusal = [], None
    for parts in (2, 1):
        try:
            passes = _passes(array, shapes, parts)
        except SystolicError as error:
            refusal = error
            continue
        layouts.append(_costs(rows, shapes, mode, passes, arrays, accelerator))
    if not layouts:
        assert refusal is not None
        raise refusal
    return min(layouts, key=lambda layout: layout.cycles)


def results_of(shapes: Sequence[LayerShape]) -> list[Precision]:
    """The format in which the arrays store each layer's results: that of the next one's operands,
    of the last one that which is asked for, but float32 where something follows on the tiles.
    """
    behind: list[Precision] = [*(shape.precision for shape in shapes[1:]), shapes[-1].results]
    return ["f32" if s.ends else results for s, results in zip(shapes, behind, strict=True)]


def _passes(array: SystolicArray, shapes: Sequence[LayerShape], parts: int) -> tuple[Pass, ...]:
    ends = {k for k, shape in enumerate(shapes) if shape.ends}
    links = [
        Link(Form(s.words, s.relu, s.precision, results), padded(s.cols, array.cols) // array.cols)
        for s, results in zip(shapes, results_of(shapes), strict=True)
    ]
    passes: list[Pass] = []
    first = 0
    while first < len(links):
        stop = first + 1
        while stop < min(len(links), first + _MOST_LINKS) and stop - 1 not in ends:
            longer = Chain(array, tuple(links[first : stop + 1]), parts)
            if longer.blocks < _FEWEST_BLOCKS:
                break
            stop += 1
        chain = Chain(array, tuple(links[first:stop]), parts)
        if chain.blocks:
            passes.append(Pass(first, chain, range(links[first].bands)))
        else:
            passes += _by_columns(array, links[first], first, parts)
        first = stop
    return tuple(passes)


def _by_columns(array: SystolicArray, link: Link, first: int, parts: int) -> list[Pass]:
    """Passes over one layer whose weights do not fit, each with some blocks of columns."""
    most = next(
        (n for n in range(link.bands, 0, -1) if _one(array, link, n, parts).blocks),
        0,
    )
    if not most:
        chain = _one(array, link, 1, parts)
        size, depth = chain.words * WORD_BYTES, link.form.depth
        raise SystolicError(
            f"{array.rows} rows of {depth} columns and {array.cols} columns of the weights "
            f"do not fit the {size} bytes of scratchpad of fabric {array.fabric.name}",
            loc=array.fabric.name,
            hint="split the inner dimension and add the parts, or choose the mode tpu-unified",
        )
    starts = range(0, link.bands, most)
    return [
        Pass(first, _one(array, link, len(bands), parts), bands)
        for bands in (range(at, min(at + most, link.bands)) for at in starts)
    ]


def _one(array: SystolicArray, link: Link, bands: int, parts: int) -> Chain:
    return Chain(array, (replace(link, bands=bands),), parts)


def _pieces(rows: int, chain: Chain, arrays: int) -> list[range]:
    blocks = -(-rows // chain.array.rows)
    share = -(-blocks // arrays)
    count = max(-(-share // chain.blocks), min(_PIECES, -(-share // _FEWEST_BLOCKS)))
    size, longer = divmod(blocks, min(count * arrays, blocks))
    pieces, at = [], 0
    for number in range(min(count * arrays, blocks)):
        end = at + size + (number < longer)
        pieces.append(range(at, end))
        at = end
    return pieces


def _costs(
    rows: int,
    shapes: Sequence[LayerShape],
    mode: Mode,
    passes: tuple[Pass, ...],
    arrays: int,
    accelerator: Accelerator,
) -> Layout:
    compute = words = entries = 0
    for one in passes:
        chain = one.chain
        pieces = _pieces(rows, chain, arrays)
        busy = [0] * arrays
        for number, piece in enumerate(pieces):
            busy[number % arrays] += chain.cycles(len(piece))
        compute += max(busy)
        blocks = -(-rows // chain.array.rows) * chain.array.rows
        words += blocks * (chain.width(0) + chain.width(len(chain.links)))
        words += chain.parts * chain.weights[-1]
        entries += arrays * len(chain.array.fabric.pes) * chain.contexts
    moved = words * WORD_BYTES // accelerator.dram.bytes_per_cycle
    configured = entries // accelerator.configuration.entries_per_cycle
    line = WORD_BYTES * passes[0].chain.array.fabric.scratchpad.banks // STREAMS
    stalled = words * WORD_BYTES // (arrays * line)
    return Layout(mode, rows, passes, compute, moved, configured, stalled)
