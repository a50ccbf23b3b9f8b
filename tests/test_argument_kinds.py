"""Arguments of the wrong kind, to every public function: a message of ours that names them."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import vividc
from vividc.launch import At, Job

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


CALLS: dict[str, Callable[[vividc.Program, Any], object]] = {
    "compile kernel": lambda p, v: vividc.compile(v),
    "compile fabric": lambda p, v: vividc.compile(double, fabric=v),
    "compile mapper": lambda p, v: vividc.compile(double, mapper=v),
    "compile time_limit_s": lambda p, v: vividc.compile(double, time_limit_s=v),
    "compile progress": lambda p, v: vividc.compile(double, progress=v),
    "compile transform": lambda p, v: vividc.compile(double, transform=v),
    "compile unroll": lambda p, v: vividc.compile(double, unroll=v),
    "compile threads": lambda p, v: vividc.compile(double, threads=v),
    "compile precision": lambda p, v: vividc.compile(double, precision=v),
    "compile mode": lambda p, v: vividc.compile(double, mode=v),
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
    "job engine": lambda p, v: job(p).simulate(engine=v),
    "job cycle_limit": lambda p, v: job(p).simulate(cycle_limit=v),
    "job threads": lambda p, v: job(p).simulate(threads=v),
}


@pytest.mark.parametrize("name", CALLS)
def test_an_odd_value_works_or_is_refused_by_a_message(
    name: str, spread_program: vividc.Program, monkeypatch: Any, tmp_path: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(vividc.driver, "_compile_stages", lambda *_, **__: spread_program)
    refused: list[str] = []
    for value in ODD:
        try:
            CALLS[name](spread_program, value)
        except vividc.VividcError as error:
            refused.append(error.reason)
    assert refused
    assert not [text for text in refused if re.search(r"object is not|has no attribute", text)]
