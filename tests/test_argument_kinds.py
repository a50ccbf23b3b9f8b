"""Arguments of the wrong kind, to every public function: a message of ours that names them."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

import vividc
from tests.fuzz.file_scenes import SCENES
from tests.mapper.graphs import accumulator
from vividc import mapper, render
from vividc.gemm import Layer, choose, gemm, mlp, mlp_job, predict
from vividc.launch import At, Job, Listed
from vividc.render.array import render_array

ODD = (None, 5, -1, 0.5, "5", b"5", [], [1], {}, object(), 10**30, np.float32(1), np.zeros(2))
"""Values of which most arguments are none."""


@vividc.kernel("void(float32[::1])")
def double(x):
    for i in range(len(x)):
        x[i] *= np.float32(2)


@pytest.fixture(scope="module")
def spread_program() -> vividc.Program:
    return vividc.compile(double, fabric="vivid")


def numbers() -> np.ndarray:
    return np.arange(8, dtype=np.float32)


def job(program: vividc.Program) -> Job:
    made = Job("vivid")
    made.configure((0,), program)
    return made


MATRIX = np.ones((4, 4), np.float32)
LAYERS = [Layer(MATRIX)]
SHAPES = [layer.shape for layer in LAYERS]
PICTURE = np.zeros((12, 12, 3), np.float32)


@cache
def graph() -> tuple[vividc.dfg.DFG, vividc.arch.Fabric, mapper.MapResult]:
    dfg, fabric = accumulator(), vividc.arch.load_tile("mesh-2x2")
    return dfg, fabric, mapper.map_dfg(dfg, fabric)


@cache
def scene() -> tuple[render.Scene, render.Camera]:
    with tempfile.TemporaryDirectory() as folder:
        np.savez(f"{folder}/s.npz", **SCENES["means"]())
        found = render.read_scene(f"{folder}/s.npz")[1]
    return found, render.orbit_camera(found, 30.0, 20.0, "+z", 8, 8)


def seen(width: object = 8, focal: object = 9.0, pose: object = None) -> render.Camera:
    return render.Camera(scene()[1].c2w if pose is None else pose, focal, width, 8)


CALLS: dict[str, Callable[[vividc.Program, Any], object]] = {
    "compile kernel": lambda p, v: vividc.compile(v),
    "compile fabric": lambda p, v: vividc.compile(double, fabric=v),
    "compile mapper": lambda p, v: vividc.compile(double, mapper=v),
    "compile time_limit_s": lambda p, v: vividc.compile(double, time_limit_s=v),
    "compile effort": lambda p, v: vividc.compile(double, effort=v),
    "compile progress": lambda p, v: vividc.compile(double, progress=v),
    "compile transform": lambda p, v: vividc.compile(double, transform=v),
    "compile unroll": lambda p, v: vividc.compile(double, loops=vividc.LoopOptions(unroll=v)),
    "compile threads": lambda p, v: vividc.compile(double, loops=vividc.LoopOptions(threads=v)),
    "compile precision": lambda p, v: vividc.compile(double, precision=v),
    "compile mode": lambda p, v: vividc.compile(double, mode=v),
    "compile like": lambda p, v: vividc.compile(double, like=v),
    "compile like, a shape": lambda p, v: vividc.compile(double, like={"x": v}),
    "compile like, each": lambda p, v: vividc.compile(double, like=(v,) * len(double.params)),
    "simulate program": lambda p, v: vividc.simulate(v, numbers()),
    "simulate argument": vividc.simulate,
    "simulate fabric": lambda p, v: vividc.simulate(p, numbers(), fabric=v),
    "simulate engine": lambda p, v: vividc.simulate(p, numbers(), engine=v),
    "simulate cycle_limit": lambda p, v: vividc.simulate(p, numbers(), cycle_limit=v),
    "simulate progress": lambda p, v: vividc.simulate(p, numbers(), progress=v),
    "simulate observer": lambda p, v: vividc.simulate(p, numbers(), observer=v),
    "kernel": lambda p, v: vividc.kernel(v),
    "load": lambda p, v: vividc.load(v),
    "patient": lambda p, v: vividc.patient(v).__enter__(),
    "save": lambda p, v: p.save(v),
    "arch.load": lambda p, v: vividc.arch.load(v),
    "dfg.load": lambda p, v: vividc.dfg.load(v),
    "map_dfg dfg": lambda p, v: vividc.mapper.map_dfg(v, p.fabric),
    "Job": lambda p, v: Job(v),
    "configure tiles": lambda p, v: job(p).configure(v, p),
    "configure program": lambda p, v: job(p).configure(0, v),
    "configure after": lambda p, v: job(p).configure(0, p, after=v),
    "run tile": lambda p, v: job(p).run(v, p, x=At(0, (8,))),
    "run program": lambda p, v: job(p).run(0, v, x=At(0, (8,))),
    "run argument": lambda p, v: job(p).run(0, p, x=v),
    "At address": lambda p, v: job(p).run(0, p, x=At(v, (8,))),
    "At shape": lambda p, v: job(p).run(0, p, x=At(0, v)),
    "move_in tiles": lambda p, v: job(p).move_in(v, numbers(), 0),
    "move_in source": lambda p, v: job(p).move_in(0, v, 0),
    "move_in address": lambda p, v: job(p).move_in(0, numbers(), v),
    "move_in pitch": lambda p, v: job(p).move_in(0, numbers(), 0, pitch=v),
    "move_out address": lambda p, v: job(p).move_out(0, v, numbers()),
    "move_out target": lambda p, v: job(p).move_out(0, 0, v),
    "gather source": lambda p, v: job(p).gather(0, v, np.zeros(2, np.int32), 0),
    "gather indices": lambda p, v: job(p).gather(0, numbers(), v, 0),
    "gather list": lambda p, v: job(p).gather(0, numbers(), Listed(v, 1), 0),
    "scatter tile": lambda p, v: job(p).scatter(v, 0, numbers(), np.zeros(2, np.int32)),
    "scatter address": lambda p, v: job(p).scatter(0, v, numbers(), np.zeros(2, np.int32)),
    "scatter target": lambda p, v: job(p).scatter(0, 0, v, np.zeros(2, np.int32)),
    "scatter indices": lambda p, v: job(p).scatter(0, 0, numbers(), v),
    "scatter list": lambda p, v: job(p).scatter(0, 0, numbers(), Listed(0, v)),
    "verify dfg": lambda p, v: mapper.verify(v, *graph()[1:]),
    "verify fabric": lambda p, v: mapper.verify(graph()[0], v, graph()[2].mapping),
    "verify mapping": lambda p, v: mapper.verify(*graph()[:2], v),
    "violations mapping": lambda p, v: mapper.violations(*graph()[:2], v),
    "check_certificate result": lambda p, v: mapper.check_certificate(v, graph()[2].subject),
    "check_certificate subject": lambda p, v: mapper.check_certificate(graph()[2], v),
    "mapping_from_json": lambda p, v: mapper.mapping_from_json(v, *graph()[:2]),
    "mapping_from_json dfg": lambda p, v: mapper.mapping_from_json({}, v, graph()[1]),
    "mapping_to_json": lambda p, v: mapper.mapping_to_json(v, *graph()[:2]),
    "read_result": lambda p, v: mapper.read_result(v),
    "map_dfg objective": lambda p, v: mapper.map_dfg(
        *graph()[:2], objective="5" if v is None else v
    ),
    "plot": lambda p, v: graph()[2].mapping.plot("5" if v is None else v),
    "gemm a": lambda p, v: gemm(v, MATRIX),
    "gemm b": lambda p, v: gemm(MATRIX, v),
    "gemm activation": lambda p, v: gemm(MATRIX, MATRIX, activation=v),
    "gemm precision": lambda p, v: gemm(MATRIX, MATRIX, precision=v),
    "gemm mode": lambda p, v: gemm(MATRIX, MATRIX, mode=v),
    "gemm engine": lambda p, v: gemm(MATRIX, MATRIX, engine=v),
    "mlp layers": lambda p, v: mlp(MATRIX, v),
    "mlp layer": lambda p, v: mlp(MATRIX, [v]),
    "mlp_job mode": lambda p, v: mlp_job(MATRIX, LAYERS, mode=v),
    "mlp_job accelerator": lambda p, v: mlp_job(MATRIX, LAYERS, accelerator=v),
    "mlp_job words": lambda p, v: mlp_job(MATRIX, LAYERS, words=v),
    "predict rows": lambda p, v: predict(v, SHAPES, "tpu-unified"),
    "predict layers": lambda p, v: predict(4, v, "tpu-unified"),
    "predict mode": lambda p, v: predict(4, SHAPES, v),
    "choose layers": lambda p, v: choose(4, v),
    "choose mode": lambda p, v: choose(4, SHAPES, v),
    "read_scene": lambda p, v: render.read_scene(v),
    "read_gaussians": lambda p, v: render.read_gaussians(v),
    "read_views": lambda p, v: render.read_views(v),
    "load_cameras": lambda p, v: render.load_cameras(v),
    "load_reference_images": lambda p, v: render.load_reference_images(v),
    "orbit_camera scene": lambda p, v: render.orbit_camera(v, 30.0, 20.0, "+z", 8, 8),
    "orbit_camera angle": lambda p, v: render.orbit_camera(scene()[0], v, 20.0, "+z", 8, 8),
    "orbit_camera up": lambda p, v: render.orbit_camera(scene()[0], 30.0, 20.0, v, 8, 8),
    "orbit_camera width": lambda p, v: render.orbit_camera(scene()[0], 30.0, 20.0, "+z", v, 8),
    "Camera pose": lambda p, v: seen(pose=v if v is not None else 5),
    "Camera focal": lambda p, v: seen(focal=v),
    "Camera width": lambda p, v: seen(width=v),
    "scaled_camera": lambda p, v: render.scaled_camera(v, 4, 4),
    "scaled_camera width": lambda p, v: render.scaled_camera(scene()[1], v, 4),
    "render_reference scene": lambda p, v: render.render_reference(v, scene()[1]),
    "render_reference camera": lambda p, v: render.render_reference(scene()[0], v),
    "render_reference options": lambda p, v: render.render_reference(*scene(), v),
    "render_reference progress": lambda p, v: render.render_reference(*scene(), progress=v),
    "render_array scene": lambda p, v: render_array(v, scene()[1]),
    "render_array camera": lambda p, v: render_array(scene()[0], v),
    "render_array options": lambda p, v: render_array(*scene(), 5 if v is None else v),
    "blend_on_array program": lambda p, v: render.blend_on_array(v, *scene()),
    "tile_lists scene": lambda p, v: render.tile_lists(v, scene()[1]),
    "tile_lists camera": lambda p, v: render.tile_lists(scene()[0], v),
    "psnr": lambda p, v: render.psnr(v, PICTURE),
    "ssim": lambda p, v: render.ssim(PICTURE, v),
    "write_png path": lambda p, v: render.write_png(v, PICTURE),
    "write_png image": lambda p, v: render.write_png("x.png", v),
    "to_uint8": lambda p, v: render.to_uint8(v),
    "upscale_nearest": lambda p, v: render.upscale_nearest(v, 2),
    "job engine": lambda p, v: job(p).simulate(engine=v),
    "job cycle_limit": lambda p, v: job(p).simulate(cycle_limit=v),
    "job threads": lambda p, v: job(p).simulate(threads=v),
}


@pytest.mark.parametrize("name", CALLS)
def test_an_odd_value_works_or_is_refused_by_a_message(
    name: str, spread_program: vividc.Program, monkeypatch: Any, tmp_path: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(vividc.compiler.driver, "compile_stages", lambda *_, **__: spread_program)
    refused: list[str] = []
    for value in ODD:
        try:
            CALLS[name](spread_program, value)
        except vividc.VividcError as error:
            refused.append(error.reason)
    assert refused
    assert not [text for text in refused if re.search(r"object is not|has no attribute", text)]
