"""Layers of an MLP as launches of systolic products on numpy arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from vividc import arch
from vividc.errors import ArgumentError, demand_type
from vividc.gemm.modes import FABRICS, LayerShape, Mode, choose, launches_of, padded, pieces
from vividc.gemm.packed import packed
from vividc.gemm.program import GemmProgram, Operands, gemm_program
from vividc.gemm.systolic import (
    STREAMS,
    Precision,
    Stream,
    SystolicArray,
    check_precision,
    read_blocks,
    write_blocks,
)
from vividc.sim import Launch
from vividc.sim.bind import bind
from vividc.sim.run import CYCLE_LIMIT
from vividc.sim.tile import AUTO, check_engine, shared_tile

Fused = Literal["none", "relu"]
Apart = Literal["exp", "sigmoid"]
Activation = Fused | Apart
FUSED: Final = get_args(Fused)
"""Activations on the way out of the array; the others are for jobs (`mlp_job`)."""
ACTIVATIONS: Final = (*FUSED, *get_args(Apart))
_LAYERS_HINT: Final = "give a list, as in [Layer(weights, bias)]"
Matrix = NDArray[np.float32]


@dataclass(frozen=True)
class Layer:
    """activation(x weights + bias).

    Attributes
    ----------
    weights
        float32 [inputs, outputs].
    bias
        float32 [outputs]; None: zeros.
    precision
        Format that inputs and weights are rounded to; sums and bias are float32.
    results
        Format of what `mlp_job` leaves of the last layer: of 16 or 8 bits, neighbours share a word.
    """

    weights: Matrix
    bias: Matrix | None = None
    activation: Activation = "none"
    precision: Precision = "f32"
    results: Precision = "f32"

    @property
    def shape(self) -> LayerShape:
        """Sizes of the layer."""
        depth, cols = self.weights.shape
        relu, ends = self.activation == "relu", self.apart is not None
        return LayerShape(depth, cols, relu, ends, self.precision, self.results)

    @property
    def apart(self) -> Apart | None:
        """The activation, if the tiles compute it in GPU-like mode."""
        if self.activation == "exp" or self.activation == "sigmoid":  # noqa: PLR1714 - narrows
            return self.activation
        return None


@dataclass(frozen=True)
class GemmResult:
    """What a product or an MLP gave.

    Attributes
    ----------
    values
        float32 [rows, outputs of the last layer].
    cycles
        Simulated cycles until the last array was done.
    mode
        Which arrays ran.
    utilization
        Multiplications asked for, per PE that multiplies and cycle.
    launches
        Launches of the array with most of them.
    """

    values: Matrix
    cycles: int
    mode: Mode
    utilization: float
    launches: int


def gemm(
    a: Matrix,
    b: Matrix,
    bias: Matrix | None = None,
    *,
    activation: Activation = "none",
    precision: Precision = "f32",
    mode: str = "auto",
    engine: str = AUTO,
) -> GemmResult:
    """activation(a b + bias) on the array, simulated.

    Every element is one chain of fused multiply-adds in float32 over the inner index, from the
    bias: it differs from the exact sum by at most n u / (1 - n u) times the sum of the terms'
    magnitudes, with n inner indices and u = 2**-24 (Higham 2002, section 3.1).

    Parameters
    ----------
    a, b, bias
        float32 [rows, depth], [depth, cols], [cols].
    precision
        "f32", or "f16", "e4m3", "e5m2": `a` and `b` are rounded to it, and several of their
        elements share a word. Products are exact and sums are float32, so that the bound holds for
        the rounded operands.
    mode
        "tpu-unified", "tpu-partitioned" or "auto", the one with fewer cycles.
    engine
        Engine of the simulator.

    Raises
    ------
    ArgumentError, SystolicError
        Wrong types or sizes, an unknown mode, or a product that does not fit the array.
    """
    return mlp(a, [Layer(b, bias, activation, precision)], mode=mode, engine=engine)


def mlp(
    x: Matrix, layers: Sequence[Layer], *, mode: str = "auto", engine: str = AUTO
) -> GemmResult:
    """All layers, one after the other, on pieces of rows that stay in the scratchpad: what one
    layer writes is what the next one reads, where it lies. Parameters and errors as of `gemm`.
    """
    check_layers(x, layers, FUSED)
    check_engine(engine)
    for number, layer in enumerate(layers[1:], 1):
        if layer.precision != "f32":
            raise ArgumentError(
                f"layer {number} takes {layer.precision}, and what the layer before writes is f32",
                hint="mlp_job packs it on the tiles",
            )
    if layers[-1].results != "f32":
        raise ArgumentError("results of mlp are f32", hint="mlp_job packs them")
    chosen = choose(x.shape[0], [layer.shape for layer in layers], mode).chosen
    name, arrays = FABRICS[chosen.mode]
    share = -(-x.shape[0] // arrays)
    runs = [
        _Run(name, layers, engine).all_rows(x[start : start + share])
        for start in range(0, x.shape[0], share)
    ]
    values = np.concatenate([run.values for run in runs])
    cycles = max(run.cycles for run in runs)
    array = SystolicArray.of(arch.load_tile(name))
    work = x.shape[0] * sum(layer.weights.size for layer in layers)
    utilization = work / (cycles * arrays * array.rows * array.cols)
    return GemmResult(values, cycles, chosen.mode, utilization, max(run.launches for run in runs))


@dataclass(frozen=True)
class _Partial:
    values: Matrix
    cycles: int
    launches: int


class _Run:
    """One array with its layers' programs."""

    def __init__(self, fabric: str, layers: Sequence[Layer], engine: str) -> None:
        self._array = SystolicArray.of(arch.load_tile(fabric))
        self._layers = layers
        self._engine = engine
        self._cycles = 0
        self._launches = 0
        self._programs = [
            gemm_program(
                fabric, layer.shape.words, relu=layer.shape.relu, precision=layer.precision
            )
            for layer in layers
        ]

    def all_rows(self, x: Matrix) -> _Partial:
        """Every piece of the rows through all layers."""
        shapes = [layer.shape for layer in self._layers]
        values, start = [], 0
        for blocks in pieces(x.shape[0], shapes, self._array):
            end = start + blocks * self._array.rows
            values.append(self._piece(x[start:end], blocks))
            start = end
        return _Partial(np.concatenate(values), self._cycles, self._launches)

    def _piece(self, x: Matrix, blocks: int) -> Matrix:
        """Rows that fit the scratchpad: only `x`, weights and the last layer's results move."""
        x = packed(x, self._layers[0].precision)
        rows, width = self._array.rows, x.shape[1]
        buffer = np.zeros((self._programs[0].layout.room, STREAMS), np.float32)
        whole = np.zeros((blocks * rows, width), np.float32)
        whole[: x.shape[0]] = x
        source, target = Stream.A, Stream.C
        write_blocks(buffer[:, source], whole, rows)
        for program, layer in zip(self._programs, self._layers, strict=True):
            c_width = padded(layer.shape.cols, self._array.cols)
            for bands in launches_of(layer.shape, program.layout, blocks):
                given = Operands(source, target, width, c_width, blocks, bands)
                self._launch(program, layer, buffer, given)
            source, target, width = target, source, c_width
        results = read_blocks(buffer[:, source], blocks, width, rows)
        return results[: x.shape[0], : self._layers[-1].shape.cols]

    def _launch(self, program: GemmProgram, layer: Layer, buffer: Matrix, given: Operands) -> None:
        bands = bands_of(layer, self._array.cols)[given.bands.start : given.bands.stop]
        buffer[: bands.size, Stream.B] = bands.ravel()
        arguments = program.launch(buffer, given)
        bound = bind(program.program, arguments, {})
        launch = Launch(bound.memory, bound.inputs, CYCLE_LIMIT, bound.extents)
        run = shared_tile(program.program, self._engine).run(launch)
        bound.copy_back(run.memory, program.program.stored_arrays)
        self._cycles += run.cycles
        self._launches += 1


