"""Energy and area of a circuit at another node (Stillmaker and Baas 2017).

Their tables, from HSpice simulations with predictive models, Integration 58, 74-81. Between two
nodes of the tables: linear interpolation in the node.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from vividc.errors import ArchError

REFERENCE_NM: Final = 45.0
SUPPLY_V: Final = 0.9
"""Supply at which energies are compared, the same at all nodes: inside the range of every fit."""
SOURCE: Final = "Stillmaker and Baas, Integration 58 (2017), at 0.9 V"

_AREA: Final[Mapping[float, float]] = {
    45: 1.0,
    32: 0.46,
    20: 0.21,
    16: 0.19,
    14: 0.17,
    10: 0.1,
    7: 0.059,
}
"""Area of a circuit, that at 45 nm being 1."""

_ENERGY: Final[Mapping[float, tuple[float, float, float]]] = {
    45: (1.103, -0.362, 0.2767),
    32: (0.9559, -0.7823, 0.471),
    20: (0.373, -0.1582, 0.04104),
    16: (0.2958, -0.1241, 0.03024),
    14: (0.2363, -0.09675, 0.02239),
    10: (0.2068, -0.09311, 0.02375),
    7: (0.1776, -0.09097, 0.02447),
}
"""Coefficients of V**2, V and 1 of the energy of a switching circuit."""


def area_factor(node_nm: float) -> float:
    """Area at a node over that at 45 nm.

    Raises
    ------
    ArchError
        The node is outside 7 .. 45 nm.
    """
    return _interpolated(_AREA, node_nm)


def energy_factor(node_nm: float, supply_v: float = SUPPLY_V) -> float:
    """Energy at a node over that at 45 nm, both at `supply_v`.

    Raises
    ------
    ArchError
        The node is outside 7 .. 45 nm.
    """
    energies = {node: a * supply_v**2 + b * supply_v + c for node, (a, b, c) in _ENERGY.items()}
    return _interpolated(energies, node_nm) / energies[REFERENCE_NM]


def _interpolated(values: Mapping[float, float], node_nm: float) -> float:
    nodes = sorted(values)
    if not nodes[0] <= node_nm <= nodes[-1]:
        raise ArchError(
            f"no scaling to {node_nm:g} nm", hint=f"nodes from {nodes[0]} to {nodes[-1]} nm"
        )
    above = next(node for node in nodes if node >= node_nm)
    if above == node_nm:
        return values[above]
    below = nodes[nodes.index(above) - 1]
    share = (node_nm - below) / (above - below)
    return values[below] + share * (values[above] - values[below])
