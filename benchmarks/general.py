"""The kernels of `kernels/general/`, with small inputs; seeds are fixed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.workloads import Arguments, Workload

Maker = Callable[[np.random.Generator], Arguments]


def _floats(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return rng.standard_normal(shape).astype(np.float32)


def _ints(rng: np.random.Generator, low: int, high: int, *shape: int) -> np.ndarray:
    return rng.integers(low, high, shape, dtype=np.int32)


def _words(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return rng.integers(0, 1 << 32, shape, dtype=np.uint32)


def _signed_words(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return _words(rng, *shape).view(np.int32)


def _zeros(*shape: int) -> np.ndarray:
    return np.zeros(shape, np.int32)


def _blank(*shape: int) -> np.ndarray:
    return np.zeros(shape, np.float32)


def _csr(rng: np.random.Generator, rows: int, columns: int) -> tuple[np.ndarray, np.ndarray]:
    """Row starts and columns of a random pattern, some rows empty."""
    lengths = rng.integers(0, 6, rows)
    start = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int32)
    return start, _ints(rng, 0, columns, int(start[-1]))


def _spmv(rng: np.random.Generator) -> Arguments:
    start, column = _csr(rng, 24, 30)
    return start, column, _floats(rng, len(column)), _floats(rng, 30), _blank(24)


def _bfs(rng: np.random.Generator) -> Arguments:
    start, neighbour = _csr(rng, 40, 40)
    return start, neighbour, np.int32(3), np.full(40, -1, np.int32), _zeros(40)


def _bellman_ford(rng: np.random.Generator) -> Arguments:
    distance = np.full(20, 1 << 20, np.int32)
    distance[0] = 0
    edges = (_ints(rng, 0, 20, 60), _ints(rng, 0, 20, 60), _ints(rng, 0, 50, 60))
    return *edges, distance


def _distances(rng: np.random.Generator, n: int) -> np.ndarray:
    distance = _ints(rng, 1, 100, n, n)
    distance[rng.integers(0, 2, (n, n)) == 0] = 1 << 20
    np.fill_diagonal(distance, 0)
    return distance


def _find_text(rng: np.random.Generator) -> Arguments:
    text = _ints(rng, 0, 3, 200)
    return text, text[150:156].copy()


def _lower(rng: np.random.Generator, n: int) -> np.ndarray:
    return np.tril(_floats(rng, n, n) * np.float32(0.3))


def _follow(rng: np.random.Generator) -> Arguments:
    return (np.roll(np.arange(64, dtype=np.int32), -11)[rng.permutation(64)],)


def _volume(rng: np.random.Generator) -> Arguments:
    volume = _ints(rng, 0, 90, 5, 6, 7)
    volume[3, 2, 4] = 100
    return volume, np.int32(100)


def _virtual_machine(_: np.random.Generator) -> Arguments:
    """Multiplies 9 by 7: adds memory[1] to memory[2], memory[0] times."""
    code = [2, 2, 4, 1, 3, 2, 2, 0, 5, 0, 3, 0, 6, 0, 2, 2, 0, 0]
    return np.array(code, np.int32), np.array([7, 9, 0], np.int32), np.int32(500)


def _mandelbrot(_: np.random.Generator) -> Arguments:
    real = np.linspace(-2, 0.5, 10, dtype=np.float32)
    return real, np.linspace(-1, 1, 8, dtype=np.float32), np.int32(30), _zeros(8, 10)


def _table(_: np.random.Generator) -> np.ndarray:
    table = np.arange(256, dtype=np.uint32)
    for _bit in range(8):
        table = np.where(table & 1, (table >> 1) ^ np.uint32(0xEDB88320), table >> 1)
    return table


def _bytes(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return rng.integers(0, 256, shape, dtype=np.uint8)


def _halves(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return rng.integers(-(1 << 15), 1 << 15, shape, dtype=np.int16)


def _flags(rng: np.random.Generator, share: float, *shape: int) -> np.ndarray:
    return rng.random(shape) < share


def _small(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return rng.integers(-128, 128, shape, dtype=np.int8)


def _runs(rng: np.random.Generator) -> Arguments:
    data = np.repeat(_bytes(rng, 40), rng.integers(1, 9, 40))
    return data, np.zeros(2 * len(data), np.uint8)


def _text(_: np.random.Generator) -> Arguments:
    return (np.frombuffer("Größe: 3 m², Preis: 5 € — 漢字 🙂 ".encode() * 6, np.uint8).copy(),)


def _region(rng: np.random.Generator) -> Arguments:
    region = np.zeros((10, 12), bool)
    region[4, 5] = True
    return region, _flags(rng, 0.7, 10, 12)


def _base64(rng: np.random.Generator) -> Arguments:
    alphabet = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"
    return _bytes(rng, 91), np.frombuffer(alphabet, np.uint8).copy(), np.zeros(120, np.uint8)


LINEAR_ALGEBRA: dict[str, Maker] = {
    "gemm": lambda r: (_floats(r, 8, 9), _floats(r, 9, 7), _floats(r, 8, 7)),
    "gemm_rows": lambda r: (
        _ints(r, -99, 99, 8, 9),
        _ints(r, -99, 99, 9, 7),
        _ints(r, -99, 99, 8, 7),
    ),
    "gemv": lambda r: (
        np.float32(1.5),
        _floats(r, 16, 20),
        _floats(r, 20),
        np.float32(-0.5),
        _floats(r, 16),
    ),
    "trmv": lambda r: (_floats(r, 16, 16), _floats(r, 16)),
    "solve_unit_lower": lambda r: (_lower(r, 16), _floats(r, 16)),
    "outer_product": lambda r: (
        np.float32(0.7),
        _floats(r, 12),
        _floats(r, 17),
        _floats(r, 12, 17),
    ),
    "transpose": lambda r: (_floats(r, 15, 15),),
    "norm_inf": lambda r: (_floats(r, 12, 18),),
    "spmv_csr": _spmv,
}

IMAGE: dict[str, Maker] = {
    "conv2d": lambda r: (_floats(r, 10, 11), _floats(r, 3, 4), _blank(8, 8)),
    "blur3": lambda r: (_ints(r, 0, 256, 12, 14), _zeros(12, 14)),
    "sobel": lambda r: (_ints(r, 0, 256, 12, 14), _zeros(12, 14)),
    "dilate": lambda r: (_ints(r, -9, 256, 7, 9), _zeros(7, 9)),
    "threshold": lambda r: (_ints(r, 0, 256, 300), np.int32(80), np.int32(170)),
    "lookup": lambda r: (_ints(r, 0, 256, 300), _ints(r, 0, 256, 256), _zeros(300)),
    "histogram": lambda r: (_ints(r, 0, 16, 300), _zeros(16)),
    "jacobi": lambda r: (_floats(r, 9, 11), _blank(9, 11), np.int32(3)),
    "gauss_seidel": lambda r: (_floats(r, 9, 11), np.int32(3)),
    "stencil7": lambda r: (_floats(r, 5, 6, 7), _blank(5, 6, 7)),
    "life": lambda r: (_ints(r, 0, 2, 8, 9), _zeros(8, 9)),
}

SIGNALS: dict[str, Maker] = {
    "fir_filter": lambda r: (_floats(r, 80), _floats(r, 9), _blank(80)),
    "biquad": lambda r: (
        _floats(r, 200),
        np.array([0.2, 0.4, 0.2, -0.6, 0.3], np.float32),
        _blank(200),
    ),
    "comb_filter": lambda r: (_floats(r, 200), np.int32(7), np.float32(-0.6)),
    "autocorrelation": lambda r: (_ints(r, -500, 500, 120), _zeros(12)),
    "moving_average": lambda r: (_ints(r, -500, 500, 200), _zeros(200)),
    "envelope": lambda r: (_floats(r, 200), _blank(200)),
    "haar": lambda r: (_ints(r, -500, 500, 64), _zeros(64)),
    "zero_crossings": lambda r: (_floats(r, 200), _zeros(200), np.float32(0.3)),
}

INTEGERS: dict[str, Maker] = {
    "crc32": lambda r: (_words(r, 40),),
    "crc32_table": lambda _: (np.zeros(256, np.uint32),),
    "crc32_by_table": lambda r: (_words(r, 200) & np.uint32(255), _table(r)),
    "adler32": lambda r: (_ints(r, 0, 256, 900),),
    "xorshift32": lambda _: (np.uint32(2463534242), np.zeros(200, np.uint32)),
    "lcg": lambda _: (-1234567890, _zeros(200)),
    "fnv1a": lambda r: (_words(r, 200),),
    "xtea": lambda r: (_words(r, 6), _words(r, 4)),
    "sha256_schedule": lambda r: (_words(r, 64),),
    "popcount": lambda r: (_words(r, 40), _zeros(40)),
    "bit_reverse": lambda r: (_words(r, 100), np.zeros(100, np.uint32)),
    "morton": lambda r: (_words(r, 30), _words(r, 30), np.zeros(30, np.uint32)),
}

SEARCHING: dict[str, Maker] = {
    "insertion_sort": lambda r: (_ints(r, -99, 99, 40),),
    "selection_sort": lambda r: (_floats(r, 30),),
    "bubble_sort": lambda r: (_ints(r, -99, 99, 30),),
    "shell_sort": lambda r: (_ints(r, -99, 99, 60),),
    "heap_sort": lambda r: (_ints(r, -99, 99, 40),),
    "binary_search": lambda r: (np.sort(_ints(r, 0, 200, 90)), _ints(r, 0, 200, 40), _zeros(40)),
    "merge": lambda r: (np.sort(_ints(r, 0, 99, 70)), np.sort(_ints(r, 0, 99, 50)), _zeros(120)),
    "exclusive_scan": lambda r: (_ints(r, -99, 99, 200), _zeros(200)),
    "running_max": lambda r: (_floats(r, 200),),
    "argmax": lambda r: (_floats(r, 200),),
    "find_text": _find_text,
    "compact": lambda r: (_ints(r, -1, 2, 200), _zeros(200)),
    "counting_sort": lambda r: (_ints(r, 0, 20, 120), _zeros(20), _zeros(120)),
    "quickselect": lambda r: (_ints(r, -99, 99, 80), np.int32(31)),
    "pair_with_sum": lambda r: (_ints(r, 0, 10**6, 40), np.int32(-5), _zeros(2)),
}

GRAPHS: dict[str, Maker] = {
    "floyd_warshall": lambda r: (_distances(r, 9),),
    "bellman_ford": _bellman_ford,
    "bfs": _bfs,
    "components": lambda r: (_ints(r, 0, 40, 30), _ints(r, 0, 40, 30), _zeros(40)),
    "longest_common": lambda r: (_ints(r, 0, 4, 18), _ints(r, 0, 4, 22), _zeros(19, 23)),
    "edit_distance": lambda r: (_ints(r, 0, 4, 18), _ints(r, 0, 4, 22), _zeros(23)),
    "knapsack": lambda r: (_ints(r, 1, 20, 10), _ints(r, 1, 99, 10), _zeros(41)),
    "longest_increasing": lambda r: (_ints(r, 0, 99, 40), _zeros(40)),
    "largest_subarray": lambda r: (_ints(r, -99, 99, 200),),
    "matrix_chain": lambda r: (_ints(r, 1, 30, 11), _zeros(10, 10)),
}

CONTROL: dict[str, Maker] = {
    "gcd": lambda r: (_ints(r, 1, 200, 30), _ints(r, 1, 200, 30), _zeros(30)),
    "collatz": lambda r: (_ints(r, 1, 100, 30), _zeros(30)),
    "mandelbrot": _mandelbrot,
    "nested_breaks": lambda r: (_ints(r, -3, 20, 20, 9), np.int32(700)),
    "follow": _follow,
    "first_match": _volume,
    "count_words": lambda r: (
        r.choice(np.array([9, 10, 32, 35, 65, 66, 67], np.int32), 200),
        _zeros(200),
    ),
    "sieve": lambda _: (_zeros(200),),
    "run_lengths": lambda r: (_ints(r, 0, 2, 60), _zeros(60), np.int32(3)),
    "bracket_match": lambda r: (_ints(r, 40, 43, 120), _zeros(120)),
    "queens": lambda _: (_zeros(4),),
    "virtual_machine": _virtual_machine,
}

BYTES_AND_IMAGES: dict[str, Maker] = {
    "grayscale": lambda r: (_bytes(r, 9, 13, 3), np.zeros((9, 13), np.uint8)),
    "gray_histogram": lambda r: (_bytes(r, 11, 17), _zeros(256)),
    "threshold_mask": lambda r: (_bytes(r, 301), np.uint8(99), np.zeros(301, bool)),
    "box_blur": lambda r: (_bytes(r, 9, 15), np.zeros((9, 15), np.uint8)),
    "blend_over": lambda r: (_bytes(r, 203), _bytes(r, 203), _bytes(r, 203)),
    "run_length_encode": _runs,
    "crc8": lambda r: (_bytes(r, 45),),
    "adler32_bytes": lambda r: (_bytes(r, 900),),
    "utf8_length": _text,
    "mix_pcm": lambda r: (_halves(r, 301), _halves(r, 301), np.zeros(301, np.int16)),
    "delta_decode": lambda r: (_halves(r, 301),),
    "sobel_gradients": lambda r: (
        _bytes(r, 8, 13),
        np.zeros((8, 13), np.int16),
        np.zeros((8, 13), np.int16),
    ),
    "grow_region": _region,
    "apply_curve": lambda r: (_bytes(r, 203), _bytes(r, 256)),
    "swap_bytes": lambda r: (_halves(r, 203).view(np.uint16),),
    "base64_encode": _base64,
    "quantised_layer": lambda r: (
        _small(r, 7, 29),
        _small(r, 29),
        _ints(r, -9999, 9999, 7),
        np.int8(7),
        np.zeros(7, np.int8),
    ),
    "loudest": lambda r: (_small(r, 203),),
    "pcm_to_float": lambda r: (_halves(r, 203), np.float32(2**-15), _blank(203)),
}

WIDE_INTEGERS: dict[str, Maker] = {
    "fnv1a_64": lambda r: (_words(r, 100),),
    "splitmix64": lambda _: (0x123456789ABCDEF, np.zeros(100, np.uint32), np.zeros(100, np.uint32)),
    "xorshift64_star": lambda _: (0x9E3779B97F4A7C15, np.zeros(100, np.uint32)),
    "pcg32": lambda _: (0x853C49E6748FEA9B, np.zeros(100, np.uint32)),
    "q31_multiply": lambda r: (_signed_words(r, 100), _signed_words(r, 100), _zeros(100)),
    "dot64": lambda r: (_signed_words(r, 200), _signed_words(r, 200)),
    "squares_until": lambda r: (_ints(r, -(10**6), 10**6, 200), 3 * 10**13),
    "adler32_lazy": lambda r: (_words(r, 200) & np.uint32(255),),
    "montgomery": lambda r: (
        _words(r, 100) % np.uint32(998244353),
        np.uint32(998244353),
        np.uint32(998244351),
        np.zeros(100, np.uint32),
    ),
    "power_modulo_wide": lambda _: (123456789012, 10**15 + 7),
    "rolling_hash": lambda r: (_words(r, 60) & np.uint32(127),),
    "morton64": lambda r: (
        _words(r, 10),
        _words(r, 10),
        np.zeros(10, np.uint32),
        np.zeros(10, np.uint32),
    ),
    "gcd64": lambda _: (2**40 * 3 * 7 * 11, 2**33 * 9 * 49),
    "integer_root": lambda _: (np.int32(40000),),
}

NUMBER_THEORY: dict[str, Maker] = {
    "gcd_by_remainder": lambda r: (_ints(r, -999, 999, 30), _ints(r, -999, 999, 30), _zeros(30)),
    "gcd_of_library": lambda r: (_ints(r, -999, 999, 30), _ints(r, -999, 999, 30), _zeros(30)),
    "digit_sums": lambda r: (_words(r, 30), _zeros(30)),
    "count_primes": lambda _: (np.uint32(100),),
    "power_modulo": lambda r: (_ints(r, -9999, 9999, 20), _ints(r, 0, 9999, 20), _zeros(20)),
    "lcg_modulo": lambda _: (np.uint32(12345), np.uint32(65521), np.zeros(50, np.uint32)),
    "civil_from_days": lambda r: (_ints(r, -(10**6), 10**6, 30), _zeros(30, 3)),
    "digits_in_base": lambda r: (_ints(r, -9999, 9999, 10), np.int32(7), _zeros(10, 6)),
    "longest_collatz": lambda _: (np.int32(20),),
    "isbn13_check": lambda r: (_ints(r, 0, 10, 12, 12), _zeros(12)),
    "modular_inverse": lambda r: (_ints(r, -9999, 9999, 20), np.int32(1009), _zeros(20)),
    "fibonacci_modulo": lambda _: (np.int32(100), np.uint32(1000)),
    "bit_counts": lambda r: (_words(r, 100), _zeros(100)),
    "bin_counts": lambda r: (_ints(r, -500, 500, 100), np.int32(37), _zeros(16)),
}

FAMILIES = {
    "linear_algebra": LINEAR_ALGEBRA,
    "image": IMAGE,
    "signals": SIGNALS,
    "integers": INTEGERS,
    "wide_integers": WIDE_INTEGERS,
    "searching": SEARCHING,
    "graphs": GRAPHS,
    "control": CONTROL,
    "bytes_and_images": BYTES_AND_IMAGES,
    "number_theory": NUMBER_THEORY,
}

WORKLOADS = tuple(
    Workload(name, maker, f"general/{family}")
    for family, makers in FAMILIES.items()
    for name, maker in makers.items()
)