def bands_of(layer: Layer, cols: int) -> Matrix:
    """Weights and bias by blocks of columns, the last one filled with zeros: float32 [bands, words
    of the depth + 1, cols].
    """
    outputs, depth = layer.weights.shape[1], layer.shape.words
    whole = np.zeros((depth + 1, padded(outputs, cols)), np.float32)
    whole[:depth, :outputs] = packed(layer.weights.T, layer.precision).T
    if layer.bias is not None:
        whole[depth, :outputs] = layer.bias
    return whole.reshape(depth + 1, -1, cols).transpose(1, 0, 2)


def check_layers(
    x: Matrix,
    layers: Sequence[Layer],
    activations: Sequence[str] = ACTIVATIONS,
    *,
    words: bool = False,
) -> None:
    """Refuse what is no MLP on float32 arrays; with `words`, `x` holds words of the first layer's
    format.

    Raises
    ------
    ArgumentError
        Wrong types or sizes, or an activation that is not among `activations`.
    """
    demand_type(layers, Sequence, "the layers", _LAYERS_HINT)
    if not layers:
        raise ArgumentError("there are no layers", hint="give one or more")
    for layer in layers:
        demand_type(layer, Layer, "a layer", _LAYERS_HINT)
    _check_array("the input", x, 2)
    columns = _features(x, layers[0]) if words else x.shape[1]
    for number, layer in enumerate(layers):
        name = f"layer {number}"
        check_precision(layer.precision)
        packs = check_precision(layer.results) != "f32"
        if packs and (layer.apart is not None or layer is not layers[-1]):
            raise ArgumentError(
                f"the results of {name} cannot be {layer.results}",
                hint="those of a last layer can, with none or relu behind it",
            )
        _check_array(f"the weights of {name}", layer.weights, 2)
        if layer.weights.shape[0] != columns:
            raise ArgumentError(
                f"the weights of {name} have {layer.weights.shape[0]} rows, and its input has "
                f"{columns} columns",
                hint="an input [rows, depth] takes weights [depth, columns]",
            )
        columns = layer.weights.shape[1]
        demand_type(layer.activation, str, f"the activation of {name}", ", ".join(activations))
        if layer.activation not in activations:
            known = ", ".join(activations)
            reason = f"unknown activation {layer.activation!r} of {name}"
            if layer.activation in ACTIVATIONS:
                reason = f"activation {layer.activation!r} of {name} is one of jobs"
                known += f"; mlp_job(x, [Layer(weights, activation={layer.activation!r})]) takes it"
            raise ArgumentError(reason, hint=f"activations: {known}")
        if layer.bias is not None:
            _check_array(f"the bias of {name}", layer.bias, 1)
            if layer.bias.shape[0] != columns:
                reason = f"the bias of {name} has {layer.bias.shape[0]} elements, not {columns}"
                raise ArgumentError(reason, hint="one for each column of the weights")


