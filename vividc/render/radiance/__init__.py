"""The ray-marched models: KiloNeRF, Instant-NGP and TensoRF, rendered in float32.

In order: `occupancy`, `volume` (rays and their samples), `layers`; `kilonerf`, `instant_ngp`,
`tensorf`.
"""

from vividc.render.radiance.instant_ngp import InstantNGP
from vividc.render.radiance.kilonerf import KiloNeRF
from vividc.render.radiance.layers import Layer, linear
from vividc.render.radiance.occupancy import (
    March,
    directions_of,
    occupied_samples,
    pixel_rays,
)
from vividc.render.radiance.tensorf import TensoRF
from vividc.render.radiance.volume import MarchCounts, RadianceField, render_field, render_rays

__all__ = [
    "InstantNGP",
    "KiloNeRF",
    "Layer",
    "March",
    "MarchCounts",
    "RadianceField",
    "TensoRF",
    "directions_of",
    "linear",
    "occupied_samples",
    "pixel_rays",
    "render_field",
    "render_rays",
]
