"""Random damage to the text of `.ll` modules, and the committed files that get it."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from random import Random

_ROOT = Path(__file__).parents[2]
_FILES = (
    *sorted((_ROOT / "kernels/c").glob("*.ll")),
    *sorted((_ROOT / "tests/frontend/c").glob("*.ll")),
)
EXTREMES = (0, 1, -1, 2, 7, 31, 32, 33, 127, 128, 255, 256, 65535, -32768, 2**31 - 1, -(2**31))
"""Integers of 32 bits at which something changes."""
WIDE = (*EXTREMES, 2**32, 2**33 + 1, 2**63 - 1, -(2**63), 2**34)
"""The same of 64 bits."""


@cache
def _committed() -> tuple[str, ...]:
    return tuple(path.read_text() for path in _FILES)


@cache
def _functions(text: str) -> tuple[str, ...]:
    return tuple(re.findall(r"^define [^@]*@([\w.]+)\(", text, re.MULTILINE))


def committed(random: Random) -> tuple[str, str]:
    """The text of a committed file, and the name of one of its functions."""
    text = random.choice(_committed())
    name = random.choice(_functions(text))
    return _only(random, text, name), name


def _only(random: Random, text: str, name: str) -> str:
    """Mutations should mostly hit the kernel: other functions are often left out."""
    if random.random() < 0.2:
        return text
    parts = re.split(r"(?m)^(?=define )", text)
    kept = [
        part
        if not part.startswith("define ") or f"@{name}(" in part.split("\n")[0]
        else part[part.find("\n}\n") + 3 :]
        for part in parts
    ]
    found = "".join(kept)
    calls = set(re.findall(r"call [^@]*@([\w.]+)\(", found))
    return text if calls & (set(_functions(text)) - {name}) else found


def mutated(random: Random, text: str) -> str:
    """The text with one to eight changes."""
    for _ in range(random.choice((1, 1, 1, 2, 3, 8))):
        text = random.choice(_MUTATIONS)(random, text)
    return text


def _number(random: Random, text: str) -> str:
    places = list(re.finditer(r"(?<=[ ,(\[])-?\d+", text))
    if not places:
        return text
    place = random.choice(places)
    return text[: place.start()] + str(random.choice((*WIDE, 2**64, 10**30))) + text[place.end() :]


def _node(random: Random, text: str) -> str:
    """A node of metadata, that of lines above all, instead of another."""
    places = list(re.finditer(r"!\d+", text))
    if not places:
        return text
    first, second = random.choice(places), random.choice(places)
    return text[: first.start()] + second[0] + text[first.end() :]


def _type(random: Random, text: str) -> str:
    places = list(re.finditer(r"\b(?:i32|i64|i8|i16|i1|float|double|ptr)\b", text))
    if not places:
        return text
    place = random.choice(places)
    new = random.choice(
        (
            "i1",
            "i8",
            "i7",
            "i32",
            "i64",
            "i128",
            "float",
            "double",
            "ptr",
            "half",
            "<4 x i32>",
            "[2 x i32]",
            "{ i32, float }",
            "x86_fp80",
            "ptr addrspace(3)",
        )
    )
    return text[: place.start()] + new + text[place.end() :]


def _word(random: Random, text: str) -> str:
    places = list(re.finditer(r"[%@!]?[\w.]+", text))
    if not places:
        return text
    first, second = random.choice(places), random.choice(places)
    return text[: first.start()] + second[0] + text[first.end() :]


def _lines(random: Random, text: str) -> str:
    lines = text.split("\n")
    at, other = random.randrange(len(lines)), random.randrange(len(lines))
    kind = random.choice(("drop", "twice", "swap", "join", "cut", "move"))
    if kind == "drop":
        del lines[at]
    elif kind == "twice":
        lines.insert(at, lines[at])
    elif kind == "swap":
        lines[at], lines[other] = lines[other], lines[at]
    elif kind == "join":
        lines[at] = " ".join(lines[at : at + 2])
    elif kind == "cut":
        lines = lines[: at + 1]
    else:
        lines.insert(other, lines.pop(at))
    return "\n".join(lines)


def _byte(random: Random, text: str) -> str:
    at = random.randrange(len(text) + 1)
    new = random.choice(
        (
            "",
            "\0",
            '"',
            "\\",
            "{",
            "}",
            "[",
            "(",
            ")",
            "<",
            "*",
            ";",
            "\n",
            "\r",
            "é",
            "!",
            "%",
            "@",
            "#",
            ",",
            " ",
        )
    )
    return text[:at] + new + text[at + random.randrange(2) :]


def _deep(random: Random, text: str) -> str:
    depth = random.choice((10, 90, 101, 5000))
    opened = random.choice(("[", "{", "(", "<", "<{", "[2 x "))
    at = random.randrange(len(text) + 1)
    return text[:at] + opened * depth + text[at:]


def _quoted(random: Random, text: str) -> str:
    """Names of functions in quotes, some of their letters as numbers."""
    places = list(re.finditer(r"@([A-Za-z_]\w*)", text))
    if not places:
        return text
    name = random.choice(places)[1]
    letters = "".join(f"\\{ord(x):02X}" if random.random() < 0.5 else x for x in name)
    return re.sub(rf"@{name}\b", lambda _: f'@"{letters}"', text)


_MUTATIONS = (
    _number,
    _number,
    _node,
    _node,
    _type,
    _word,
    _word,
    _lines,
    _lines,
    _byte,
    _deep,
    _quoted,
)
