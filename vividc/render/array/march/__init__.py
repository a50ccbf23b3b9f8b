"""Ray-marched models: rays, samples, and blocks of pixels shared out among processes.

In order: `bricks`, `depths` (which blocks see any), `fields` (which model is computed how),
`light`, `marching`, `batches`, `crew` and `helper`.
"""
