"""What is made of the samples that survive, by numba."""

from __future__ import annotations

import numpy as np
import pytest

from tests.render.array.by_numba import Host, as_float8
from vividc.render.array.pieces import RAYS, Rays, Survivors
from vividc.render.array.records import Kept

KERNEL = "render/instant_ngp:colour_inputs_fp8"


@pytest.mark.parametrize("width", [4, 6])
def test_words_of_rays_and_outputs_of_survivors_in_blocks(width: int) -> None:
    """More of a piece than a launch has room for, none of another, all and one of others."""
    rng = np.random.default_rng(3)
    sizes, counts = (700, 40, 16, 90), (500, 0, 16, 1)
    outputs = rng.standard_normal((-(-sum(sizes) // 16), width, 2 * 16)).astype(np.float16)
    blocks, scale = outputs.view(np.uint32), np.float32(8)
    rows = as_float8(blocks, scale)
    of_rays = rng.integers(0, 1 << 32, (len(sizes) * RAYS, 4), dtype=np.uint32)
    pieces, expected, first, samples = [], [], 0, 0
    for number, (size, count) in enumerate(zip(sizes, counts, strict=True)):
        before = min(40, size - count)  # none of these survives
        places = np.sort(before + rng.choice(size - before, count, replace=False)).astype(np.uint32)
        span = slice(first, first)
        if count:
            span = slice(first + int(places[0]), first + int(places[-1]) + 1)
        rays = rng.integers(0, RAYS, count, dtype=np.uint32)
        items = (places << 22 | rays << 16 | 77).view(np.int32)
        pieces.append(
            Survivors(
                *(number, number * RAYS, 0, True, samples, items),
                *(slice(first, first + size), span, np.zeros(count, np.float32)),
            )
        )
        whole = np.concatenate((of_rays[number * RAYS + rays], rows[first + places]), axis=1)
        filled = np.pad(whole, ((0, -count % 16), (0, 0)), mode="edge") if count else whole
        expected.append(filled.reshape(-1, 16, 4 + width // 2).transpose(0, 2, 1))
        first, samples = first + size, samples + count
    table = np.zeros((len(of_rays), 3), np.float32)
    rays_of_batch = Rays(table, table[:, 0], np.zeros(len(table), np.uint32))
    kept = Kept(Host(), np.zeros(16, np.float32), rays_of_batch, pieces)
    assert [some.stop - some.start for some in kept.blocks] == [32, 0, 1, 1]
    found = np.zeros((34, 4 + width // 2, 16), np.uint32)
    kept.fill_blocks(KERNEL, blocks, of_rays, found, {"scale": scale})
    np.testing.assert_array_equal(found, np.concatenate(expected))
