"""The table of matrix products on systolic arrays, beside public figures, and of colour MLPs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vividc import arch
from vividc.formats import FORMATS, round_array, to_floats
from vividc.gemm import FABRICS, Layer, LayerShape, Mode, mlp, mlp_job, predict
from vividc.gemm.program import Shape
from vividc.gemm.systolic import PRECISIONS, Form, Precision, SystolicArray

TITLE = "Matrix products on systolic arrays"
NOTES = (
    "Cycles are the exact closed form (`vividc.gemm.predict`), which equals simulation wherever "
    "both were run (the last table, and `tests/gemm`). `in pieces`: operands are brought to the "
    "scratchpad between launches, as the simulator runs them, each launch filling and draining the "
    "array once. `one launch`: a scratchpad that holds all operands, as SCALE-Sim's compute cycles "
    "assume. SCALE-Sim 3.0.0, output stationary, M = 4096: its cycles obey "
    "ceil(M/R) ceil(N/C) (2R + K - 2) - 1.",
    "",
    "Utilisation counts multiplications asked for, per multiplying PE and cycle; the load/store "
    "PEs at the edges (48 on vivid-16x16, 24 on vivid-8x8, corners aside) are not in it, as "
    "SCALE-Sim's feeders are not.",
)


@dataclass(frozen=True, slots=True)
class Network:
    """A colour network: its layers and where they come from."""

    name: str
    layers: tuple[LayerShape, ...]


COLOUR = (
    Network("KiloNeRF 59-32-3", (LayerShape(59, 32, True), LayerShape(32, 3))),
    Network(
        "Instant-NGP 32-64-64-3",
        (LayerShape(32, 64, True), LayerShape(64, 64, True), LayerShape(64, 3)),
    ),
    Network(
        "TensoRF 150-128-128-3",
        (LayerShape(150, 128, True), LayerShape(128, 128, True), LayerShape(128, 3)),
    ),
)
SHAPES = ((32, 32), (3, 64), (128, 128), (64, 64), (128, 150), (32, 63), (33, 32), (150, 3))
"""N and K of the products of the NeRFs' networks; the first three are SCALE-Sim's."""

MODE_OF: dict[str, Mode] = {"vivid-16x16": "tpu-unified", "vivid-8x8": "tpu-partitioned"}


def rows() -> Iterator[str]:
    """All tables, line by line."""
    yield from _products()
    yield from _networks()
    yield from _precisions()
    yield from _jobs()
    yield from _simulated()


def _products() -> Iterator[str]:
    yield "| N, K | M | array | in pieces | utilisation | one launch | utilisation | SCALE-Sim |"
    yield "|---|---|---|---|---|---|---|---|"
    for cols, depth in SHAPES:
        for fabric, mode in MODE_OF.items():
            for count in (4096, 65_536):
                yield _product(count, depth, cols, fabric, mode)
    yield ""


def _product(count: int, depth: int, cols: int, fabric: str, mode: Mode) -> str:
    array = SystolicArray.of(arch.load(fabric))
    arrays = FABRICS[mode][1]
    pieces = predict(count * arrays, [LayerShape(depth, cols)], mode).cycles
    folds = -(-count // array.rows) * -(-cols // array.cols)
    whole = Shape.of(array, Form(depth)).cycles(folds)
    ideal = count * depth * cols / (array.rows * array.cols)
    public = folds * (2 * array.rows + depth - 2) - 1
    return (
        f"| {cols}, {depth} | {count:,} | {array.rows}x{array.cols} | {pieces:,} "
        f"| {ideal / pieces:.1%} | {whole:,} | {ideal / whole:.1%} "
        f"| {public:,} ({ideal / public:.1%}) |"
    )


def _networks() -> Iterator[str]:
    yield "Colour networks, M = 65,536 (the paper's Figure 8(a): 54.2 % to 72.7 %, 1.34x):"
    yield ""
    yield "| network | unified | utilisation | partitioned | utilisation | speed-up |"
    yield "|---|---|---|---|---|---|"
    for network in COLOUR:
        one, four = (predict(65_536, network.layers, mode) for mode in FABRICS)
        yield (
            f"| {network.name} | {one.cycles:,} | {one.utilization:.1%} | {four.cycles:,} "
            f"| {four.utilization:.1%} | {one.cycles / four.cycles:.2f}x |"
        )
        one, four = (predict(65_536, network.layers[-1:], mode) for mode in FABRICS)
        yield (
            f"| {network.name}, last layer | {one.cycles:,} | {one.utilization:.1%} "
            f"| {four.cycles:,} | {four.utilization:.1%} | {one.cycles / four.cycles:.2f}x |"
        )
    yield ""


def _precisions() -> Iterator[str]:
    """One product with operands of each format, on random numbers."""
    yield "Formats of operands, unified array, M = 65,536 (2 and 4 inner indices to a word; cycles"
    yield "in pieces, and against FP32; K = 59 is 30 words of FP16 and 15 of FP8):"
    yield ""
    yield "| N, K | " + " | ".join(PRECISIONS) + " | error of f16 | of e4m3 | of e5m2 |"
    yield "|---|" + "---|" * (len(PRECISIONS) + 3)
    for cols, depth in ((32, 59), (64, 64), (128, 150), (128, 128)):
        cycles = [
            predict(65_536, [LayerShape(depth, cols, precision=each)], "tpu-unified").cycles
            for each in PRECISIONS
        ]
        shown = [f"{cycles[0]:,}", *(f"{n:,} ({cycles[0] / n:.2f}x)" for n in cycles[1:])]
        errors = [f"{_error(depth, cols, each):.1e}" for each in PRECISIONS[1:]]
        yield f"| {cols}, {depth} | " + " | ".join([*shown, *errors]) + " |"
    yield ""


def _error(depth: int, cols: int, precision: Precision) -> float:
    """Largest error over the largest result, operands of a normal distribution."""
    rng = np.random.default_rng(2)
    a, b = rng.standard_normal((64, depth)), rng.standard_normal((depth, cols))
    fmt = FORMATS[precision]
    one, other = (to_floats(fmt, round_array(fmt, x)).astype(np.float64) for x in (a, b))
    return float(np.abs(one @ other - a @ b).max() / np.abs(a @ b).max())


def _jobs() -> Iterator[str]:
    """Whole jobs: the simulator's count, on random operands."""
    yield "Whole jobs (`mlp_job`, M = 16,384): with configuration, launch words and transfers to"
    yield "and from DRAM (32 bytes a cycle); utilisation as above, of all cycles:"
    yield ""
    yield "| network | mode | runs | cycles | utilisation | configuration | DRAM busy |"
    yield "|---|---|---|---|---|---|---|"
    for network in COLOUR[:2]:
        rng = np.random.default_rng(3)
        layers = [_layer(shape, rng) for shape in network.layers]
        x = rng.uniform(-1, 1, (16_384, network.layers[0].depth)).astype(np.float32)
        for mode in FABRICS:
            run = mlp_job(x, layers, mode=mode)
            stats = run.job.stats
            waits = stats["stalls"]["configuration"] // len(stats["tiles"])
            yield (
                f"| {network.name} | {mode} | {stats['runs']} | {run.job.cycles:,} "
                f"| {run.utilization:.1%} | {waits:,} "
                f"| {stats['busy']['dram'] / run.job.cycles:.1%} |"
            )
    yield ""


