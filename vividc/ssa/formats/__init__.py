"""Arithmetic in formats narrower than float32.

In order: `precision` (which functions are computed in which format), `in_format` (their
arithmetic), `pack_groups` and `pack_lanes` (several threads in the lanes of a word).
"""
