"""From mappings to words.

In order: `programmable` (which fabrics have words), `checks`, `constants` (constant stores),
`banks`, `places` (of contexts), `lower` (one region), `encode` (a program), `reflect` (the program
of a mirrored tile).
"""
