"""Where variables live that no loop reads."""

from __future__ import annotations

from vividc import arch
from vividc.arch.fabric import Fabric
from vividc.compiler.regions.homes import Homes, variable_homes
from vividc.dfg.forms.text_parser import parse
from vividc.dfg.regions import Kernel, Region
from vividc.mapper.mapping import Mapping, Place
from vividc.mapper.resources.distances import hop_distances

COUNT = """dfg "loop"
%0 = live_in "%i"
%1 = live_in "x.shape0"
%2 = add %0, %1
"""
COPY = 'dfg "copy"\n%0 = live_in "%i"\n%1 = live_out "%j" %0\n'
END = 'dfg "end"\n%0 = live_in "%k"\n%1 = live_out "%i" %0\n'
BACK = 'dfg "back"\n%0 = live_in "%j"\n%1 = live_out "%k" %0\n'


def _tile() -> Fabric:
    fabric = arch.load("vivid-tile")
    assert isinstance(fabric, Fabric)
    return fabric


def _homes(*texts: str, entries: list[float] | None = None) -> Homes:
    """Homes in a kernel of a loop whose only operation lies on PE 15, and of straight regions."""
    loop = Region("loop", "loop", parse(COUNT))
    straight = [Region(f"s{at}", "straight", parse(text)) for at, text in enumerate(texts)]
    kernel = Kernel("k", (), (loop, *straight))
    mapping = Mapping(1, {2: Place(15, 0)}, {})
    return variable_homes(kernel, _tile(), {0: mapping}, entries)


def _apart(homes: Homes, one: str, other: str) -> int:
    hops = hop_distances(_tile())
    return min(hops[a][b] for a in homes[one] for b in homes[other])


def test_copies_of_a_variable_live_a_link_away_at_most() -> None:
    homes = _homes(COPY, BACK, END)
    assert homes["%i"] == {15}
    assert _apart(homes, "%i", "%j") <= 1
    assert _apart(homes, "%j", "%k") <= 1


def test_what_a_long_way_leads_to_lives_where_there_is_most_room() -> None:
    chain = 'dfg "chain"\n%0 = live_in "%i"\n%1 = const 1\n'
    last = 0
    for node in range(2, 10):
        chain += f"%{node} = add %{last}, %1\n"
        last = node
    chain += f'%10 = live_out "%j" %{last}\n'
    assert _homes(chain, BACK)["%j"] == {0}


def test_of_two_copies_the_one_that_is_made_more_often_is_shorter() -> None:
    """`%j` is copied from `%i`, and from `%m`, which a loop reads at the other corner."""
    loops = []
    for name, variable in (("one", "%i"), ("two", "%m")):
        loops.append(Region(name, "loop", parse(COUNT.replace("%i", variable))))
    other = COPY.replace("%i", "%m")
    read = BACK.replace("%k", "%i")
    straight = [
        Region(f"s{at}", "straight", parse(text)) for at, text in enumerate((COPY, other, read))
    ]
    kernel = Kernel("k", (), (*loops, *straight))
    mappings = {at: Mapping(1, {2: Place(pe, 0)}, {}) for at, pe in enumerate((15, 0))}
    for often, near in ((0, "%i"), (1, "%m")):
        entries = [1.0, 1.0, *(100.0 if at == often else 1.0 for at in range(2)), 0.0]
        homes = variable_homes(kernel, _tile(), mappings, entries)
        assert _apart(homes, near, "%j") <= 1
