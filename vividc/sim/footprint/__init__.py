"""Which bytes iterations of a parallel loop touch: `footprint`, `coverage`."""
