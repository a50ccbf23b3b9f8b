"""The models that are marched through.

In order: `field` (what is asked of a model); `hash_encoding` and `instant_ngp`; `factors` and
`tensorf`; `grouping`, KiloNeRF's networks (`kilonerf_half`) in the formats `kilonerf_fp32` and
`kilonerf_fp8` (`kilonerf_fit`, `kilonerf_words`), and `kilonerf`.
"""
