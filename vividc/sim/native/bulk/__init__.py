"""Loops of many operations by tables: `tables`, `vectors`, `write`."""