def _features(words: Matrix, first: Layer) -> int:
    """How many numbers the first layer takes of a row of words."""
    check_precision(first.precision)
    _check_array("the weights of layer 0", first.weights, 2)
    if words.shape[1] != first.shape.words:
        raise ArgumentError(
            f"the input has {words.shape[1]} words a row, and {first.weights.shape[0]} numbers of "
            f"{first.precision} take {first.shape.words}",
            hint="pack it as `vividc.gemm.packed` does",
        )
    depth: int = first.weights.shape[0]
    return depth


def _check_array(what: str, array: object, ndim: int) -> None:
    wanted = f"a numpy array of float32 with {_dimensions(ndim)}"
    if not isinstance(array, np.ndarray):
        hint = f"give {wanted}: np.array(x, np.float32)"
        raise ArgumentError(f"{what} is a {type(array).__name__}", hint=hint)
    if array.dtype != np.float32 or array.ndim != ndim:
        text = f"{what} is an array of {array.dtype} with {_dimensions(array.ndim)}"
        ways = [".astype(np.float32)"] * (array.dtype != np.float32)
        if array.ndim < ndim:
            ways.append(".reshape(1, -1) for one row")
        elif array.ndim > ndim:
            ways.append(".reshape(-1)" if ndim == 1 else ".reshape(-1, x.shape[-1])")
        raise ArgumentError(text, hint=f"give {wanted}: x{''.join(ways)}")


def _dimensions(count: int) -> str:
    return f"{count} dimension{'s' * (count != 1)}"
