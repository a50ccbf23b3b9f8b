"""Which kernels the stages of a frame run, and how they are compiled where it is not as any kernel
is.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import Final

from vividc import LoopOptions
from vividc.render.array.options import PRECISIONS, RenderPrecision

Options = Mapping[str, object]
"""Keywords of `vividc.compile`."""

_AS_WRITTEN: Final[Options] = {"loops": LoopOptions(auto=False)}
"""Unrolled and interleaved by hand, for the short loops of a launch."""
_QUICKLY: Final[Options] = {"effort": "fast"}
"""At most 1 % of a frame, or DRAM binds: two thirds of the time of mapping are won, and less than
0.2 % of a frame are lost."""
_OPTIONS: Final[dict[str, Options]] = {
    "render/block_depths": {**_AS_WRITTEN, **_QUICKLY},
    "render/marching": _AS_WRITTEN,
    "render/marching:camera_rays": _QUICKLY,
    "render/hash_grid": _AS_WRITTEN,
    "render/instant_ngp": _QUICKLY,
    "render/instant_ngp:colour_inputs_fp8": {},
    "render/tensor_factors": _AS_WRITTEN,
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
    "render/splat_project": {**_QUICKLY, "time_limit_s": 30.0},
}
"""By file, or by kernel."""


def options_of(kernel: str) -> Options:
    """Return the options of a kernel, as in "render/marching:march_rays"."""
    file, _, _ = kernel.partition(":")
    return _OPTIONS.get(kernel, _OPTIONS.get(file, {}))


Wanted = tuple[str, Options]
"""A kernel, and options beside those that it always has, as `Programs.get` takes them."""

METHODS: Final = ("3dgs", "kilonerf", "instant-ngp", "tensorf")

_MARCHED: Final = ("marching:camera_rays", "block_depths:block_depths", "marching:march_rays")
_OF_ALL_FORMATS: Final = {
    "kilonerf": (
        *("kilonerf:group_samples", "kilonerf:group_survivors"),
        *("marching:transmittance_in_groups", "marching:accumulate_in_groups"),
    ),
    "instant-ngp": ("marching:sample_points",),
    "tensorf": (
        *("marching:sample_points", "marching:sample_directions"),
        "marching:transmittance_of_sums",
    ),
}
_SPLATS: Final = (
    "splat_project:splat_footprints",
    "splat_project:splat_covariance",
    *(
        f"splat_sort:{kernel}"
        for kernel in (
            *("depth_counts", "chunk_places", "depth_scatter"),
            *("span_counts", "row_scatter", "column_scatter"),
        )
    ),
)
_KERNELS: Final[Mapping[tuple[str, RenderPrecision], tuple[str, ...]]] = {
    ("kilonerf", "fp32"): (
        *("kilonerf:colour_network", "kilonerf:density_network"),
        *("kilonerf:encode_position", "kilonerf:encode_direction"),
    ),
    ("kilonerf", "fp8"): (
        *("kilonerf_fp8:density_network", "kilonerf_fp8:colour_network"),
        "kilonerf_fp8:encode_direction",
    ),
    ("instant-ngp", "fp32"): (
        *("instant_ngp:colour_inputs", "hash_grid:two_levels", "layers:layer"),
        *("marching:accumulate_sigmoids", "marching:transmittance_of_exponents"),
        "instant_ngp:directions",
    ),
    ("instant-ngp", "fp8"): (
        *("marching:accumulate_sigmoids_fp8", "hash_grid:two_levels_fp8"),
        *("instant_ngp:colour_inputs_fp8", "marching:transmittance_of_exponents_fp8"),
        "instant_ngp:directions_fp8",
    ),
    ("tensorf", "fp32"): (
        *("tensor_factors:colour_inputs", "marching:accumulate_sigmoids", "layers:layer"),
        *("tensor_factors:factor_sums", "tensor_factors:factor_products"),
    ),
    ("tensorf", "fp8"): (
        *("tensor_factors:colour_inputs_fp8", "marching:accumulate_sigmoids_fp8"),
        *("tensor_factors:factor_products_fp8", "tensor_factors:factor_sums_fp16"),
    ),
}
"""Of the networks and tables of a method, those that take longest to compile first."""


def exp_in(precision: RenderPrecision) -> Options:
    """Return options of a kernel whose exp is computed in a format."""
    return {} if precision == "fp32" else {"precision": {"exp": precision}}


def kernels_of(method: str, precision: RenderPrecision, degree: int = 3) -> tuple[Wanted, ...]:
    """Return kernels that frames of a method run with the usual options; none of a format that a
    method is seldom rendered in.

    Parameters
    ----------
    degree
        Of the spherical harmonics of Gaussians.
    """
    if method == METHODS[0]:
        blend = ("render/splat_blend:blend_lookahead", exp_in(precision))
        names = (f"splat_project:splat_colours_{degree}", *_SPLATS)
        return blend, *((f"render/{name}", {}) for name in names)
    if (method, precision) in _KERNELS:
        names = (*_KERNELS[method, precision], *_MARCHED, *_OF_ALL_FORMATS[method])
        return tuple((f"render/{name}", {}) for name in names)
    return ()


def all_kernels() -> tuple[Wanted, ...]:
    """Return the kernels of all methods in all formats."""
    every = (kernels_of(*pair) for pair in product(METHODS, PRECISIONS))
    return tuple({str(one): one for kernels in every for one in kernels}.values())
