"""Words that belong to two regions at once.

In order: `words` (parts of them), `sides` (two regions under way in the same cycles), `drains` (of
a loop that ends while a region begins), `fills` (of one that begins while a region ends), `parts`.
"""
