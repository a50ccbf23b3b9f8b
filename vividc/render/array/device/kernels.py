"""How the kernels of the stages are compiled, where it is not as any kernel is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from vividc import LoopOptions

Options = Mapping[str, object]
"""Keywords of `vividc.compile`."""

_AS_WRITTEN: Final[Options] = {"loops": LoopOptions(auto=False)}
"""Unrolled and interleaved by hand, for the short loops of a launch."""
_QUICKLY: Final[Options] = {"effort": "fast"}
"""At most 1 % of a frame."""
_OPTIONS: Final[dict[str, Options]] = {
    "render/block_depths": {**_AS_WRITTEN, **_QUICKLY},
    "render/marching": _AS_WRITTEN,
    "render/marching:camera_rays": _QUICKLY,
    "render/hash_grid": _AS_WRITTEN,
    "render/tensor_factors": _AS_WRITTEN,
    "render/tensor_factors:density": {},
    "render/tensor_factors:colour_inputs": {},
    "render/tensor_factors:colour_inputs_fp8": {},
    "render/kilonerf": _AS_WRITTEN,
    "render/kilonerf:cell_numbers": {},
    "render/kilonerf:encode_position": {},
    "render/kilonerf:encode_direction": {},
    # Seconds for kernels of many loops, whose IIs are the time of a frame.
    "render/kilonerf_fp8": {**_AS_WRITTEN, "time_limit_s": 150.0},
    "render/kilonerf_fp8:encode_direction": {},
    "render/splat_blend": {"time_limit_s": 150.0},
    "render/splat_project:splat_footprints": {"time_limit_s": 30.0},
}
"""By file, or by kernel."""


def options_of(kernel: str) -> Options:
    """Return the options of a kernel, as in "render/marching:march_rays"."""
    file, _, _ = kernel.partition(":")
    return _OPTIONS.get(kernel, _OPTIONS.get(file, {}))
