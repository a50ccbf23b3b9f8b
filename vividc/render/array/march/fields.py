"""Chooses the field that computes a ray-marched scene on the array."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from vividc.render.array.device.device import Device, open_device
from vividc.render.array.models.field import ArrayField
from vividc.render.array.models.instant_ngp import InstantNGPField
from vividc.render.array.models.kilonerf import KiloNeRFField
from vividc.render.array.models.tensorf import TensoRFField
from vividc.render.array.options import ArrayOptions
from vividc.render.errors import SceneError
from vividc.render.radiance import InstantNGP, KiloNeRF, TensoRF
from vividc.render.scenes import Scene

_FIELDS: Final[dict[type, Callable[..., ArrayField]]] = {
    KiloNeRF: KiloNeRFField,
    InstantNGP: InstantNGPField,
    TensoRF: TensoRFField,
}


def open_field(
    scene: Scene, options: ArrayOptions, tell: Callable[[str], None] | None = None
) -> tuple[Device, ArrayField]:
    """Return the accelerator, and the scene as its kernels take it.

    Raises
    ------
    SceneError
        The method is not ray-marched, or the scene does not fit the array.
    ArchError
        The fabric is unknown, faulty or a single tile.
    """
    device = open_device(options.fabric, options.engine, tell, options.mode)
    for kind, field in _FIELDS.items():
        if isinstance(scene, kind):
            return device, field(scene, device, options.precision)
    raise SceneError("the array does not render scenes of this method yet")
