"""Networks in a TPU-like mode, where that takes fewer cycles than kernels on the tiles would."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from vividc.errors import ArchError
from vividc.gemm import Layer, SystolicError, choose_layout, mlp_job
from vividc.gemm.passes import with_arrays
from vividc.render.array.device.device import Device
from vividc.render.arrays import Float32Array

_PRODUCT: Final = 7.9
"""Cycles of a tile for 64 products, bank conflicts included; see `kernels/render/layers.py`."""
_SUMS: Final = 85
"""Cycles to begin and end 64 sums."""
_CONFIGURED: Final = 22_000
"""Cycles to load the kernel into all tiles."""
_SIDE: Final = 8
"""Samples and neurons of the sums that a tile computes together."""


def tile_cycles(shapes: Sequence[tuple[int, int, int]], samples: int, tiles: int) -> int:
    """Return about how long the kernel of layers takes in GPU-like mode.

    Parameters
    ----------
    shapes
        Inputs, outputs and parts of each layer.
    """
    total = 0.0
    for inputs, outputs, parts in shapes:
        blocks = -(-samples // _SIDE) * -(-outputs // _SIDE)
        total += blocks * (_PRODUCT * inputs + _SUMS) / tiles + parts * _CONFIGURED
    return round(total)


def tpu_choice(device: Device, layers: Sequence[Layer], samples: int) -> tuple[str, int] | None:
    """Return the better TPU-like mode of those that the device may use, and the cycles that are
    expected of it; None: it has none, or a layer does not fit.
    """
    if device.mode == "gpu":
        return None
    try:
        machine = with_arrays(device.programs.machine)
        layout, _ = choose_layout(samples, layers, device.mode, machine)
    except (ArchError, SystolicError):
        return None
    return layout.mode, layout.cycles


def run_systolic(
    device: Device,
    stage: str,
    layers: Sequence[Layer],
    blocks: Float32Array,
    mode: str,
    *,
    words: bool = False,
) -> Float32Array:
    """Return the network's outputs [B, outputs, 16] of blocks of samples [B, inputs, 16]; with
    `words`, the inputs are words of the first layer's format.

    In tpu-unified the array's blocks are those of the samples, and the rows given here are only
    another view of them.
    """
    rows = np.ascontiguousarray(blocks.transpose(0, 2, 1)).reshape(-1, blocks.shape[1])
    with device.ledger.timed(stage, mode):
        run = mlp_job(
            rows,
            layers,
            mode=mode,
            accelerator=device.programs.machine,
            engine=device.engine,
            words=words,
        )
    device.ledger.add(stage, run.job, mode)
    values = run.values.reshape(len(blocks), blocks.shape[2], -1)
    return np.ascontiguousarray(values.transpose(0, 2, 1))
