"""Variables between regions: what constant stores must keep room for, and how they are read."""

from __future__ import annotations

from typing import Final

from vividc import arch
from vividc.arch.fabric import Fabric
from vividc.compiler.regions.delivery import Delivery, deliver
from vividc.compiler.regions.stores import Stores
from vividc.dfg.forms.text import to_text
from vividc.dfg.forms.text_parser import parse
from vividc.dfg.regions import Region


def test_homes_take_room_before_they_are_written() -> None:
    held = {0: frozenset({("const", 7)}), 1: frozenset({("live_in", "%x")})}
    stores = Stores(arch.load_tile("vivid-tile"), held)
    both = stores.with_homes({"%x": frozenset({0, 1}), "%y": frozenset({1})})
    assert both.held == {
        0: {("const", 7), ("live_in", "%x")},
        1: {("live_in", "%x"), ("live_in", "%y")},
    }


def delivered(text: str, taken: int = 0, **homes: int) -> Delivery:
    """A region on `vivid-tile`; each variable has one home, where `taken` entries of the constant
    store are other regions'.
    """
    fabric = arch.load("vivid-tile")
    assert isinstance(fabric, Fabric)
    region = Region("straight", "straight", parse(text))
    places = {f"%{name}": frozenset({pe}) for name, pe in homes.items()}
    others = frozenset(("const", 100 + number) for number in range(taken))
    stores = Stores(fabric, {pe.id: others for pe in fabric.pes}).with_homes(places)
    return deliver(region, places, fabric, stores.held)


def movs(ready: Delivery) -> int:
    return to_text(ready.dfg).count("mov")


COUNTER: Final = """dfg "straight"
%0 = live_in "%i"
%1 = const 0x00000001
%2 = add %0, %1
%3 = live_out "%i" %2
"""


def test_the_only_reader_of_a_variable_lies_where_it_does() -> None:
    ready = delivered(COUNTER, i=5)
    assert to_text(ready.dfg).strip() == COUNTER.strip()
    assert ready.allowed == {2: {5}, 3: {5}}


def test_a_constant_that_has_no_room_there_does_not_lie_there() -> None:
    entries = arch.load_tile("vivid-tile").pes[5].constants
    assert movs(delivered(COUNTER, taken=entries - 2, i=5)) == 0
    assert movs(delivered(COUNTER, taken=entries - 1, i=5)) == 1


def test_what_two_operations_read_is_moved() -> None:
    twice = COUNTER + '%4 = sub %0, %1\n%5 = live_out "%j" %4\n'
    ready = delivered(twice, i=5, j=9)
    assert movs(ready) == 1
    assert set(ready.allowed) == {3, 5, 6}


def test_a_live_out_reads_what_an_operation_makes() -> None:
    copied = 'dfg "straight"\n%0 = live_in "%i"\n%1 = live_out "%j" %0\n'
    assert movs(delivered(copied, i=5, j=9)) == 1


BOTH: Final = """dfg "straight"
%0 = live_in "%i"
%1 = live_in "%j"
%2 = add %0, %1
%3 = live_out "%i" %2
"""


def test_of_two_variables_a_link_apart_one_is_moved() -> None:
    ready = delivered(BOTH, i=5, j=6)
    assert movs(ready) == 1
    assert ready.allowed[2] == {5}


def test_variables_further_apart_meet_between_their_homes() -> None:
    ready = delivered(BOTH, i=0, j=15)
    assert movs(ready) == 2
    assert 2 not in ready.allowed


def test_a_reader_that_waits_for_others_is_not_bound() -> None:
    later = """dfg "straight"
%0 = live_in "%i"
%1 = live_in "n"
%2 = mul %1, %1
%3 = add %2, %0
%4 = live_out "%i" %3
"""
    assert movs(delivered(later, i=5)) == 1


LOADED: Final = """dfg "straight"
%0 = live_in "%i"
%1 = live_in "&x"
%2 = load "x" %0 shift 2 base %1
%3 = live_out "%y" %2
"""


def test_a_load_reads_at_home_where_there_is_memory() -> None:
    at_edge = delivered(LOADED, i=4, y=4)
    assert movs(at_edge) == 0
    assert at_edge.allowed[2] == {4}
    inside = delivered(LOADED, i=5, y=4)
    assert movs(inside) == 1
    assert 2 not in inside.allowed


def test_where_operations_wait_for_pes_fewer_words_are_moved() -> None:
    sums = "\n".join(
        f'%{4 * k} = live_in "%i{k}"\n%{4 * k + 1} = live_in "%j{k}"\n'
        f"%{4 * k + 2} = add %{4 * k}, %{4 * k + 1}\n"
        f'%{4 * k + 3} = live_out "%i{k}" %{4 * k + 2}'
        for k in range(12)
    )
    homes = {f"{name}{k}": pe for k in range(12) for name, pe in (("i", 0), ("j", 15))}
    assert movs(delivered(f'dfg "straight"\n{sums}\n', **homes)) == 12
