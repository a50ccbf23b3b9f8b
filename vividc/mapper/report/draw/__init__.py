"""Pictures of mappings.

In order: `scene` (what is seen), `grid`, `label`, `wires`, `array`, `table`, `draw`.
"""
