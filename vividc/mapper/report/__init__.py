"""A result for people and for files.

In order: `explain` (what it proves and what binds it), `document` (JSON and back), `draw/`,
`methods` (all that as methods of results).
"""
