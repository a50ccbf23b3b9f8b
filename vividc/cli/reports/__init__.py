"""What commands print.

In order: `report` (JSON, tables, progress), `program`, `binds`, `loop`, `energy`, `job`, `frame`,
`views` (traces and pictures), `cycle_progress`.
"""
