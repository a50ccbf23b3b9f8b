"""3D Gaussian Splatting in float32.

In order: `spherical_harmonics`, `splat` (projection, lists, sorting), `blocks` and `block_cull`,
`blend_reference`.
"""
