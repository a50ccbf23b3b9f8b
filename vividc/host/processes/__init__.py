"""Other processes: `lifeline` (one that ends with the process that started it), `crew` (work shared
with helpers).
"""
