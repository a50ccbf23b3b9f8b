"""What native code will do: `trace` (where each word comes from), `schedule` (operations in order),
`counts` (activity without counting), `layout` (what code and caller share).
"""
