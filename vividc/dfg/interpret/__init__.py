"""Runs graphs without an array: `executable` (a graph as a list of steps), `interpreter`."""
