"""From a function in SSA form to regions with a graph each.

In order: `memory_order` (which accesses wait for which), `addresses`, `if_convert`, `build_loop`
and `build_straight` (the graph of a region), `build` (the table of regions).
"""
