"""The light that reaches samples, and the picture: as numba and the array run the kernels of each
kind of results, against sums in float64.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pytest

from tests.render.array.by_numba import Host
from vividc.render.array import Device
from vividc.render.array.march.light import light_along, picture_of
from vividc.render.array.pieces import RAYS, Piece, Survivors, pieces_of
from vividc.render.array.records import (
    Results,
    blocks_of_samples,
    of_samples,
    place_in_block,
)

LIMITS = np.array([1e-3, 2e-3], np.float32)
STEP, MOST, SHIFT = np.float32(0.03), np.float32(4), np.float32(-1.5)
COUNTS = (200, 0, 1, 90)
"""Samples of blocks of pixels."""
COUNT = sum(COUNTS)
RNG = np.random.default_rng(11)
EXPONENTS = RNG.normal(1, 2, COUNT).astype(np.float16).astype(np.float32)
SUMS = RNG.normal(1.5, 4, (3, COUNT)).astype(np.float32)
LOGITS = RNG.normal(0, 4, (COUNT, 3)).astype(np.float16).astype(np.float32)
LOGITS[::17] *= 30  # beyond what the exponential function is clamped to
ITEMS = RNG.integers(0, 12, COUNT, dtype=np.int32) << 16 | np.arange(COUNT, dtype=np.int32)


def in_words(rows: np.ndarray) -> np.ndarray:
    """Numbers [F, n] as words of two float16 in blocks of 16 samples, [B, F / 2, 16]."""
    padded = np.pad(rows, ((0, len(rows) % 2), (0, -rows.shape[1] % 16)), constant_values=3)
    halves = padded.reshape(-1, 2, padded.shape[1]).transpose(0, 2, 1).astype(np.float16)
    words = np.ascontiguousarray(halves).view(np.uint32)[:, :, 0]
    return np.ascontiguousarray(words.reshape(len(words), -1, 16).transpose(1, 0, 2))


def in_numbers(rows: np.ndarray) -> np.ndarray:
    """The same as float32, [B, F, 16]."""
    padded = np.pad(rows, ((0, 0), (0, -rows.shape[1] % 16)), constant_values=3)
    return np.ascontiguousarray(padded.reshape(len(rows), -1, 16).transpose(1, 0, 2))


def exponents(kernel: str, blocks: np.ndarray) -> Results:
    more = {"most": MOST, "step": STEP}
    return Results(
        f"transmittance_of_{kernel}",
        {"x": blocks_of_samples(blocks[:, 0])},
        lambda piece: {**place_in_block(piece), **more},
    )


def in_order_of_groups(pieces: Sequence[Piece], rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows of samples in another order in each piece, and their places in it."""
    mixed, places = np.empty_like(rows), np.zeros(len(rows), np.int32)
    for piece in pieces:
        order = places[piece.samples]
        order[:] = np.random.default_rng(piece.first).permutation(len(piece))
        mixed[piece.samples][order] = rows[piece.samples]
    return mixed, places


def densities_in_groups(pieces: Sequence[Piece]) -> Results:
    mixed, places = in_order_of_groups(pieces, np.exp(np.minimum(EXPONENTS, MOST)) * STEP)
    reads = {"thickness": of_samples(mixed), "places": of_samples(places)}
    return Results("transmittance_in_groups", reads)


def sigmoids(kernel: str, blocks: np.ndarray) -> Results:
    return Results(f"accumulate_{kernel}", {"x": blocks_of_samples(blocks)}, place_in_block)


def colours_in_groups(pieces: Sequence[Piece], logits: np.ndarray) -> Results:
    rgb = (1 / (1 + np.exp(-logits.astype(np.float64)))).astype(np.float32)
    mixed, places = in_order_of_groups(pieces, rgb)
    reads = {"colours": of_samples(mixed), "places": of_samples(places)}
    return Results("accumulate_in_groups", reads)


@dataclass(frozen=True)
class Kind:
    thickness: np.ndarray
    densities: Callable[[Sequence[Piece]], Results]
    colours: Callable[[Sequence[Piece], np.ndarray], Results]


