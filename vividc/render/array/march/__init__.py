"""Ray-marched models: rays, samples, and blocks of pixels shared out among processes.

In order: `bricks`, `field` (what is asked of a model), `fields`, `marching`, `batches`, `crew` and
`helper`.
"""
