"""What a kernel raises.

In order: `texts` (those that say numbers), `convention` (calls of functions named after it).
"""