def _simulated() -> Iterator[str]:
    yield "The closed form against simulation (random operands; error against numpy in float64):"
    yield ""
    yield "| network | M | mode | predicted | simulated | largest error |"
    yield "|---|---|---|---|---|---|"
    for network in COLOUR[:2]:
        for mode in FABRICS:
            yield _check(network, 96, mode)


def _check(network: Network, count: int, mode: Mode) -> str:
    rng = np.random.default_rng(1)
    layers = [_layer(shape, rng) for shape in network.layers]
    x = rng.uniform(-1, 1, (count, network.layers[0].depth)).astype(np.float32)
    result = mlp(x, layers, mode=mode)
    exact = x.astype(np.float64)
    for layer in layers:
        exact = exact @ layer.weights
        exact = np.maximum(exact, 0) if layer.activation == "relu" else exact
    predicted = predict(count, network.layers, mode).cycles
    error = np.abs(result.values - exact).max()
    return (
        f"| {network.name} | {count} | {mode} | {predicted:,} | {result.cycles:,} | {error:.1e} |"
    )


def _layer(shape: LayerShape, rng: np.random.Generator) -> Layer:
    weights = rng.normal(0, shape.depth**-0.5, (shape.depth, shape.cols)).astype(np.float32)
    return Layer(weights, None, "relu" if shape.relu else "none")
