"""Pictures of mappings.

In order: `scene` (what is seen), `label`, `array`, `table`, `draw`.
"""
