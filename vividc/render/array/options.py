"""How a scene is rendered on the array."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from vividc.render.blend_reference import BlendOptions


@dataclass(frozen=True, slots=True)
class ArrayOptions:
    """Switches of the renderers on the array.

    Attributes
    ----------
    fabric
        An accelerator's name, or a YAML file.
    engine
        Of the simulator.
    lookahead
        Lookahead Culling: I for ray-marched models, II for Gaussians.
    exponent_margin
        Of Lookahead Culling II.
    sample
        Share of the blocks of pixels that are simulated, above 0 and at most 1; which ones depends
        on their number only.
    precision
        Number format by stage; a stage that is not named computes in float32.
    """

    fabric: str = "vivid"
    engine: str = "auto"
    lookahead: bool = True
    exponent_margin: float = BlendOptions().margin
    sample: float = 1.0
    precision: Mapping[str, str] = field(default_factory=dict)
