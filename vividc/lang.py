"""Operations of the array that Python has no words for, for use in kernels and on the host."""

from vividc.frontend.lang import bitcast_f32, bitcast_i32, fma, mulhi, mulhi_u
from vividc.frontend.lang_formats import (
    Narrow,
    bits_of,
    e5m2,
    e5m2_from_bits,
    fp8,
    fp8_from_bits,
    fp16,
    fp16_from_bits,
)
from vividc.frontend.lang_lanes import (
    e5m2_dot,
    e5m2_max,
    e5m2_word,
    fp8_dot,
    fp8_max,
    fp8_word,
    fp16_dot,
    fp16_max,
    fp16_word,
)

__all__ = [
    "Narrow",
    "bitcast_f32",
    "bitcast_i32",
    "bits_of",
    "e5m2",
    "e5m2_dot",
    "e5m2_from_bits",
    "e5m2_max",
    "e5m2_word",
    "fma",
    "fp8",
    "fp8_dot",
    "fp8_from_bits",
    "fp8_max",
    "fp8_word",
    "fp16",
    "fp16_dot",
    "fp16_from_bits",
    "fp16_max",
    "fp16_word",
    "mulhi",
    "mulhi_u",
]
