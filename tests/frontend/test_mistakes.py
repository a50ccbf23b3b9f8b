"""What is not Python for arrays: one message with the line, the construct, and a way out."""

from __future__ import annotations

import re

import pytest

from tests.frontend import misled, mistakes
from tests.frontend.mistake_registry import MISTAKES
from vividc.compiler.driver import lower
from vividc.errors import KernelError, SourceLoc
from vividc.frontend import KernelFunction

INTERNALS = re.compile(
    r"NRT|0x[0-9a-f]{4}|_ZN|\$\d|CPUDispatcher|_dynfunc|no attribute 'args'|attempt_nocopy|meminfo"
)


@pytest.mark.filterwarnings("ignore::vividc.VividcWarning")
@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_gets_one_message(name: str) -> None:
    mistake = MISTAKES[name]
    kernel = KernelFunction(mistake.function, "(float32[::1], int32)", None)
    with pytest.raises(KernelError, match=mistake.reason) as caught:
        lower(kernel)
    error = caught.value
    assert isinstance(error.loc, SourceLoc)
    assert error.loc.file in (mistakes.__file__, misled.__file__)
    assert mistake.line is None or error.loc.line == mistake.line
    assert error.hint, f"no way out: {error}"
    assert re.search(mistake.hint, error.hint)
    assert "Traceback" not in str(error)
    assert not INTERNALS.search(str(error)), "numba's internals"
    assert len(str(error)) < 500, "numba's text is passed on"
