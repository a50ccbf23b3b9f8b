"""The precision policy: what a user writes, and what it means."""

from __future__ import annotations

import pytest

from tests.ssa.support import function
from vividc.errors import ArgumentError
from vividc.formats import E4M3, E5M2, F16
from vividc.machine.opcodes import Opcode
from vividc.ssa.formats.precision import (
    arithmetic_format,
    formats_of,
    idle_names,
    parse_precision,
)


def test_functions_have_formats_of_their_own_or_of_all() -> None:
    policy = parse_precision({"all": "fp8", "exp": "fp16", "fma": "fp32"})
    assert policy == (("exp", "fp16"), ("exp2", "fp8"))
    assert formats_of(policy) == {Opcode.EXP: F16, Opcode.EXP2: E4M3}
    assert arithmetic_format(policy) is None
    assert arithmetic_format(parse_precision({"fma": "e5m2"})) is E5M2
    assert parse_precision(None) == ()


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        ({"sin": "fp8"}, "no precision can be set for 'sin'.*exp, exp2, fma; `all` is each"),
        ({"exp": "fp9"}, "'fp9' of exp is not a format.*fp32, fp16, fp8, e5m2"),
        ({"exp": 8}, "8 of exp is not a format"),
        ("fp8", "a precision policy cannot be 'fp8'.*write precision="),
    ],
)
def test_other_policies_are_refused(wanted: object, message: str) -> None:
    with pytest.raises(ArgumentError, match=f"(?s){message}"):
        parse_precision(wanted)  # type: ignore[arg-type]


def test_what_the_function_does_not_have_is_idle() -> None:
    given = function("b0:\n  %0 f32 = exp2 0x3f800000\n  %1 f32 = fsub %0, %0\n  return\n")
    assert idle_names({"exp": "fp8", "exp2": "fp8", "fma": "fp8", "all": "fp8"}, given) == ("exp",)
    assert idle_names(None, given) == ()
