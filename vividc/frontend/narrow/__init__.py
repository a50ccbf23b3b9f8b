"""Integers of 64 bits and doubles become words.

In order: `floor_division`, `single_trip`, `in_words` (as if the source had casts); `counting`,
`demand` and `demand_high` (which bits are read), `emit`; `integer`, `small`, `bits`, `divide`,
`float`, `formats`, `wide/` (two words); `narrow`, which calls them.
"""
