"""What no array runs, construct by construct: the message names the line, the thing and a way out.

The kernels and what is said of them are in tests/data/refused, each a body, "!" with the line of
the body and the reason, and "?" with the hint.
"""

from __future__ import annotations

import importlib.util
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from vividc.compiler.driver import lower
from vividc.errors import KernelError, SourceLoc
from vividc.frontend import KernelFunction

DATA = Path(__file__).parent.parent / "data" / "refused"
INTERNALS = re.compile(
    r"NRT|0x[0-9a-f]{4}|_ZN|\$\d|Dispatcher|_dynfunc|no attribute|nocopy|meminfo|Literal|Tuple\("
    r"|array\(\w+, \d|<\w+|unicode_type|numba\.(core|np|cpython)|llvm|bug of vividc|Error\(|%\w"
    r"|omitted|getitem|setitem|getiter|npy_|array_\w+|nopython|Traceback"
)
"""What no user wrote and no user can look up."""


@dataclass(frozen=True)
class Refused:
    body: str
    line: str
    reason: str
    hint: str


def read(name: str) -> list[Refused]:
    entries = (DATA / name).read_text(encoding="utf-8").split("\n\n")
    found = []
    for entry in entries:
        match = re.fullmatch(r"(.+)\n! (\w+) (.+)\n\? (.+)", entry.strip("\n"), re.DOTALL)
        assert match is not None, entry
        found.append(Refused(*match.groups()))
    return found


REFUSED = [*read("language.txt"), *read("numpy.txt")]
FEW = range(0, len(REFUSED), 5)


@pytest.fixture(scope="module")
def kernels(tmp_path_factory: pytest.TempPathFactory) -> list[Callable[..., Any]]:
    """All as functions of one module."""
    path = tmp_path_factory.mktemp("refused") / "refused_kernels.py"
    text = (DATA / "helpers.txt").read_text(encoding="utf-8")
    for number, refused in enumerate(REFUSED):
        lines = "".join(f"    {line}\n" if line else "\n" for line in refused.body.split("\n"))
        text += f"\n\ndef k{number}(x, n):\n{lines}"
    path.write_text(text, encoding="utf-8")
    spec = importlib.util.spec_from_file_location("refused_kernels", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return [getattr(module, f"k{number}") for number in range(len(REFUSED))]


def check(function: Callable[..., Any], refused: Refused) -> None:
    with pytest.raises(KernelError) as caught:
        lower(KernelFunction(function, "(float32[::1], int32)", None))
    error = caught.value
    assert (error.reason, error.hint) == (refused.reason, refused.hint)
    assert isinstance(error.loc, SourceLoc)
    line = error.loc.line - function.__code__.co_firstlineno
    if refused.line == "helper":
        assert line < 0
    else:
        assert line == int(refused.line)


@pytest.mark.parametrize("number", FEW)
def test_what_no_array_runs(number: int, kernels: list[Callable[..., Any]]) -> None:
    check(kernels[number], REFUSED[number])


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::numba.core.errors.NumbaTypeSafetyWarning")
@pytest.mark.parametrize("number", set(range(len(REFUSED))) - set(FEW))
def test_all_that_no_array_runs(number: int, kernels: list[Callable[..., Any]]) -> None:
    check(kernels[number], REFUSED[number])


def test_no_message_holds_what_no_user_wrote() -> None:
    for refused in REFUSED:
        assert not INTERNALS.search(f"{refused.reason}\n{refused.hint}"), refused
        assert len(refused.reason) < 160, refused
