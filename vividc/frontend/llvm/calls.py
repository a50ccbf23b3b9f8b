"""Names of calls that pass through LLVM: what they mean is expanded afterwards."""

from __future__ import annotations

_FLAG = "the array has no exceptions: return or store a flag instead"


_RAISES = (
    ("axis", "name an axis that the array has"),
    ("division", "test the divisor before"),
    ("truth value", "ask for one element, x[0] > 0, or for some, (x > 0).any()"),
    ("item()", "take an element: x[0]"),
)


def hint_of_raise(what: str) -> str:
    """What to write instead of what raises `what`, an exception's name and text."""
    return next((hint for text, hint in _RAISES if text in what), _FLAG)


def has_hint(what: str) -> bool:
    """Whether there is something to write instead of what raises `what`."""
    return any(text in what for text, _ in _RAISES)


ALLOCATE = "vividc.allocate "


COPY = "a temporary copy"
"""Stands for the element type of an allocation in bytes, whose accesses tell the type."""


AS_NEEDED = -1
"""Stands for the number of elements of an array that calls of `FITS` tell."""


FITS = "vividc.fits "
"""Callees that tell whether an array made `AS_NEEDED` holds so many elements."""


MOST_NEEDED = 1024
"""Elements of a list whose length nothing known at launch bounds."""


OVERFLOW = f"a list of more than {MOST_NEEDED} elements, where nothing bounds its length"
"""What is raised where a list does not fit."""


TABLE = "vividc.table "


PICK = "vividc.pick "


FLOOR_PREFIX = "vividc.floor "
"""Callees that divide as Python does: with "sdiv", "srem", "udiv" or "urem" of i64; by zero 0."""


RAISE_PREFIX = "vividc.raise "
USER_PREFIX = "vividc.user raise "
"""Callees that raise: numba's functions, and a `raise` or `assert` of the user's, whose text is
percent-encoded.
"""

TRAP_PREFIX = "vividc.trap "
"""As a raise, but the kernel goes on behind it: no branch leaves its loops."""


RETURNED = "vividc.returned "
"""Callees that are told a part of what the kernel returns: a leaf's number and its type; of an
array the pointer, then shape and strides in bytes; of a scalar its value.
"""


RETURNED_ARRAY = " array"
"""Ends the names of those that are told an array."""


OVERLAP = "vividc.overlap"


PITCH = "vividc.pitch "
"""The dimension of a parameter, as its elements are addressed: its name, ".", the axis."""
