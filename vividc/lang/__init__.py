"""Operations of the array that Python has no words for, for use in kernels and on the host.

In order: `numba_words` (numba's names as an author writes them), `operations`, `host` (what they
compute on the host), `formats` and `lanes`, `numba_types` (float16 and float8 for numba).
"""

from vividc.lang.formats import (
    Narrow,
    bits_of,
    e5m2,
    e5m2_from_bits,
    fp8,
    fp8_from_bits,
    fp16,
    fp16_from_bits,
)
from vividc.lang.lanes import (
    dot_e5m2,
    dot_fp8,
    dot_fp16,
    max_e5m2,
    max_fp8,
    max_fp16,
    pack_e5m2,
    pack_fp8,
    pack_fp16,
)
from vividc.lang.operations import bitcast_f32, bitcast_i32, fma, mulhi, mulhi_u

__all__ = [
    "Narrow",
    "bitcast_f32",
    "bitcast_i32",
    "bits_of",
    "dot_e5m2",
    "dot_fp8",
    "dot_fp16",
    "e5m2",
    "e5m2_from_bits",
    "fma",
    "fp8",
    "fp8_from_bits",
    "fp16",
    "fp16_from_bits",
    "max_e5m2",
    "max_fp8",
    "max_fp16",
    "mulhi",
    "mulhi_u",
    "pack_e5m2",
    "pack_fp8",
    "pack_fp16",
]
