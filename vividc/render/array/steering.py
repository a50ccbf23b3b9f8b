"""Sizes that steer the stages, each with what it was measured on. No picture depends on any.

What a launch has room for is not here: that is computed (`Device.fitting`). Measured on `mic` in
FP8 with culling on `vivid`, of 3DGS in FP32: cycles at 800x800, of a ray-marched method's frame a
twentieth of the blocks of pixels, unless another size is named.
"""

from __future__ import annotations

from typing import Final

BLOCKS_AT_ONCE: Final = 512
"""Blocks of pixels of a batch, on average and at most. Not measured: what helpers share."""
FIRST_BATCH: Final = 0.5
"""Steps of the first batch, as a share of another's: helpers wait for it. Not measured."""
STEPS_AT_ONCE: Final = (8, 4, 2, 1)
"""Steps of all rays that are looked at before their cells, the best first that there is room for:
loops have to fill. Of `mic` there is room for no more than four.
"""
LEAST_PARTS: Final = 3
"""Of those steps that there is room to list samples of, as a launch that goes on waits for all
others: with 2 marching takes 14 % more for Instant-NGP and 8 % for TensoRF, where it then looks at
eight steps.
"""
LAUNCH_SAMPLES: Final = 40
"""What a launch over a piece costs, in samples, when launches are dealt out. KiloNeRF: with 64
transmittance takes 1.7 % more.
"""
GATHERED_ROWS: Final = 128
"""Of a launch that gathers rows by DMA, at most."""
LAUNCHES_OF_BLOCKS: Final = 4
"""That a tile gets at least of a kernel over blocks, to hide transfers behind. Instant-NGP: a frame
takes the same within 0.03 % with 2 and with 8.
"""
TPU_SAMPLES: Final = 2048
"""From which on layers that the tiles have a kernel for may run in a TPU-like mode: its programs
take the host seconds to make.
"""
NGP_BATCH: Final = 131_072
"""Samples of Instant-NGP that go through its stages together: a frame takes 1.1 % more with half as
many.
"""
TENSORF_BATCH: Final = 65_536
"""The same of TensoRF: with fewer 7.8 frames a second in place of 8.7, when it was chosen."""
SAMPLES_A_CELL: Final = 8
"""For which a launch of TensoRF's factors has room for one cell: blocks of pixels have 8 to 20 in
one, ordered by step.
"""
GROUPED: Final = (256, 720)
"""Samples of a piece of KiloNeRF, at least and at most: the fewer, the more launches; with the
least, networks are counted a range after the other. Blocks of pixels have 252 on average: no frame
differs from 480 on.
"""
SORTED_CHUNK: Final = 1024
"""Entries that a tile sorts at once: 3DGS at 800x800 takes 18 % more for sorting with 512."""
CHUNKS_A_TILE: Final = 6
"""That the lists of rows of screen tiles are cut into at least. Binning of 3DGS, in thousands of
cycles at 800x800 and 200x200: 326 and 172 with chunks as long as they may be; 309 and 158 with 4;
302 and 159 with 6.
"""
SHORTEST_CHUNK: Final = 64
"""Entries of those chunks at least. Not measured: a launch costs as much as tens of entries."""
RUN_ENTRIES: Final = 32
"""What a run of blending costs beside its entries, as entries in a row of blocks: some 2,000
cycles. Blending takes 5.8 % more with 64, and the same with 16.
"""
PARTS_OF_A_SHARE: Final = (1, 2, 4, 8)
"""Screen tiles are cut where they are more than such a part of what a tile has to do. At 100x100
blending takes 3.0 % more with the first two.
"""
WORTH_CUTTING: Final = 0.9
"""Of the longest share that is expected without cuts, to cut at all. At 200x200 blending takes
6.8 % less than with 0.8, in other sizes and scenes the same; with 1 up to 4.7 % more.
"""
