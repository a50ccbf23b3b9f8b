"""Other processes: `lifeline` (one that ends with the process that started it), `crew` (work shared
with helpers), `ahead` (jobs done by a copy of this process before it comes to them), `beside` (one
that a copy does meanwhile).
"""