OF_EXPONENTS = np.exp(np.minimum(EXPONENTS, MOST).astype(np.float64)) * STEP
OF_SUMS = np.log1p(np.exp(SHIFT + SUMS.astype(np.float64).sum(axis=0))) * STEP
KINDS = {
    "groups": Kind(OF_EXPONENTS, densities_in_groups, colours_in_groups),
    "float32": Kind(
        OF_EXPONENTS,
        lambda _: exponents("exponents", in_numbers(EXPONENTS[None])),
        lambda _, logits: sigmoids("sigmoids", in_numbers(logits.T)),
    ),
    "fp8": Kind(
        OF_EXPONENTS,
        lambda _: exponents("exponents_fp8", in_words(np.stack((EXPONENTS, -EXPONENTS)))),
        lambda _, logits: sigmoids("sigmoids_fp8", in_words(logits.T)),
    ),
    "sums": Kind(
        OF_SUMS,
        lambda _: Results(
            "transmittance_of_sums",
            {"sums": lambda piece: SUMS[:, piece.samples]},
            lambda _: {"shift": SHIFT, "step": STEP},
        ),
        lambda _, logits: sigmoids("sigmoids", in_numbers(logits.T)),
    ),
}


def lit(
    device: Device, kind: Kind, most: int, keep_all: bool = False
) -> tuple[list[Survivors], np.ndarray, np.ndarray]:
    """Survivors of pieces of at most so many samples, the light behind them, and the picture."""
    ends = np.cumsum(COUNTS)
    blocks = [
        [ITEMS[end - count : end]] * bool(count) for end, count in zip(ends, COUNTS, strict=True)
    ]
    pieces = list(pieces_of(blocks, most))
    left = np.ones(len(COUNTS) * RAYS, np.float32)
    survivors = light_along(device, pieces, kind.densities(pieces), LIMITS, left, keep_all)
    colours = kind.colours(survivors, LOGITS[numbers_of(survivors)])
    return survivors, left, picture_of(device, survivors, colours, left)


def numbers_of(survivors: Sequence[Survivors]) -> np.ndarray:
    """Which of all samples they are."""
    every = [one.places.start + (one.items.view(np.uint32) >> 22) for one in survivors]
    return np.concatenate(every).astype(np.int64)


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_light_and_picture_are_those_of_sums_in_float64(kind: Kind) -> None:
    survivors, left, picture = lit(Host(), kind, 37)
    assert any(one.first % 16 for one in survivors)
    light, sums = np.ones(len(left)), np.zeros((len(left), 3))
    weights, rgb = np.zeros(COUNT), 1 / (1 + np.exp(-LOGITS.astype(np.float64)))
    blocks = np.repeat(np.arange(len(COUNTS)), COUNTS)
    for number, ray in enumerate(blocks * RAYS + (ITEMS >> 16)):
        alpha = 1 - np.exp(-kind.thickness[number])
        if light[ray] >= LIMITS[0] and light[ray] * alpha > LIMITS[1]:
            weights[number] = light[ray] * alpha
            sums[ray] += weights[number] * rgb[number]
        light[ray] *= 1 - alpha
    listed = numbers_of(survivors)
    np.testing.assert_array_equal(listed, np.flatnonzero(weights))
    assert 100 < len(listed) < 0.8 * COUNT
    for one in filter(len, survivors):
        own = numbers_of([one])
        assert one.span == slice(own[0], own[-1] + 1)
    found = np.concatenate([one.weights for one in survivors])
    np.testing.assert_allclose(found, weights[listed], rtol=1e-4)
    np.testing.assert_allclose(left, light, rtol=1e-4, atol=1e-6)
    np.testing.assert_allclose(picture[:, 3], left)
    np.testing.assert_allclose(picture[:, :3], sums + light[:, None], rtol=1e-4)


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_pieces_give_what_the_whole_gives(kind: Kind) -> None:
    """And what is listed of little weight, or behind all light, changes nothing."""
    whole, *expected = lit(Host(), kind, 1000)
    cut, *found = lit(Host(), kind, 37)
    assert len(cut) > 2 * len(whole)
    late, *every = lit(Host(), kind, 37, keep_all=True)
    assert sum(map(len, late)) == COUNT
    np.testing.assert_array_equal(numbers_of(cut), numbers_of(whole))
    for one, same, again in zip(expected, found, every, strict=True):
        np.testing.assert_array_equal(one, same)
        np.testing.assert_array_equal(one, again)


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_the_array_gives_what_numba_gives(kind: Kind, device: Device) -> None:
    by_array, *found = lit(device, kind, 37)
    by_numba, *expected = lit(Host(), kind, 37)
    for mine, theirs in zip(by_array, by_numba, strict=True):
        np.testing.assert_array_equal(mine.items, theirs.items)
        np.testing.assert_allclose(mine.weights, theirs.weights, rtol=1e-5)
    for one, same in zip(found, expected, strict=True):
        np.testing.assert_allclose(one, same, rtol=1e-5, atol=1e-7)
    assert list(device.ledger.stages) == ["transmittance", "accumulation"]
