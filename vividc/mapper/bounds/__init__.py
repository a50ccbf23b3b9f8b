"""Lower bounds on the II, each with what binds it.

In order: `refutations` (how they are named), `reach`, `pressure`, `bounds` (all of them for a
loop), `straight` (for straight code).
"""
