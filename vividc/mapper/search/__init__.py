"""Which IIs are tried, how, and when a search is over.

In order: `campaign` (what is mapped, refuted, open), `attempt` (one II), `kms`, `large` (graphs
that take constraints long), `foothold` (a first mapping of small ones), `windows` (rectangles of a
large array), `portfolio`, which calls them.
"""
