"""How a scene is rendered on the array."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal, get_args

from vividc.render.splat.blend_reference import BlendOptions

RenderPrecision = Literal["fp32", "fp16", "fp8"]
PRECISIONS: Final[tuple[RenderPrecision, ...]] = get_args(RenderPrecision)
NetworkMode = Literal["auto", "gpu", "tpu-unified", "tpu-partitioned"]
NETWORK_MODES: Final[tuple[NetworkMode, ...]] = get_args(NetworkMode)


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
        Format of the networks' operands (ray-marched models), or of exp (Gaussians); sums and all
        other stages are float32, but with "fp8", which is E4M3, tables are float16.
    mode
        Of the networks of Instant-NGP and TensoRF: "auto", whichever takes fewest cycles; "gpu",
        kernels on the tiles alone; a TPU-like mode, that one or "gpu". The picture is the same.
    weight_min
        Of ray-marched models: a sample's colour counts only if its weight is above this, and above
        the model's own threshold. What that saves and costs is in docs/rendering.md.
    """

    fabric: str = "vivid"
    engine: str = "auto"
    lookahead: bool = True
    exponent_margin: float = BlendOptions().margin
    sample: float = 1.0
    precision: RenderPrecision = "fp32"
    mode: NetworkMode = "auto"
    weight_min: float = 0.0
