"""What native code will do: `schedule` (operations in order), `counts` (activity without counting),
`layout` (what code and caller share).
"""
