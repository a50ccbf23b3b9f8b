"""A fabric with options that no configuration word has is refused by name, with a way out."""

from __future__ import annotations

import pytest

import vividc
from vividc.arch import load, load_text
from vividc.errors import ArchError
from vividc.program.encoder.programmable import demand_programmable


@vividc.kernel("void(float32[::1], int32)")
def double(x, n):
    for i in range(n):
        x[i] *= 2.0


def test_compile_refuses_with_the_options_named() -> None:
    with pytest.raises(ArchError) as caught:
        vividc.compile(double, fabric="openedge-4x4")
    text = str(caught.value)
    for option in (
        "hops: 0",
        "output: hold",
        "output_readers: neighbours",
        "moves: true",
        "by: fu",
    ):
        assert option in text
    assert "vividc map" in text


@pytest.mark.parametrize(
    ("yaml", "option"),
    [
        ("routing: {hops: 0}", "`routing.hops: 0`"),
        ("pe: {register_file: {rotating: true}}", "`register_file.rotating: true`"),
    ],
)
def test_each_option_is_named(yaml: str, option: str) -> None:
    fabric = load_text(f"extends: vivid-tile\n{yaml}\n")
    with pytest.raises(ArchError, match="programs cannot be made") as caught:
        demand_programmable(fabric)
    assert option in str(caught.value)


def test_defaults_said_aloud_are_accepted() -> None:
    text = "extends: vivid-tile\nrouting: {hops: 1, output: pulse, moves: false}\n"
    demand_programmable(load_text(text + "occupancy: {fmul: 1}\n"))
    demand_programmable(load("king-4x4"))


def test_several_links_a_cycle_and_busy_fus_are_accepted() -> None:
    demand_programmable(load("hycube-4x4"))
    demand_programmable(load_text("extends: vivid-tile\noccupancy: {fmul: 4}\n"))
