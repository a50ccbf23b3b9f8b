"""Energy and area of operations and memories.

In order: `schema`, `tables` (of the shipped YAML, with the source of each figure), `node_scaling`
(from one technology to another).
"""
