"""The light that reaches samples, which of them count, and the picture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vividc.render.array.device.device import Device
from vividc.render.array.pieces import Piece, Survivors, survivors_of, total
from vividc.render.array.records import Fields, Results, items, of_blocks, of_samples, weights
from vividc.render.arrays import Float32Array


def light_along(
    device: Device,
    pieces: Sequence[Piece],
    densities: Results,
    limits: Float32Array,
    left: Float32Array,
    keep_all: bool,
) -> list[Survivors]:
    """Return the samples whose colour is computed, and put the light behind all samples into
    `left`, [R].

    Parameters
    ----------
    limits
        Light before a sample that counts, at least, and its weight, above that.
    keep_all
        Whether others stay, with a weight of 0.
    """
    listed, weights_of = np.zeros(total(pieces), np.int32), np.zeros(total(pieces), np.float32)
    fields = Fields(
        reads={"items": items},
        writes={"kept_items": of_samples(listed), "weights": of_samples(weights_of)},
        count="count",
        shared={"limits": limits},
        carries={"left": of_blocks(left)},
        scalars=lambda piece: {"goes_on": int(piece.turn > 0), "keep_all": int(keep_all)},
    )
    returned = densities.run(device, "transmittance", pieces, fields)
    return list(survivors_of(pieces, returned, listed, weights_of))


def picture_of(
    device: Device, survivors: Sequence[Survivors], colours: Results, left: Float32Array
) -> Float32Array:
    """Return r, g, b over white and transmittance of each ray [R, 4]."""
    out = np.ones((len(left), 4), dtype=np.float32)
    fields = Fields(
        reads={"weights": weights, "items": items},
        holds={"left": of_blocks(left)},
        carries={"out": of_blocks(out)},
        scalars=lambda piece: {"goes_on": int(piece.turn > 0), "is_last": int(piece.is_last)},
    )
    colours.run(device, "accumulation", survivors, fields)
    return out
