"""What places, times and routes a graph at one II.

In order: `refusals` (of straight code), `list_schedule` (straight code), `cpsat/` (constraints),
`negotiate/` (annealing and negotiated routing).
"""
