"""From YAML to fabrics and accelerators (docs/fabric-yaml.md).

In order: `tree` (values with their lines), `problems`, `schema` and `accelerator_schema` (the
keys), `layers` (`extends`), `build` (the checks that no schema can express), `load`, `reflect`
(mirror images of a tile), `load_machine`.
"""
