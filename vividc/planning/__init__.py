"""Which loop transformations pay: estimates from bounds, the choice, and what was decided."""
