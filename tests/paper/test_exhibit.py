"""What is said of a figure beside the paper's."""

from __future__ import annotations

import pytest

from vividc.errors import InternalError
from vividc.paper.exhibit import Theirs, judged, missing


@pytest.mark.parametrize(
    ("ours", "theirs", "most", "verdict"),
    [
        (1.34, 1.34, False, "reproduced"),
        (1.21, 1.34, False, "reproduced"),
        (1.20, 1.34, False, "different"),
        (1.48, 1.34, False, "different"),
        (15.0, (16.5, 62.1), False, "reproduced"),
        (68.0, (16.5, 62.1), False, "reproduced"),
        (14.0, (16.5, 62.1), False, "different"),
        (-0.09, 0.49, True, "reproduced"),
        (-0.09, 0.49, False, "different"),
        (0.55, 0.49, True, "different"),
        (3.0, None, False, "not reproducible here"),
        (None, 3.0, False, "not measured"),
    ],
)
def test_verdicts(ours: float | None, theirs: Theirs, most: bool, verdict: str) -> None:
    line = judged("a figure", ours, theirs, "x", "a reason", most=most)
    assert line.verdict == verdict
    assert line.because == ("" if verdict == "reproduced" else "a reason")


def test_what_nothing_here_can_give_says_why() -> None:
    line = missing("a figure", 14.7, "x", "no such platform here")
    assert (line.ours, line.verdict) == (None, "not reproducible here")
    assert line.because == "no such platform here"


def test_a_difference_needs_a_reason() -> None:
    with pytest.raises(InternalError, match="no reason"):
        judged("a figure", 1.0, 1.0, "x", "")
