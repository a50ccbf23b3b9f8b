"""KiloNeRF's networks in a format, as launches take them: a half of each network is a kernel."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from vividc.render.array.device.device import Device
from vividc.render.array.device.launch import Launch, Move, Words
from vividc.render.array.models.grouping import Part
from vividc.render.arrays import Float32Array, Int32Array

Slot = tuple[str, int]
"""Parameter of a kernel, and the word from which rows lie there."""


@dataclass(frozen=True, slots=True, eq=False)
class Half:
    """Half of all networks: density and features, or colour.

    Attributes
    ----------
    kernel
        As in `Programs.get`.
    weights
        Words of each network.
    takes
        Where rows lie that a launch takes: positions; or features and directions.
    shapes
        Of arrays, for so many samples.
    scalars
        Of a network.
    shared, work
        As of a `Launch`.
    """

    kernel: str
    weights: Sequence[Words]
    takes: Sequence[Slot]
    shapes: Callable[[int], Mapping[str, tuple[int, ...]]]
    scalars: Callable[[int], Mapping[str, object]]
    shared: Mapping[str, Words] = field(default_factory=dict)
    work: Mapping[str, tuple[int, ...]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class Networks:
    """All networks in a format.

    Attributes
    ----------
    at_once
        Samples of a launch: as many as fit twice beside the weights.
    together, extra
        Samples that a kernel computes together, and as how many times these what a launch costs
        beside them.
    density, colour
        Their halves.
    features
        The first half's parameter that gets them, and words of a sample.
    positions, directions
        Make the rows [n, ...] that the halves take, of places in cells and of unit vectors [n, 3].
    """

    at_once: int
    together: int
    extra: float
    density: Half
    colour: Half
    features: tuple[str, int]
    positions: Callable[[Device, Float32Array], Words]
    directions: Callable[[Device, Float32Array], Words]

    def run(
        self,
        device: Device,
        stage: str,
        half: Half,
        parts: Sequence[Part],
        given: Sequence[tuple[Words, Int32Array | None]],
        made: Mapping[str, Words],
    ) -> None:
        """Run a half over parts of samples.

        Parameters
        ----------
        given
            For each of `Half.takes` a table, and which row of it each sample has; None: its own.
        made
            What it leaves, by parameter, [n, ...].
        """
        launches = [
            Launch(
                shapes=half.shapes(part.count),
                inputs=_inputs(half, part, given),
                outputs={name: part.moves(table) for name, table in made.items()},
                shared={"weights": half.weights[part.network], **half.shared},
                work=half.work,
                scalars=half.scalars(part.network),
                cost=-(-part.count // self.together) + self.extra,
            )
            for part in parts
        ]
        device.run(stage, half.kernel, launches)


def _inputs(
    half: Half, part: Part, given: Sequence[tuple[Words, Int32Array | None]]
) -> dict[str, tuple[Move, ...]]:
    inputs: dict[str, tuple[Move, ...]] = {}
    for (name, first), (table, rows) in zip(half.takes, given, strict=True):
        inputs[name] = (*inputs.get(name, ()), *part.moves(table, first, rows))
    return inputs
