"""Products and MLPs on systolic arrays against numpy, and their cycles against the prediction."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from vividc.errors import ArgumentError
from vividc.formats import FORMATS, round_array, to_floats
from vividc.gemm import Layer, LayerShape, choose, gemm, gemm_program, mlp, predict
from vividc.gemm.systolic import PRECISIONS, Precision, SystolicError

U = 2.0**-24
RNG = np.random.default_rng(7)

Matrix = NDArray[np.float32]


def random(*shape: int) -> Matrix:
    return RNG.standard_normal(shape).astype(np.float32)


def bound(a: Matrix, b: Matrix, bias: Matrix) -> NDArray[np.float64]:
    """The stated bound (Higham 2002): each element is a chain of FMAs."""
    n = a.shape[1]
    terms = np.abs(a.astype(np.float64)) @ np.abs(b) + np.abs(bias)
    return n * U / (1 - n * U) * terms


@pytest.mark.parametrize("mode", ["tpu-partitioned", "tpu-unified"])
@pytest.mark.parametrize(("rows", "depth", "cols"), [(50, 5, 11), (17, 12, 20)])
def test_a_product_is_numpys_within_the_bound(mode: str, rows: int, depth: int, cols: int) -> None:
    a, b, bias = random(rows, depth), random(depth, cols), random(cols)
    result = gemm(a, b, bias, activation="relu", mode=mode)
    exact = np.maximum(a.astype(np.float64) @ b + bias, 0)
    assert np.all(np.abs(result.values - exact) <= bound(a, b, bias))
    shape = LayerShape(depth, cols, relu=True)
    predicted = predict(rows, [shape], result.mode)
    assert (result.cycles, result.launches) == (predicted.cycles, predicted.launches)
    assert result.utilization == pytest.approx(predicted.utilization)


@pytest.mark.parametrize(("precision", "words"), [("f16", 35), ("e4m3", 18), ("e5m2", 18)])
def test_narrow_operands_share_words(precision: Precision, words: int) -> None:
    a, b, bias = random(40, 69), random(69, 9), random(9)
    result = gemm(a, b, bias, precision=precision, mode="tpu-partitioned")
    fmt = FORMATS[precision]
    one, other = (to_floats(fmt, round_array(fmt, matrix)) for matrix in (a, b))
    chain = np.tile(bias, (40, 1))
    for k in range(69):  # products are exact in float64, and so is each sum but for its rounding
        chain = (chain + one[:, k : k + 1].astype(np.float64) * other[k]).astype(np.float32)
    assert np.array_equal(result.values, chain)
    assert np.all(
        np.abs(chain - (one.astype(np.float64) @ other + bias)) <= bound(one, other, bias)
    )
    shape = LayerShape(69, 9, precision=precision)
    assert shape.words == words
    assert result.cycles == predict(40, [shape], result.mode).cycles


def test_narrow_operands_take_fewer_cycles() -> None:
    cycles = [
        predict(4096, [LayerShape(256, 64, precision=precision)], "tpu-unified").cycles
        for precision in PRECISIONS
    ]
    assert cycles[0] / cycles[1] > 1.9
    assert cycles[0] / cycles[2] > 3.6
    assert cycles[2] == cycles[3]


def test_integers_are_exact() -> None:
    a = RNG.integers(-9, 9, (20, 7)).astype(np.float32)
    b = RNG.integers(-9, 9, (7, 9)).astype(np.float32)
    assert np.array_equal(gemm(a, b, mode="tpu-partitioned").values, a @ b)


def test_layers_are_chained_in_the_scratchpad() -> None:
    layers = [
        Layer(random(9, 13), random(13), "relu"),
        Layer(random(13, 20), None, "relu"),
        Layer(random(20, 3), random(3)),
    ]
    x = random(40, 9)
    result = mlp(x, layers, mode="tpu-partitioned")
    one = x
    for layer in layers:
        one = gemm(one, layer.weights, layer.bias, activation=layer.activation).values
    assert np.array_equal(result.values, one)
    shapes = [layer.shape for layer in layers]
    assert result.cycles == predict(40, shapes, "tpu-partitioned").cycles
    assert result.launches == len(layers)


def test_pieces_of_the_rows_and_of_the_columns_give_the_same_values() -> None:
    a, b = random(300, 60), random(60, 140)
    result = gemm(a, b, mode="tpu-partitioned")
    predicted = predict(300, [LayerShape(60, 140)], "tpu-partitioned")
    assert predicted.launches == result.launches > 1
    assert result.cycles == predicted.cycles
    assert np.all(np.abs(result.values - a.astype(np.float64) @ b) <= bound(a, b, np.float32(0)))


def test_the_native_engine_agrees() -> None:
    a, b = random(30, 4), random(4, 8)
    one, other = (gemm(a, b, mode="tpu-partitioned", engine=e) for e in ("reference", "native"))
    assert np.array_equal(one.values, other.values)
    assert one.cycles == other.cycles


@pytest.mark.parametrize(
    ("depth", "cols", "fabric", "cycles"),
    [
        (32, 32, "tpu-unified", 31_743),
        (64, 3, "tpu-unified", 24_063),
        (128, 128, "tpu-unified", 323_583),
    ],
)
def test_no_more_cycles_than_scale_sim(depth: int, cols: int, fabric: str, cycles: int) -> None:
    assert choose(4096, [LayerShape(depth, cols)], fabric).chosen.cycles < cycles


def test_narrow_layers_are_faster_on_four_arrays() -> None:
    layers = [LayerShape(59, 32, relu=True), LayerShape(32, 3)]
    choice = choose(4096, layers)
    assert choice.chosen.mode == "tpu-partitioned"
    assert "tpu-unified" in choice.reason


def test_programs_say_what_is_proved() -> None:
    loop = gemm_program("vivid-8x8", 21).program.regions[1]
    assert (loop.ii, loop.status, loop.mapper) == (22, "optimal", "systolic")


def test_mistakes_are_told() -> None:
    a, b = random(4, 5), random(6, 7)
    with pytest.raises(ArgumentError, match="have 6 rows, and its input has 5 columns"):
        gemm(a, b)
    with pytest.raises(ArgumentError, match="the input is an array of float64"):
        gemm(a.astype(np.float64), b)  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match="bias of layer 0 has 3 elements, not 7"):
        gemm(random(4, 6), b, random(3))
    with pytest.raises(ArgumentError, match="unknown activation 'tanh'"):
        gemm(random(4, 6), b, activation="tanh")  # type: ignore[arg-type]
    with pytest.raises(SystolicError, match="unknown precision 'f8'"):
        gemm(random(4, 6), b, precision="f8")  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match="layer 1 takes e4m3, and what the layer before writes"):
        mlp(random(4, 6), [Layer(b), Layer(random(7, 2), precision="e4m3")])
    with pytest.raises(SystolicError, match="unknown mode 'tpu'"):
        gemm(random(4, 6), b, mode="tpu")
    with pytest.raises(SystolicError, match="takes 601 contexts"):
        gemm(random(4, 600), random(600, 3))
    with pytest.raises(SystolicError, match="nothing to compute"):
        gemm(random(0, 6), b)
