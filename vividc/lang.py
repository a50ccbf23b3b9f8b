"""Operations of the array that Python has no words for, for use in kernels and on the host."""

from vividc.frontend.lang import bitcast_f32, bitcast_i32, fma, mulhi, mulhi_u

__all__ = ["bitcast_f32", "bitcast_i32", "fma", "mulhi", "mulhi_u"]
