"""MLPs as jobs of the accelerator: values, and what is counted."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.marks import with_slow
from vividc import arch
from vividc.errors import ArchError, ArgumentError
from vividc.gemm import Layer, LayerShape, gemm, mlp, mlp_job
from vividc.gemm.modes import MODES, Mode
from vividc.gemm.packed import packed
from vividc.gemm.passes import lay_out, units, with_arrays
from vividc.gemm.systolic import Precision, SystolicError
from vividc.launch import Job

RNG = np.random.default_rng(11)
VIVID = with_arrays(arch.load_accelerator("vivid"))

Matrix = NDArray[np.float32]


def random(*shape: int) -> Matrix:
    return RNG.standard_normal(shape).astype(np.float32)


def layers(*widths: int) -> list[Layer]:
    pairs = list(pairwise(widths))
    return [
        Layer(random(*pair), random(pair[1]), "relu" if k + 1 < len(pairs) else "none")
        for k, pair in enumerate(pairs)
    ]


def test_chained_layers_give_the_values_of_single_ones() -> None:
    made, x = layers(5, 9, 3), random(300, 5)
    run = mlp_job(x, made, mode="tpu-partitioned")
    assert np.array_equal(run.values, mlp(x, made, mode="tpu-partitioned").values)
    stats = run.job.stats
    assert stats["steps"]["configure"] == 1
    # The input and the weights come once, the results go once: hidden layers stay.
    words = 304 * (5 + 8) + 2 * (6 * 16 + 10 * 8) + 2 * 4 * 3 * len(_longest(300, made))
    assert stats["bytes"]["dram_wanted"] == 4 * words
    assert run.job.cycles == stats["cycles"]
    for tile in stats["tiles"]:
        spent = sum(tile["cycles"].values()) + sum(tile["stalls"].values())
        assert spent == run.job.cycles


@pytest.mark.parametrize("size", [16384, 65536])
@pytest.mark.parametrize("mode", MODES)
def test_arrays_join_scratchpads_of_any_size(tmp_path: Path, size: int, mode: Mode) -> None:
    (tmp_path / "tile.yaml").write_text(
        f"extends: vivid-tile\nname: other\nscratchpad: {{size_bytes: {size}}}\n"
    )
    text = "extends: vivid\nname: other\ntiles: {fabric: tile.yaml}\n"
    (tmp_path / "other.yaml").write_text(text)
    other = arch.load_accelerator(tmp_path / "other.yaml")
    first, last = layers(5, 300, 3)
    made = [first, replace(last, precision="f16", activation="sigmoid")]
    x = random(700, 5)
    run = mlp_job(x, made, mode=mode, accelerator=other)
    assert np.array_equal(run.values, mlp_job(x, made, mode=mode).values)
    (joined,) = {with_arrays(other).units[n].scratchpad.size_bytes for n in units(VIVID, mode)}
    assert joined == size * (16 if mode == "tpu-unified" else 4)


def _longest(rows: int, made: list[Layer]) -> range:
    layout = lay_out(rows, [layer.shape for layer in made], "tpu-partitioned", VIVID)
    return max(layout.pieces(layout.passes[0].chain), key=len)


def test_runs_take_the_cycles_of_the_closed_form() -> None:
    made, x = layers(4, 8, 2), random(900, 4)
    layout = lay_out(900, [layer.shape for layer in made], "tpu-partitioned", VIVID)
    run = mlp_job(x, made, mode="tpu-partitioned")
    (one,) = layout.passes
    assert run.job.stats["runs"] == len(layout.pieces(one.chain))
    cycles = sum(one.chain.cycles(len(piece)) for piece in layout.pieces(one.chain))
    assert run.job.stats["tile_cycles"] == cycles
    assert run.job.stats["stalls"]["bank"] == 0


def test_weights_that_do_not_fit_come_in_parts() -> None:
    x, one = random(30, 6), Layer(random(6, 1400), random(1400), "relu")
    layout = lay_out(30, [one.shape], "tpu-partitioned", VIVID)
    assert len(layout.passes) > 1
    assert [band for part in layout.passes for band in part.bands] == list(range(175))
    run = mlp_job(x, [one], mode="tpu-partitioned")
    columns = [slice(0, 700), slice(700, 1400)]
    halves = [Layer(one.weights[:, c], one.bias[c], "relu") for c in columns]
    for part, half in zip(columns, halves, strict=True):
        assert np.array_equal(run.values[:, part], mlp(x, [half], mode="tpu-partitioned").values)


def test_exp_runs_on_the_tiles_of_the_same_job() -> None:
    x, first, last = random(40, 3), Layer(random(3, 4), random(4), "exp"), Layer(random(4, 2))
    run = mlp_job(x, [first, last], mode="tpu-partitioned")
    hidden = np.exp((x.astype(np.float64) @ first.weights) + first.bias)
    np.testing.assert_allclose(run.values, hidden @ last.weights, rtol=1e-4, atol=1e-4)
    loads = [event for event in run.job.events if event.kind == "configure"]
    assert [event.program for event in loads] == ["gemm", "exp", "gemm"]
    # The shadow memories take a program while the one before runs; runs do not meet.
    runs = sorted((e.start, e.end, e.program) for e in run.job.events if e.kind == "run")
    ends = {name: max(end for _, end, n in runs if n == name) for name in ("exp",)}
    last_gemm = max(start for start, _, name in runs if name == "gemm")
    assert last_gemm >= ends["exp"]
    assert run.job.stats["stalls"]["configuration"] > 0


@pytest.mark.parametrize("precision", with_slow(["f16", "e4m3", "e5m2"], {"e5m2"}))
def test_results_leave_the_array_packed(precision: Precision) -> None:
    x = random(300, 5)
    made = [
        Layer(random(5, 19), random(19), "relu", precision),
        Layer(random(19, 9), random(9), "none", precision),
        Layer(random(9, 3), random(3), "none", precision),
    ]
    run = mlp_job(x, made, mode="tpu-partitioned")
    values = x
    for layer in made:
        relu = "relu" if layer.activation == "relu" else "none"
        values = gemm(
            values, layer.weights, layer.bias, activation=relu, precision=precision
        ).values
    assert np.array_equal(run.values, values)
    assert [event.program for event in run.job.events if event.kind == "configure"] == ["gemm"]
    (one,) = lay_out(300, [layer.shape for layer in made], "tpu-partitioned", VIVID).passes
    longest = _longest(300, made)
    words = 304 * (one.chain.width(0) + 8) + 2 * one.chain.weights[-1]
    words += 2 * 4 * 6 * len(longest)
    assert run.job.stats["bytes"]["dram_wanted"] == 4 * words
    pieces = lay_out(300, [layer.shape for layer in made], "tpu-partitioned", VIVID).pieces(
        one.chain
    )
    assert run.job.stats["tile_cycles"] == sum(one.chain.cycles(len(piece)) for piece in pieces)
    assert run.job.stats["stalls"]["bank"] == 0


@pytest.mark.parametrize("inputs", with_slow([40, 152], {152}))
def test_the_last_results_leave_as_words(inputs: int) -> None:
    """PEs that multiply compare, or drains load places."""
    x = random(100, inputs)
    made = [
        Layer(random(inputs, 32), random(32), "relu", "e4m3"),
        Layer(random(32, 19), random(19), "none", "e4m3", "f16"),
    ]
    plain = [made[0], replace(made[1], results="f32")]
    for mode in MODES:
        exact = packed(mlp_job(x, plain, mode=mode).values, "f16")
        run = mlp_job(x, made, mode=mode)
        assert run.values.tobytes() == exact.tobytes()
        assert run.job.stats["stalls"]["bank"] == 0
    with pytest.raises(ArgumentError, match="the results of layer 0 cannot be f16"):
        mlp_job(x, [replace(made[0], results="f16"), made[1]])
    with pytest.raises(ArgumentError, match="results of mlp are f32"):
        mlp(x, [replace(made[0], results="f16")])


def test_results_that_the_tiles_change_are_packed_there() -> None:
    x = random(100, 5)
    first = Layer(random(5, 7), random(7), "exp", "f16")
    last = Layer(random(7, 3), random(3), "none", "f16")
    run = mlp_job(x, [first, last], mode="tpu-partitioned")
    plain = gemm(x, first.weights, first.bias, precision="f16").values
    exact = gemm(np.exp(plain), last.weights, last.bias, precision="f16").values
    np.testing.assert_allclose(run.values, exact, rtol=1e-3, atol=0.02)
    loads = [event.program for event in run.job.events if event.kind == "configure"]
    assert loads == ["gemm", "exp", "pack_f16", "gemm"]


def test_forms_of_the_same_tiles_exclude_each_other() -> None:
    (whole,), quarters = units(VIVID, "tpu-unified"), units(VIVID, "tpu-partitioned")
    assert len(quarters) == 4
    assert VIVID.sharing[0] == {whole, quarters[0]}
    assert VIVID.sharing[whole] == {*range(16), *quarters}
    words, back = np.arange(8, dtype=np.float32), np.ones(8, np.float32)
    job = Job(VIVID)
    job.move_in(0, words, 0)
    job.move_in(whole, words, 64)
    job.move_out(0, 0, back)
    job.simulate()
    assert not back.any()  # what a tile's scratchpad held is lost when the array is joined


def test_words_apart() -> None:
    words, back = np.arange(6, dtype=np.float32), np.zeros((3, 2), np.float32)
    job = Job("vivid")
    moved = job.move_in(2, words, 4, pitch=16)
    job.move_out(2, 4 + 16, back[:2], after=[moved], pitch=16)
    job.simulate()
    assert back.tolist() == [[1, 2], [3, 4], [0, 0]]
    with pytest.raises(ArgumentError, match="the pitch is 6 bytes"):
        job.move_in(2, words, 4, pitch=6)
    with pytest.raises(ArgumentError, match="whole words"):
        job.move_in(2, np.zeros(8, np.uint8), 4, pitch=8)
    with pytest.raises(ArgumentError, match="32768"):
        job.move_in(2, words, 32768 - 64, pitch=16)


def test_mistakes_are_told() -> None:
    x = random(4, 5)
    with pytest.raises(ArgumentError, match="there are no layers"):
        mlp_job(x, [])
    with pytest.raises(SystolicError, match="unknown mode"):
        mlp_job(x, layers(5, 2), mode="tpu")
    with pytest.raises(ArchError, match="has no TPU-like modes"):
        mlp_job(x, layers(5, 2), accelerator="vivid-unit")
    with pytest.raises(ArgumentError, match="'exp' of layer 0 is one of jobs"):
        mlp(x, [Layer(random(5, 2), None, "exp")])
    for empty, none in ((random(0, 5), random(5, 2)), (x, random(5, 0))):
        with pytest.raises(SystolicError, match="nothing to compute"):
            mlp_job(empty, [Layer(none)])
    with pytest.raises(SystolicError, match="takes 601 contexts"):
        lay_out(10, [LayerShape(600, 3)], "tpu-unified", VIVID)
