"""Fabrics as pictures.

In order: `grid` (where PEs lie), `wires` (how links are led), `picture`.
"""
