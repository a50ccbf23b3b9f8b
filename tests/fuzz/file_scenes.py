"""Small scenes of each method, and views of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np

POSE: Final = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 4], [0, 0, 0, 1]]


def views() -> dict[str, Any]:
    """Two cameras with pictures."""
    poses = np.array([POSE, POSE], np.float32)
    images = np.zeros((2, 8, 8, 3), np.float32)
    return {"c2w": poses, "images": images, "focal": np.float32(9), "size": np.int32(8)}


def _march() -> dict[str, Any]:
    return {
        "aabb": np.array([[-1, -1, -1], [1, 1, 1]], np.float32),
        "step": np.float32(0.1),
        "n_samples": np.int32(20),
        "near": np.float32(2),
        "far": np.float32(6),
        "t_stop": np.float32(1e-4),
        "occ_bits": np.full(8, 255, np.uint8),
        "occ_shape": np.array([4, 4, 4], np.int32),
    }


def _drawn(*shape: int) -> Any:
    return np.random.default_rng(sum(shape)).normal(0, 0.3, shape).astype(np.float16)


def _gaussians() -> dict[str, Any]:
    return {
        "means": _drawn(3, 3).astype(np.float32),
        "log_scales": np.full((3, 3), -2, np.float16),
        "quats_wxyz": np.array([[2, 0, 0, 0], [0, 1, 0, 0], [1, 1, 0, 0]], np.float16),
        "opacity": np.array([0.5, 1.0, 0.2], np.float16),
        "sh": _drawn(3, 4, 3),
    }


def _kilonerf() -> dict[str, Any]:
    sizes = {1: (63, 4), 2: (4, 4), 3: (4, 5), 4: (31, 4), 5: (4, 3)}
    found = {f"w{i}": _drawn(2, *size) for i, size in sizes.items()}
    found |= {f"b{i}": _drawn(2, size[1]) for i, size in sizes.items()}
    index = np.array([0, 1, -1, 0, 0, 1, 0, 1], np.int16).reshape(2, 2, 2)
    return {**_march(), **found, "net_index": index, "net_grid": np.array([2, 2, 2], np.int32)}


def _instant_ngp() -> dict[str, Any]:
    return {
        **_march(),
        "table": _drawn(64 + 32, 2),
        "level_scale": np.array([2.0, 6.5], np.float32),
        "level_res": np.array([3, 8], np.int32),
        "level_offset": np.array([0, 64], np.int32),
        "level_entries": np.array([64, 32], np.int32),
        "level_dense": np.array([1, 0], np.uint8),
        "cube_lo": np.full(3, -1, np.float32),
        "cube_side": np.float32(2),
        "sigma_clamp": np.float32(11),
        "sigma0": _drawn(8, 4),
        "sigma1": _drawn(16, 8),
        "rgb0": _drawn(8, 32),
        "rgb1": _drawn(8, 8),
        "rgb2": _drawn(3, 8),
    }


def _tensorf() -> dict[str, Any]:
    found = {**_march(), "grid_res": np.array([4, 5, 6], np.int32)}
    for kind, channels in (("density", 2), ("app", 3)):
        for k, (plane, line) in enumerate((((5, 4), 6), ((6, 4), 5), ((6, 5), 4))):
            found[f"{kind}_plane_{k}"] = _drawn(channels, *plane)
            found[f"{kind}_line_{k}"] = _drawn(channels, line)
    for i, (outputs, inputs) in enumerate(((8, 150), (8, 8), (3, 8))):
        found |= {f"mlp_w{i}": _drawn(outputs, inputs), f"mlp_b{i}": _drawn(outputs)}
    found |= {"basis_w": _drawn(27, 9), "density_shift": np.float32(-1)}
    return {**found, "distance_scale": np.float32(25), "weight_thres": np.float32(1e-4)}


SCENES: Final[dict[str, Callable[[], dict[str, Any]]]] = {
    "means": _gaussians,
    "net_index": _kilonerf,
    "table": _instant_ngp,
    "density_plane_0": _tensorf,
}


def ply_bytes(form: str) -> bytes:
    """Four Gaussians, of degree 1."""
    names = [*"xyz", *(f"f_dc_{i}" for i in range(3)), *(f"f_rest_{i}" for i in range(9))]
    names += ["opacity", *(f"scale_{i}" for i in range(3)), *(f"rot_{i}" for i in range(4))]
    head = ["ply", f"format {form} 1.0", "comment small", "element vertex 4"]
    head += [*(f"property float {name}" for name in names), "end_header\n"]
    table = _drawn(4, len(names)).astype("<f4")
    if form == "ascii":
        body = "".join(" ".join(f"{value:.6g}" for value in row) + "\n" for row in table).encode()
    else:
        body = table.tobytes()
    return "\n".join(head).encode() + body
