"""View-dependent colour from real spherical harmonics, degree 0 to 3."""

from __future__ import annotations

import numpy as np

from vividc.render.arrays import Float32Array

# Normalisation constants of the real spherical harmonics (Sloan 2008, appendix A2).
_Y0 = 0.28209479177387814
_Y1 = 0.4886025119029199
_Y2_XY = 1.0925484305920792
_Y2_ZZ = 0.31539156525252005
_Y2_XX = 0.5462742152960396
_Y3_XXY = 0.5900435899266435
_Y3_XYZ = 2.890611442640554
_Y3_YZZ = 0.4570457994644658
_Y3_ZZZ = 0.3731763325901154
_Y3_XXZ = 1.445305721320277


def sh_basis(directions: Float32Array, coefficients: int) -> Float32Array:
    """Return the first `coefficients` (1, 4, 9 or 16) basis values, [N, K] float32.

    `directions` is [N, 3], unit length. Order m = -l..l within a degree; odd m negative
    (the Condon-Shortley phase), as 3DGS scenes are trained with.
    """
    x, y, z = directions[:, 0], directions[:, 1], directions[:, 2]
    xx, yy, zz = x * x, y * y, z * z
    values = (
        np.full_like(x, _Y0),
        -_Y1 * y,
        _Y1 * z,
        -_Y1 * x,
        _Y2_XY * (x * y),
        -_Y2_XY * (y * z),
        _Y2_ZZ * (2 * zz - xx - yy),
        -_Y2_XY * (x * z),
        _Y2_XX * (xx - yy),
        -_Y3_XXY * y * (3 * xx - yy),
        _Y3_XYZ * (x * y) * z,
        -_Y3_YZZ * y * (4 * zz - xx - yy),
        _Y3_ZZZ * z * (2 * zz - 3 * xx - 3 * yy),
        -_Y3_YZZ * x * (4 * zz - xx - yy),
        _Y3_XXZ * z * (xx - yy),
        -_Y3_XXY * x * (xx - 3 * yy),
    )
    return np.stack(values[:coefficients], axis=1)


def sh_colour(sh: Float32Array, directions: Float32Array) -> Float32Array:
    """Return max(0, sum_k Y_k(direction) sh_k + 0.5), [N, 3] float32 from sh [N, K, 3]."""
    basis = sh_basis(directions, sh.shape[1])
    weighted: Float32Array = np.einsum("nk,nkc->nc", basis, sh)
    colour: Float32Array = np.maximum(weighted + np.float32(0.5), np.float32(0))
    return colour
