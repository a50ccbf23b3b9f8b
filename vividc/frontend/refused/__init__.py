"""What numba refuses, in the user's words: `source`, `numpy`, `refusals`, `diagnose`; and what is
too long: `length`.
"""
