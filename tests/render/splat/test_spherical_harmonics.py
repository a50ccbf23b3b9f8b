"""The spherical-harmonics basis against what defines it, not against its formulas."""

from __future__ import annotations

import numpy as np
import pytest

from vividc.render.splat.spherical_harmonics import sh_basis, sh_colour


def sphere_quadrature() -> tuple[np.ndarray, np.ndarray]:
    """Return directions [N, 3] and weights [N] exact for polynomials of degree 7 on the sphere."""
    heights, height_weights = np.polynomial.legendre.leggauss(8)
    angles = 2 * np.pi * np.arange(16) / 16
    z, angle = np.meshgrid(heights, angles, indexing="ij")
    ring = np.sqrt(1 - z**2)
    directions = np.stack((ring * np.cos(angle), ring * np.sin(angle), z), axis=-1)
    weights = np.repeat(height_weights * 2 * np.pi / 16, 16)
    return directions.reshape(-1, 3), weights


def test_basis_is_orthonormal_on_the_sphere() -> None:
    directions, weights = sphere_quadrature()
    basis = sh_basis(directions.astype(np.float32), 16).astype(np.float64)
    gram = np.einsum("n,nj,nk->jk", weights, basis, basis)
    np.testing.assert_allclose(gram, np.eye(16), atol=1e-6)


def test_signs_of_degree_one_follow_the_training_convention() -> None:
    axes = np.eye(3, dtype=np.float32)
    signs = np.sign(sh_basis(axes, 4)[:, 1:])
    np.testing.assert_array_equal(signs, [[0, 0, -1], [-1, 0, 0], [0, 1, 0]])


@pytest.mark.parametrize("coefficients", [1, 4, 9, 16])
def test_lower_degrees_are_prefixes(coefficients: int) -> None:
    directions = sphere_quadrature()[0].astype(np.float32)
    np.testing.assert_array_equal(
        sh_basis(directions, coefficients), sh_basis(directions, 16)[:, :coefficients]
    )


def test_colour_is_shifted_by_half_and_not_negative() -> None:
    sh = np.array([[[0.0, 1.0, -9.0]]], dtype=np.float32)
    colour = sh_colour(sh, np.array([[0, 0, 1]], dtype=np.float32))
    np.testing.assert_allclose(colour, [[0.5, 0.5 + 0.2820948, 0.0]], rtol=1e-6)
    assert colour.dtype == np.float32
