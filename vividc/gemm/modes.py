"""TPU-like modes: the array as one systolic array or as four, and which of them is faster."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, get_args

from vividc import arch
from vividc.gemm.program import Shape
from vividc.mapper.systolic import SystolicArray, SystolicError

Mode = Literal["tpu-unified", "tpu-partitioned"]
MODES: Final[tuple[Mode, ...]] = get_args(Mode)

FABRICS: Final[dict[Mode, tuple[str, int]]] = {
    "tpu-unified": ("vivid-16x16", 1),
    "tpu-partitioned": ("vivid-8x8", 4),
}
"""Fabric of each mode, and how many of them work side by side, each on its share of the rows."""


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
        Launches of each array: one for each block of columns, and for as many rows as the
        scratchpad holds.
    """

    mode: Mode
    cycles: int
    utilization: float
    launches: int


@dataclass(frozen=True, slots=True)
class Choice:
    """The mode that a product runs in, and what the others would cost."""

    chosen: Prediction
    predictions: tuple[Prediction, ...]
    reason: str


@dataclass(frozen=True, slots=True)
class LayerShape:
    """Sizes of one layer: its inner dimension, its outputs, and whether max(x, 0) follows."""

    depth: int
    cols: int
    relu: bool = False


def layer_shapes(array: SystolicArray, layers: Sequence[LayerShape]) -> tuple[Shape, ...]:
    """The products of a chain of layers: each reads what the one before it wrote.

    Raises
    ------
    SystolicError
        A size below 1, or a layer that does not fit the array's memories.
    """
    shapes = []
    a_width = layers[0].depth
    for layer in layers:
        c_width = padded(layer.cols, array.cols)
        widths = (a_width, c_width)
        shapes.append(Shape.of(array, layer.depth, widths, relu=layer.relu))
        a_width = c_width
    return tuple(shapes)


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
    _check_sizes(rows, layers)
    name, arrays = FABRICS[check_mode(mode)]
    array = SystolicArray.of(arch.load(name))
    shapes = layer_shapes(array, layers)
    counts = launches_of(-(-rows // arrays), array.rows, min(s.layout.blocks for s in shapes))
    cycles = launches = 0
    for layer, shape in zip(layers, shapes, strict=True):
        bands = -(-layer.cols // array.cols)
        cycles += bands * sum(map(shape.cycles, counts))
        launches += bands * len(counts)
    work = rows * sum(layer.depth * layer.cols for layer in layers)
    pes = arrays * array.rows * array.cols
    return Prediction(mode, cycles, work / (cycles * pes), launches)


def launches_of(rows: int, block_rows: int, most: int) -> tuple[int, ...]:
    """Blocks of each launch for `rows` rows, at most `most` at once."""
    blocks = -(-rows // block_rows)
    full, rest = divmod(blocks, most)
    return (most,) * full + ((rest,) if rest else ())


def choose(rows: int, layers: Sequence[LayerShape], mode: str = "auto") -> Choice:
    """The mode with the fewest cycles, or the one that is asked for.

    Raises
    ------
    SystolicError
        An unknown mode, a size below 1, or a layer that fits no array.
    """
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
    for known in MODES:
        if mode == known:
            return known
    raise SystolicError(f"unknown mode {mode!r}", hint=f"modes: {', '.join(MODES)}, auto")


def _check_sizes(rows: int, layers: Sequence[LayerShape]) -> None:
    sizes = [rows, *(size for layer in layers for size in (layer.depth, layer.cols))]
    if not layers or min(sizes) < 1:
        raise SystolicError(f"nothing to compute: the sizes are {sizes}", hint="give 1 or more")
