"""The models that are marched through.

In order: `field` (what is asked of a model); `hash_encoding` and `instant_ngp`; `factors` and
`tensorf`; `grouping` and `kilonerf`, with float8 operands `kilonerf_words` and `kilonerf_fp8`.
"""
