"""From a function in SSA form to regions with a graph each.

In order: `carry_elements` (an element that a loop loads and stores is carried in a register),
`share_divisors` (what divisions by one divisor have in common comes before the loop),
`memory_order` (which accesses wait for which), `addresses`, `address_forms` (where accesses go, for
banks), `entries` (what lies between two runs of an inner loop becomes one region), `if_convert`,
`build_loop` and `build_straight` (the graph of a region), `build` (the table of regions).
"""
