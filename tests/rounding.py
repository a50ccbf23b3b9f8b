"""An oracle of rounding: the nearest of a format's numbers, found among all of them."""

from __future__ import annotations

from bisect import bisect_left
from fractions import Fraction
from functools import cache

from vividc.formats import E4M3, Format, values


@cache
def _numbers(fmt: Format) -> tuple[Fraction, ...]:
    """The numbers from 0 up, and one more: what would follow the largest."""
    found = [Fraction(value) for value in values(fmt)[: fmt.max_code + 1]]
    return (*found, 2 * found[-1] - found[-2])


def nearest(fmt: Format, value: Fraction) -> int:
    """Code of the number nearest to `value`, of two equally near ones the even one."""
    numbers = _numbers(fmt)
    sign, magnitude = (fmt.sign if value < 0 else 0), abs(value)
    above = bisect_left(numbers, magnitude)
    if above == len(numbers):
        code = above - 1
    elif numbers[above] == magnitude:
        code = above
    else:
        low, high = magnitude - numbers[above - 1], numbers[above] - magnitude
        down = low < high or (low == high and above % 2 == 1)
        code = above - 1 if down else above
    if fmt is E4M3:  # no infinity follows its largest number
        code = min(code, fmt.max_code)
    return sign | code
