"""What places, times and routes a graph at one II.

In order: `refusals` (of straight code), `greedy/` (one pass over it), `list_schedule` (passes until
one is short), `cpsat/` (constraints), `negotiate/` (annealing and negotiated routing).
"""
