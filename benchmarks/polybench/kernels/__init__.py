"""The kernels of PolyBench 4.2 as a user writes them in Python, in its families; a kernel takes
float32 arrays, or int32 ones, whose shapes are its sizes.

`blas`, `products`, `solvers`, `mining` (data), `medley`, `stencils`; `images` are not PolyBench's.
"""
