"""The models that are marched through.

In order: `hash_encoding` and `instant_ngp`; `factors` and `tensorf`; `kilonerf`, with float8
operands `kilonerf_words` and `kilonerf_fp8`.
"""
