"""Before-and-after cases of passes: text files beside the tests, as FileCheck's are.

``test_simplify.py`` reads ``simplify.cases``, whose cases look so::

    == a sum with zero is its operand
    b0:
      %0 i32 = add $"n", 0x00000000
      return %0
    -->
    b0:
      return $"n"

The first line names the rule. A line ``with head 4`` below it gives the pass its arguments. What
comes out, its values numbered in order, is compared with the text below the arrow. After the arrow
may stand ``stays`` (the same object came out) or words that the test's runner gave instead; words
that it gave besides are lines that begin with ``#``.

If the file's heading has a line such as ``pass number-values``, that is what `tests/test_passes.py`
runs on its cases, by the name that ``vividc opt`` knows; the file needs no test of its own.

To write a case, write its first half and an arrow, and run the test with ``WRITE_CASES=1``: the
second half is written into the file. Read it: it is what the pass does, not yet what it should.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

import pytest

T = TypeVar("T")
ARROW = "-->"


@dataclass(frozen=True)
class Case:
    """One rule: a text, arguments, and what a pass makes of them."""

    file: Path
    title: str
    words: tuple[str, ...]
    before: str
    after: str

    def demand(self, after: str) -> None:
        """Fails unless this came out, or writes it down if that is asked for."""
        if os.environ.get("WRITE_CASES"):
            _write(self, after)
        else:
            assert after == self.after


@dataclass(frozen=True)
class Language(Generic[T]):
    """How the things that passes work on are read, printed, checked and run.

    Attributes
    ----------
    text
        With values numbered in order.
    demand_same
        Fails if two of them do not compute the same.
    """

    parse: Callable[[str], T]
    text: Callable[[T, T], str]
    problems: Callable[[T], list[str]]
    demand_same: Callable[[T, T], None]

    def check(
        self, case: Case, run: Callable[..., object], *, same: bool = True, illegal: str = ""
    ) -> None:
        """Fails unless `run` makes of the case what it says, with the same meaning if `same`.

        Parameters
        ----------
        run
            Gets what the case's text says and its words; gives a thing of the language, words that
            say why it does not, or both.
        illegal
            "before" or "after": that one need not be well formed.
        """
        before = self.parse(case.before)
        assert illegal == "before" or self.problems(before) == []
        made = run(before, *case.words)
        parts = made if isinstance(made, tuple) else (made,)
        lines = [ARROW]
        for part in parts:
            if part is before:
                lines[0] = f"{ARROW} stays"
            elif part is None or isinstance(part, str):
                word = "none" if part is None else part
                lines[0] = f"{ARROW} {word}" if len(parts) == 1 else lines[0]
                lines += [] if len(parts) == 1 else [f"# {word}"]
            else:
                assert illegal == "after" or self.problems(part) == []
                lines.append(self.text(part, before).rstrip("\n"))
                if same:
                    self.demand_same(before, part)
        case.demand("\n".join(lines) + "\n")


def cases(test_file: str) -> pytest.MarkDecorator:
    """Runs a test for each case of the file beside it."""
    file = Path(test_file).with_name(Path(test_file).stem.removeprefix("test_") + ".cases")
    read = [_case(file, part) for part in file.read_text().split("\n== ")[1:]]
    return pytest.mark.parametrize("case", read, ids=[one.title for one in read])


def cases_of_passes(folder: Path) -> list[tuple[str, Case]]:
    """The cases below a folder whose files name a pass, each with the pass's name."""
    found = []
    for file in sorted(folder.rglob("*.cases")):
        head, *parts = file.read_text().split("\n== ")
        named = re.search(r"^pass (\S+)$", head, re.MULTILINE)
        found += [(named[1], _case(file, part)) for part in parts if named is not None]
    return found


def _case(file: Path, text: str) -> Case:
    title, _, rest = text.partition("\n")
    words: tuple[str, ...] = ()
    if rest.startswith("with "):
        line, _, rest = rest.partition("\n")
        words = tuple(line.split()[1:])
    before, _, after = rest.partition(f"\n{ARROW}")
    return Case(file, title, words, before + "\n", f"{ARROW}{after.rstrip()}\n")


def _write(case: Case, after: str) -> None:
    text = case.file.read_text()
    start = text.index(f"\n== {case.title}\n")
    end = text.find("\n== ", start + 1)
    old = text[start:] if end < 0 else text[start:end]
    arrow = old.index(f"\n{ARROW}")
    new = f"{old[:arrow]}\n{after}"
    case.file.write_text(text[:start] + new + text[start + len(old) :])
