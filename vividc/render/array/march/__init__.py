"""Ray-marched models: rays, samples, and blocks of pixels shared out among processes.

In order: `bricks`, `fields` (which model is computed how), `marching`, `batches`, `crew` and
`helper`.
"""
