"""KiloNeRF as a field that the array computes: samples sorted by network, each network's weights in
one scratchpad.
"""

from __future__ import annotations

import numpy as np

from vividc.render.array.device.device import Device
from vividc.render.array.models.field import ArrayField
from vividc.render.array.models.grouping import Grouping, Samples, parts_of
from vividc.render.array.models.kilonerf_fp8 import fp8_networks
from vividc.render.array.models.kilonerf_fp32 import fp32_networks
from vividc.render.array.options import RenderPrecision
from vividc.render.array.records import Kept, Listed, Results, of_samples
from vividc.render.radiance import KiloNeRF


class KiloNeRFField(ArrayField):
    """`ArrayField` of a KiloNeRF model.

    The features of a call of `densities` stay where the networks wrote them, in the order of
    networks, until its next call.

    Raises
    ------
    SceneError
        A network fits no scratchpad, or its hidden layers have a width that its kernels have not.
    """

    def __init__(
        self, model: KiloNeRF, device: Device, precision: RenderPrecision = "fp32"
    ) -> None:
        super().__init__(model, device)
        make = fp8_networks if precision == "fp8" else fp32_networks
        self._networks = make(model, device)
        self._grouping = Grouping(model, device)
        self.most_samples = self._grouping.most_samples
        self._samples: Samples | None = None
        self._features = np.zeros((0, 0), dtype=np.float32)

    def densities(self, listed: Listed) -> Results:
        """Return what samples have, in the order of networks; their features stay here."""
        nets = self._networks
        self._samples = samples = self._grouping.samples(listed)
        count = len(samples.local)
        thickness = np.zeros(count, dtype=np.float32)
        name, width = nets.features
        self._features = np.zeros((count, width), dtype=np.float32)
        given = [(nets.positions(self._device, samples.local), None)]
        made = {"thickness": thickness, name: self._features}
        parts = list(parts_of(samples.runs, nets.at_once))
        nets.run(self._device, "density network", nets.density, parts, given, made)
        reads = {"thickness": of_samples(thickness), "places": of_samples(samples.places)}
        return Results("transmittance_in_groups", reads)

    def colours(self, kept: Kept) -> Results:
        """Return r, g, b of each piece's samples, in the order of networks."""
        assert self._samples is not None
        nets = self._networks
        some = self._grouping.survivors(self._samples, kept)
        seen = nets.directions(self._device, kept.directions)
        rgb = np.full((len(some.rows), 3), 0.5, dtype=np.float32)
        given = [(self._features, some.rows), (seen, some.rays)]
        parts = list(parts_of(some.runs, nets.at_once))
        nets.run(self._device, "colour network", nets.colour, parts, given, {"colours": rgb})
        reads = {"colours": of_samples(rgb), "places": of_samples(some.places)}
        return Results("accumulate_in_groups", reads)
