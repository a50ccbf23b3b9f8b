"""Which IIs are tried, how, and when a search is over.

In order: `tuning` (the constants that steer it), `state` (incumbent, refuted and open IIs),
`attempt` and `kms` (one II); the phases of the walk over IIs: `windows` (rectangles of a large
array), `climb` (by a strategy's own steps), `negotiation`, `warm_start` (of small graphs);
`strategy` (steps and phases as rows, and the walk that reads them), `portfolio` (the rows).
"""
