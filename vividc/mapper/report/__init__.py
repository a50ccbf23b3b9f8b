"""A result for people and for files: `explain` (what it proves and what binds it), `document` (JSON
and back), `draw/`.
"""
