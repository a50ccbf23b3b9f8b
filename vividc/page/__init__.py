"""A program, and a run of it, as one HTML page that needs no network: `vividc view`.

In order: `source` (the kernel's file, and how hot its lines are), `regions` (graph, schedule and
bounds of each region as data), `runs` (a recorded window, and what was busy in it), `write` (the
page). `assets/` has the page's own code and the library that lays out graphs.
"""
