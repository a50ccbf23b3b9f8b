"""Configuration words: packing and unpacking are inverse, and illegal settings are refused."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vividc.arch import Fabric, load
from vividc.errors import BundleError, InternalError
from vividc.machine.opcodes import OPCODES, LatencyClass, Opcode
from vividc.program import (
    Capture,
    Entry,
    Issue,
    Operand,
    Sel,
    Select,
    Use,
    WordLayout,
    Write,
    decode,
    pack,
    unpack,
    word_layout,
)

EXECUTED = [
    op
    for op, info in OPCODES.items()
    if info.latency_class not in (LatencyClass.SOURCE, LatencyClass.SINK, LatencyClass.GENERIC)
]
FABRICS = ("vivid-tile", "mesh-1x1", "mesh-1x2", "torus-4x4", "hycube-3x3")


@cache
def fabric_of(name: str) -> Fabric:
    return load(name)


@st.composite
def operands(draw: st.DrawFn, layout: WordLayout, constants: int) -> Operand:
    select = draw(st.sampled_from(layout.operand_sources))
    if select.kind is Sel.CONST:
        select = Select(Sel.CONST, draw(st.integers(0, constants - 1)))
    return Operand(select, draw(st.none() | st.integers(0, constants - 1)))


@st.composite
def entries(draw: st.DrawFn, fabric: Fabric) -> Entry:
    layout = word_layout(fabric)
    pe = fabric.pes[0]
    constant = st.integers(0, pe.constants - 1)
    stage = st.integers(0, fabric.controller.max_stages - 1)
    register = st.integers(0, pe.registers - 1)
    operand = operands(layout, pe.constants)
    issue = st.builds(
        Issue,
        st.sampled_from(EXECUTED),
        st.tuples(operand, operand, operand),
        operand,
        constant,
        st.integers(0, 31),
        st.integers(-(1 << 15), (1 << 15) - 1),
        st.sampled_from((1, 2, 4)),
        st.booleans(),
        stage,
        st.sampled_from(Use),
        st.booleans(),
    )
    drive = st.sampled_from(layout.drive_sources)
    captures = st.sampled_from(layout.capture_sources[1:])
    return Entry(
        draw(st.none() | issue),
        tuple(draw(st.sampled_from(layout.link_sources)) for _ in range(layout.links)),
        tuple(draw(register) for _ in range(layout.reads)),
        tuple(draw(st.builds(Write, drive, register)) for _ in range(layout.writes)),
        draw(st.none() | st.builds(Capture, captures, constant, stage, st.booleans())),
    )


@settings(max_examples=150)
@given(st.data(), st.sampled_from(FABRICS))
def test_unpack_inverts_pack(data: st.DataObject, name: str) -> None:
    fabric = fabric_of(name)
    layout = word_layout(fabric)
    entry = data.draw(entries(fabric))
    words = pack(layout, entry)
    assert len(words) == layout.words_per_entry
    assert all(0 <= word < 1 << 32 for word in words)
    assert unpack(layout, words) == entry


@settings(max_examples=150)
@given(st.lists(st.integers(0, (1 << 32) - 1), min_size=5, max_size=5))
def test_any_words_decode_or_are_refused(words: list[int]) -> None:
    layout = word_layout(fabric_of("vivid-tile"))
    try:
        entry = unpack(layout, words)
    except BundleError:
        return
    assert unpack(layout, pack(layout, entry)) == entry


@pytest.mark.parametrize("name", FABRICS)
def test_fields_are_adjacent_and_named_once(name: str) -> None:
    layout = word_layout(fabric_of(name))
    end = 0
    for field in layout.fields:
        assert field.offset == end
        assert field.width > 0
        end += field.width
    assert end == layout.bits <= 32 * layout.words_per_entry
    assert len(layout.by_name) == len(layout.fields)


def test_word_of_the_default_tile_is_150_bits() -> None:
    layout = word_layout(fabric_of("vivid-tile"))
    assert (layout.bits, layout.words_per_entry) == (150, 5)
    assert layout.by_name["offset"].width == 16
    assert layout.links == 4


def idle(layout: WordLayout, **changes: object) -> Entry:
    links = (Select(Sel.NONE),) * layout.links
    parts = {"issue": None, "links": links, "reads": (0,) * layout.reads}
    parts |= {"writes": (Write(),) * layout.writes, "capture": None, **changes}
    return Entry(**parts)


def test_zero_is_idle() -> None:
    layout = word_layout(fabric_of("vivid-tile"))
    assert unpack(layout, [0] * layout.words_per_entry) == idle(layout)
    assert idle(layout).is_idle


@pytest.mark.parametrize("offset", [1 << 15, -(1 << 15) - 1])
def test_offset_beyond_16_bits_is_refused(offset: int) -> None:
    layout = word_layout(fabric_of("vivid-tile"))
    none = Operand()
    issue = Issue(Opcode.LOAD, (none, none, none), offset=offset)
    with pytest.raises(InternalError, match="offset"):
        pack(layout, idle(layout, issue=issue))


def test_entry_asking_for_a_missing_link_is_refused() -> None:
    fabric = fabric_of("vivid-tile")
    layout = word_layout(fabric)
    corner = idle(layout, links=(Select(Sel.LINK, 3), *(Select(Sel.NONE),) * 3))
    words = np.zeros((1, 16, layout.words_per_entry), np.uint32)
    words[0, 5] = pack(layout, corner)
    assert decode(fabric, words)[0][5] == corner
    words[0, 0] = words[0, 5]
    with pytest.raises(BundleError, match="incoming link 3, which PE 0"):
        decode(fabric, words)


def test_load_on_a_pe_without_memory_is_refused() -> None:
    fabric = fabric_of("vivid-tile")
    layout = word_layout(fabric)
    operand = Operand(Select(Sel.IV))
    load_word = idle(layout, issue=Issue(Opcode.LOAD, (operand, Operand(), Operand())))
    words = np.zeros((1, 16, layout.words_per_entry), np.uint32)
    words[0, 5] = pack(layout, load_word)
    with pytest.raises(BundleError, match="operation load, which PE 5"):
        decode(fabric, words)


def test_predicate_of_the_first_iteration_only_is_refused() -> None:
    fabric = fabric_of("vivid-tile")
    layout = word_layout(fabric)
    operand = Operand(Select(Sel.IV))
    issue = Issue(Opcode.MOV, (operand, Operand(), Operand()), predicate=Operand(first=1))
    words = np.zeros((1, 16, layout.words_per_entry), np.uint32)
    words[0, 5] = pack(layout, idle(layout, issue=issue))
    with pytest.raises(BundleError, match="a predicate in its first iteration only, which PE 5"):
        decode(fabric, words)
