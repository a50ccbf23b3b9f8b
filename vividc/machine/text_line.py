"""Lines of the text forms of functions and graphs: tokens, and how a source line is written."""

from __future__ import annotations

import json
import re
from typing import Final, NoReturn

from vividc.errors import SourceLoc, VividcError, quoted

_TOKEN: Final = re.compile(
    r"""\s*(?:(?P<loc>!.*)
    |(?P<string>"[^"\\]*+(?:\\.[^"\\]*+)*+")
    |(?P<ref>%-?\d+)
    |(?P<number>0x[0-9a-fA-F]+|-?\d+)
    |(?P<word>[A-Za-z_][\w.]*)
    |(?P<mark>[=@(),:$\[\]]))""",
    re.VERBOSE,
)
_LOC: Final = re.compile(r'!(?P<file>"[^"\\]*+(?:\\.[^"\\]*+)*+"|.*):(?P<line>\d+)\s*\Z')
_KINDS: Final = {
    "ref": "a reference like %3",
    "number": "a number",
    "string": "a name in quotes",
    "word": "a word",
    "mark": "a mark",
    "loc": "a source line",
}


def location_text(loc: SourceLoc) -> str:
    """`!file:line`, the file in quotes where it could be misread."""
    plain = loc.file.isprintable() and loc.file == loc.file.strip() and loc.file[:1] != '"'
    return f"!{loc.file if plain else json.dumps(loc.file)}:{loc.line}"


class TextLine:
    """Tokens of a line, taken one after the other; `error` is what a mistake raises."""

    def __init__(self, loc: SourceLoc, source: str, error: type[VividcError]) -> None:
        self.loc = loc
        self.error = error
        self.tokens: list[tuple[str, str]] = []
        self.next = 0
        at = 0
        source = source.rstrip()
        while at < len(source):
            match = _TOKEN.match(source, at)
            if match is None or match.lastgroup is None:
                self.fail(f"cannot read {quoted(source[at:].strip())}")
            self.tokens.append((match.lastgroup, match[match.lastgroup]))
            at = match.end()

    def fail(self, reason: str) -> NoReturn:
        """Raise the error of this line."""
        raise self.error(reason, loc=self.loc)

    def peek(self) -> tuple[str, str]:
        """Kind and text of the next token; kind "end" behind the last."""
        return (
            self.tokens[self.next] if self.next < len(self.tokens) else ("end", "the end of line")
        )

    def accept(self, kind: str, text: str | None = None) -> str | None:
        """The next token if it is the given one."""
        next_kind, value = self.peek()
        if next_kind != kind or (text is not None and value != text):
            return None
        self.next += 1
        return value

    def expect(self, kind: str, text: str | None = None) -> str:
        """The next token, which must be the given one."""
        value = self.accept(kind, text)
        if value is None:
            self.fail(f"expected {text or _KINDS[kind]}, found {self.peek()[1]}")
        return value

    def integer(self) -> int:
        """A decimal or hexadecimal integer."""
        return self.whole(self.expect("number"))

    def whole(self, text: str) -> int:
        """The integer of a text; Python reads none of thousands of digits."""
        try:
            return int(text, 16 if text.startswith("0x") else 10)
        except ValueError:
            self.fail(f"a number of {len(text)} digits")

    def string(self, quoted: str) -> str:
        """The value of a string in JSON's notation."""
        try:
            value = json.loads(quoted)
        except json.JSONDecodeError:
            self.fail(f"{quoted} is not a string")
        return str(value)

    def location(self) -> SourceLoc | None:
        """`!file:line`, if it is there."""
        text = self.accept("loc")
        if text is None:
            return None
        match = _LOC.fullmatch(text)
        if match is None:
            self.fail(f"{text} is not a source line: write !file:line")
        file = match["file"]
        return SourceLoc(
            self.string(file) if file.startswith('"') else file, self.whole(match["line"])
        )

    def end(self) -> None:
        """Nothing may be left."""
        if self.peek()[0] != "end":
            self.fail(f"unexpected {self.peek()[1]}")
