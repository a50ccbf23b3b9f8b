"""Nests of affine loops are given other loops.

In order: `parts` (static-control parts, and others' shares beside one), `factors` (how many
iterations run together), `trees` (what each tree of loops makes of a part, on two cores),
`restructure` (the search for the best tree).
"""
