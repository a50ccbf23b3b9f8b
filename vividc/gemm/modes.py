"""TPU-like modes: the array as one systolic array or as four, and which of them is faster."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final, Literal, get_args

from vividc import arch
from vividc.arch import Fabric
from vividc.errors import demand_type, quoted
from vividc.gemm.program import Shape
from vividc.gemm.systolic import BlockLayout, Form, Precision, SystolicArray, SystolicError, lanes

Mode = Literal["tpu-unified", "tpu-partitioned"]
MODES: Final[tuple[Mode, ...]] = get_args(Mode)

FABRICS: Final[dict[Mode, tuple[str, int]]] = {
    "tpu-unified": ("vivid-16x16", 1),
    "tpu-partitioned": ("vivid-8x8", 4),
}
"""Fabric of each mode, and how many of them work side by side, each on its share of the rows."""

_TILES: Final = 16
"""Of an accelerator, which the arrays of a mode share."""


@dataclass(frozen=True, slots=True)
class Prediction:
    """What a product costs in a mode.

    Attributes
    ----------
    cycles
        Cycles until the last array is done: exact.
    utilization
        Multiplications that are asked for, per PE that multiplies and cycle.
    launches
        Launches of each array: one for each layer and for as many rows as the scratchpad holds.
    """

    mode: Mode
    cycles: int
    utilization: float
    launches: int


_LARGEST: Final = (1 << 31) - 1
_SHAPES_HINT: Final = "give a list, as in [LayerShape(64, 32)]"
_MODES_HINT: Final = f"modes: {', '.join(get_args(Mode))}, auto"


@dataclass(frozen=True, slots=True)
class Choice:
    """The mode that a product runs in, and what the others would cost."""

    chosen: Prediction
    predictions: tuple[Prediction, ...]
    reason: str


@dataclass(frozen=True, slots=True)
class LayerShape:
    """Sizes of one layer: its inner dimension, its outputs, and whether max(x, 0) follows; whether
    something follows that the array cannot do, so that its results leave the scratchpad; the format
    of its operands, and that of the last layer's results.
    """

    depth: int
    cols: int
    relu: bool = False
    ends: bool = False
    precision: Precision = "f32"
    results: Precision = "f32"

    @property
    def words(self) -> int:
        """Words of a row of the input."""
        return -(-self.depth // lanes(self.precision))


@lru_cache
def array_of(mode: Mode, tile_bytes: int) -> SystolicArray:
    """Return an array of a mode: it joins the scratchpads of its tiles, of so many bytes each."""
    name, arrays = FABRICS[mode]
    return SystolicArray.of(sized(name, tile_bytes * _TILES // arrays))


@lru_cache
def sized(name: str, size_bytes: int) -> Fabric:
    """Return a shipped fabric, of the same name, with a scratchpad of another size."""
    text = f"extends: {name}\nname: {name}\nscratchpad: {{size_bytes: {size_bytes}}}\n"
    return arch.load_text(text, f"{name}.yaml")


def padded(columns: int, block: int) -> int:
    """`columns`, rounded up to whole blocks."""
    return -(-columns // block) * block


def predict(rows: int, layers: Sequence[LayerShape], mode: Mode) -> Prediction:
    """Cycles of an MLP on `rows` rows in a mode; a product is an MLP of one layer.

    Loading the configuration and moving operands between DRAM and scratchpads are not counted.

    Raises
    ------
    SystolicError
        A size below 1, or a layer that does not fit the array's memories.
    """
    check_sizes(rows, layers)
    name, arrays = FABRICS[check_mode(mode)]
    array = SystolicArray.of(arch.load_tile(name))
    cycles = launches = 0
    for blocks in pieces(-(-rows // arrays), layers, array):
        for layer in layers:
            shape = Shape.of(array, Form(layer.words, layer.relu, layer.precision))
            for bands in launches_of(layer, shape.layout, blocks):
                cycles += shape.cycles(blocks * len(bands))
                launches += 1
    work = rows * sum(layer.depth * layer.cols for layer in layers)
    pes = arrays * array.rows * array.cols
    return Prediction(mode, cycles, work / (cycles * pes), launches)


def pieces(rows: int, layers: Sequence[LayerShape], array: SystolicArray) -> tuple[int, ...]:
    """Blocks of rows of each piece that goes through all layers within the scratchpad.

    Raises
    ------
    SystolicError
        Not one block of rows fits, with the columns of the widest layer.
    """
    widest = max(layers[0].words, *(padded(layer.cols, array.cols) for layer in layers))
    layout = BlockLayout(array.rows, array.cols, 1, array.fabric.scratchpad.words)
    most = layout.blocks(widest)
    if not most:
        size = array.fabric.scratchpad.size_bytes
        raise SystolicError(
            f"{array.rows} rows of {widest} columns do not fit the {size} bytes of the scratchpad "
            f"of fabric {array.fabric.name}",
            loc=array.fabric.name,
            hint="split the matrix by columns",
        )
    most = min(most, layout.iterations)
    full, rest = divmod(-(-rows // array.rows), most)
    return (most,) * full + ((rest,) if rest else ())


def launches_of(layer: LayerShape, layout: BlockLayout, blocks: int) -> tuple[range, ...]:
    """Blocks of columns of each launch: as many as B's stream and the table of places hold."""
    bands = -(-layer.cols // layout.cols)
    most = min(layout.room // layout.band, layout.iterations // blocks)
    return tuple(range(at, min(at + most, bands)) for at in range(0, bands, most))


def choose(rows: int, layers: Sequence[LayerShape], mode: str = "auto") -> Choice:
    """The mode with the fewest cycles, or the one that is asked for.

    Raises
    ------
    SystolicError
        An unknown mode, a size below 1, or a layer that fits no array.
    """
    demand_type(mode, str, "the mode", _MODES_HINT)
    check_sizes(rows, layers)
    if mode != "auto":
        chosen = predict(rows, layers, check_mode(mode))
        return Choice(chosen, (chosen,), "asked for")
    predictions = tuple(predict(rows, layers, each) for each in MODES)
    chosen = min(predictions, key=lambda item: item.cycles)
    costs = ", ".join(
        f"{item.mode} {item.cycles} cycles ({item.utilization:.1%})" for item in predictions
    )
    return Choice(chosen, predictions, f"fewest cycles: {costs}")


def check_mode(mode: str) -> Mode:
    """`mode` as a mode.

    Raises
    ------
    SystolicError
        There is no such mode.
    """
    demand_type(mode, str, "the mode", _MODES_HINT)
    for known in MODES:
        if mode == known:
            return known
    raise SystolicError(f"unknown mode {mode!r}", hint=_MODES_HINT)


def check_sizes(rows: int, layers: Sequence[LayerShape]) -> None:
    """Refuse products without a row, a column or an inner index.

    Raises
    ------
    SystolicError
        A size is below 1, or there are no layers.
    """
    demand_type(rows, int, "the number of rows", "give an integer from 1 on")
    demand_type(layers, Sequence, "the layers", _SHAPES_HINT)
    for layer in layers:
        demand_type(layer, LayerShape, "a layer", _SHAPES_HINT)
    sizes = [rows, *(size for layer in layers for size in (layer.depth, layer.cols))]
    if max(sizes) > _LARGEST:
        raise SystolicError(f"a size of {quoted(max(sizes))}", hint=f"give at most {_LARGEST}")
    if not layers or min(sizes) < 1:
        raise SystolicError(f"nothing to compute: the sizes are {sizes}", hint="give 1 or more")
