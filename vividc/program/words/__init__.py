"""The configuration word.

In order: `layout` (its fields), `entry` (one decoded), `pack` and `decode`, `wires`.
"""
