"""3D Gaussian Splatting, every stage on the array.

In order: `scene`, `project`, `sort`, `blend`, `frame`; `blend_only` (the host does the rest).
"""
