"""The renderers on the array: stages are compiled kernels, the host makes launch graphs.

In order: `options`, `sampling` (which blocks are simulated), `steering` (sizes that were measured);
`device/`; `pieces` (of the samples of a block) and `records` (kernels over their fields),
`network/`, `models/` and `march/` (ray-marched methods); `splats/` (3DGS); `render`, which picks
one.
"""

from vividc.render.array.device.device import Device, open_device
from vividc.render.array.device.frame import ArrayFrame, Ledger, Stage
from vividc.render.array.device.programs import Programs
from vividc.render.array.models.field import ArrayField
from vividc.render.array.options import (
    NETWORK_MODES,
    PRECISIONS,
    ArrayOptions,
    NetworkMode,
    RenderPrecision,
)
from vividc.render.array.render import render_array

__all__ = [
    "NETWORK_MODES",
    "PRECISIONS",
    "ArrayField",
    "ArrayFrame",
    "ArrayOptions",
    "Device",
    "Ledger",
    "NetworkMode",
    "Programs",
    "RenderPrecision",
    "Stage",
    "open_device",
    "render_array",
]
