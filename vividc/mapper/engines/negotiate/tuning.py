"""The constants of annealing, repair and negotiation, and how hard one try is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

NAMING_ROUNDS: Final = 12
"""Routings of one placement, each with a register less in the files whose words found no names."""
CUT_S: Final = 0.01
"""Effort of having words of a file change registers, where they have no allocation."""
REPAIR_HEATS: Final = (5.0, 1.0)
OUTPUT_REPAIR_HEATS: Final = (3.0, 0.5)
SHOWN_REPAIR_HEATS: Final = (0.8, 0.25)
NEARLY_FREE_HEATS: Final = (0.8, 0.2)
"""First and last heat of a repair: over links, where words go through output registers, from routes
as the annealer claimed moves for them, and from negotiated routes that crowd little (`FEW`).
"""
FEW_SHARE: Final = 1 / 4
"""Of the moves, for each of two repairs of negotiated routes that crowd little: of those that are
there, and of new ones. One that succeeds mostly does in a twentieth of the moves, and which one
does varies: of 17 states of a loop that fills the array (march_rays) the first cleared 2, the
second 3, and what neither cleared 150 moves a node did not, either.
"""
LITTLE: Final = 8
"""Violations up to which a result is annealed again."""
FROZEN: Final = ((2.5, 3), (1.5, 2), (0.9, 1))
"""Heats from which on so much that is broken stays so, where moves are not claimed: of 164
annealings of eight loops of 80 to 358 operations 67 came to nothing broken, and one of these had as
much left.
"""
LITTLE_IN_HASTE: Final = 2
"""The same where annealing `quits`: of 505 repetitions 55 of 172 with one left came to nothing
broken, 10 of 128 with two, 2 of 75 with three, none of 130 with more.
"""
FAR, LEAST_FAR = ((8.0, 1 / 6), (6.0, 1 / 12), (4.0, 1 / 25), (2.5, 1 / 50)), 3
"""Heats from which on a graph is far from a mapping at this II with such a part of its nodes
broken, and so many more.
"""
CROWDED_ROUND, CROWDED, LEAST_CROWDED = 10, 0.4, 16
"""A negotiation that `quits` is given up after so many rounds with crowding of such a part of the
nodes, and of so much: of 910 that crowd nothing in the end none was above, nor were 205 of 328
others.
"""
QUENCH, QUENCH_HOT, QUENCH_COLD = 0.25, 2.0, 0.2
"""Part of the moves, and heats, of the quench that ends annealing when nothing is broken."""
OUTPUT_REPAIRS: Final = 25
OUTPUT_NODES: Final = 100
"""Where words go through output registers, annealing without routes sees little of what they cost,
and a move with routes takes a twentieth of the time that it takes over links: so many times the
moves, of graphs up to so many nodes.
"""
SLICE: Final = 10_000
REPAIR_SLICE: Final = 64
"""Moves, without and with routes, between two looks at the deadline."""
SLICES_IN_HASTE: Final = 20
"""Of a repair where annealing `quits`: of 96 repairs that clear a placement 4 take more, and those
that fail spend half of all slices beyond it.
"""
BEGIN_S: Final = 0.005
MOVE_S, SHOWN_MOVE_S = 2e-7, 5e-7
REPAIR_S, OUTPUT_REPAIR_S = 1e-4, 1e-5
ROUTED_S: Final = 2e-5
TYPICAL_EDGES: Final = 1.3
"""Effort of an attempt's arrays, of a move without and with moves of words claimed, of a move with
routes (where words go through output registers), and of routing the words of a node, in graphs of
so many edges a node; denser ones take as much more.
"""
HOPELESS: Final = ((0.0, 1 / 4), (0.1, 1 / 8))
"""From such a part of the moves with routes on, crowding of more than such a part of the nodes is
given up: of 170 such repairs on public graphs none came from above a sixteenth to nothing, and of
a graph of 293 nodes all moves halve it at best.
"""
FEW: Final = 8
"""Crowding up to which a repair is never given up."""
SEED_STEP: Final = 1000
"""Between the seeds of attempts that run side by side."""
HISTORY, GROWTH, MOST_PRESSURE = 0.6, 1.2, 40.0
"""Of negotiation: what a round adds to the price of crowded resources, the growth of the pressure
of crowding, and its limit.
"""
REPAIR_PRESSURE: Final = 3.0
"""The pressure of crowding during a repair."""
MOST_CELLS: Final = 20_000_000
"""The largest work space of a search."""


@dataclass(frozen=True, slots=True)
class Cooling:
    """Of annealing: heats, the part of the first from which a mapping is altered, and those with
    which it is done again.
    """

    hot: float
    cold: float
    warm: float
    again: tuple[float, ...]


FREELY: Final = Cooling(30.0, 0.2, 1 / 10, (0.25, 0.25))
SHOWN: Final = Cooling(12.0, 1.5, 0.6, (0.6, 0.6))
"""Where moves of words are claimed: from about as much broken as there are operations to where
nothing that is broken changes any more.
"""


@dataclass(frozen=True, slots=True)
class Effort:
    """How hard one try is: annealing moves a node without routes, rounds of negotiation, moves a
    node with routes, and how often all that is tried; `shown`: how many times the annealing moves
    where moves of words are claimed, since little is left to routes; `quits`: annealing ends where
    what is broken is frozen, and routing where it is hopeless.

    Of 306 annealings of 17 loops' graphs 158 came to nothing broken with 8000 moves before moves
    looked for what is broken (`_FOCUS`), 202 since, 184 with 5600.
    """

    moves: int = 5000
    rounds: int = 30
    repairs: int = 150
    trials: int = 2
    shown: int = 3
    quits: bool = False
