"""Random damage to files: to bytes, to text, to trees of JSON and YAML, to archives and arrays."""

from __future__ import annotations

import io
import json
import re
import struct
import warnings
import zipfile
from collections.abc import Callable
from random import Random
from typing import Any, Final

import numpy as np
import yaml

NUMBERS: Final = (
    *("-1", "0", "1", "2", "3", "7", "31", "32", "33", "127", "255", "256", "65535", "1000000"),
    *("2147483647", "2147483648", "-2147483648", "4294967296", "9223372036854775807"),
    *("9223372036854775808", "-9223372036854775809", "18446744073709551616", "9" * 5000),
    *("0.5", "-0.0", "1e400", "-1e400", "1e308", "1e-320", "1e30", "NaN", "Infinity", "-Infinity"),
    *("nan", "inf", ".inf", ".nan", "0x10", "1_000", "1e", "00", "true"),
)
STRINGS: Final = (
    *("", "x", "\0", "\x1b[2J\x07", "\r\n", "é", "\u202e", "\ud800", "\udcff", "\U0001f600"),
    *("A" * 300, "A" * 70_000, "%s%n", "{0}", "[bold]", "../..", "/", "/dev/zero", "/dev/stdin"),
    *(".", "-1", "null", "0", "nan", "__class__", "file", "self", "a" * 255 + ".yaml", "x.yaml"),
)
_DEPTHS: Final = (5, 60, 120, 300, 440, 900, 3000, 30_000)


class Raw(str):
    """Text that stands in JSON as it is."""


class Pairs(list[tuple[str, Any]]):
    """An object whose keys may be there twice."""


def damaged(random: Random, data: bytes, form: str) -> bytes:
    """A file of a form with one to four changes."""
    for _ in range(random.choice((1, 1, 1, 1, 2, 2, 4))):
        data = random.choice(_BY_FORM[form])(random, data)
    return data


def unpacked_size(data: bytes) -> int:
    """Bytes that a file holds, unpacked if it is an archive that can be."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            return max(len(data), *(len(archive.read(info)) for info in archive.infolist()))
    except Exception:
        return len(data)


# Bytes


def _flip(random: Random, data: bytes) -> bytes:
    found = bytearray(data)
    for _ in range(random.choice((1, 1, 1, 2, 8, 40)) if data else 0):
        found[random.randrange(len(found))] ^= 1 << random.randrange(8)
    return bytes(found)


def _cut(random: Random, data: bytes) -> bytes:
    return data[: random.randrange(len(data) + 1)]


def _blocks(random: Random, data: bytes) -> bytes:
    """A block doubled, moved, dropped, or replaced by zeros or noise."""
    first, second, third = sorted(random.randrange(len(data) + 1) for _ in range(3))
    block, rest = data[first:second], data[second:]
    kind = random.randrange(6)
    if kind == 0:
        return data[:second] + block + rest
    if kind == 1:
        return data[:first] + data[second:third] + block + data[third:]
    if kind == 2:
        return data[:first] + rest
    if kind == 3:
        return data[:first] + bytes(len(block)) + rest
    if kind == 4:
        return data[:first] + random.randbytes(min(len(block), 500)) + rest
    return data + random.choice((b"\0", b"\n", data[:100], bytes(3000), b"PK\5\6" + bytes(18)))


def _word(random: Random, data: bytes) -> bytes:
    """Two, four or eight bytes as an extreme number."""
    size = random.choice((2, 4, 8))
    if len(data) < size:
        return data
    at = random.randrange(len(data) - size + 1)
    value = random.choice((0, 1, (1 << 8 * size) - 1, 1 << (8 * size - 1), (1 << 8 * size - 1) - 1))
    return data[:at] + value.to_bytes(size, random.choice(("little", "big"))) + data[at + size :]


# Text


def _text(change: Callable[[Random, str], str]) -> Callable[[Random, bytes], bytes]:
    def changed(random: Random, data: bytes) -> bytes:
        text = change(random, data.decode("utf-8", "surrogateescape"))
        return text.encode("utf-8", "surrogatepass")

    return changed


def _number(random: Random, text: str) -> str:
    places = list(re.finditer(r"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?", text))
    if not places:
        return text
    place = random.choice(places)
    return text[: place.start()] + random.choice(NUMBERS) + text[place.end() :]


def _token(random: Random, text: str) -> str:
    """A word replaced by another, or by a hostile one."""
    places = list(re.finditer(r"\w+|[^\w\s]", text))
    if not places:
        return text
    place = random.choice(places)
    new = random.choice(places)[0] if random.random() < 0.6 else random.choice(STRINGS)
    return text[: place.start()] + new + text[place.end() :]


def _lines(random: Random, text: str) -> str:
    lines = text.split("\n")
    at, other = random.randrange(len(lines)), random.randrange(len(lines))
    kind = random.randrange(6)
    if kind == 0:
        del lines[at]
    elif kind == 1:
        lines.insert(other, lines[at])
    elif kind == 2:
        lines[at], lines[other] = lines[other], lines[at]
    elif kind == 3:
        lines[at] = random.choice(("", " ", "\t", "  ")) + lines[at].strip()
    elif kind == 4:
        lines[at] = lines[at] * random.choice((2, 3, 400))
    else:
        lines[at] = " ".join(lines[at : at + 2])
    return "\n".join(lines)


def _character(random: Random, text: str) -> str:
    at = random.randrange(len(text) + 1)
    new = random.choice((*"\0\"'\\{}[]()<>:,;#&*!|-@%\n\r\t\f é=.", "\ufeff", "\u2028", "", "<!--"))
    return text[:at] + new + text[at + random.randrange(2) :]


def _deep(random: Random, text: str) -> str:
    at = random.randrange(len(text) + 1)
    opened = random.choice(
        ("[", "{", "(", "<a>", '{"a":', "- ", "[[", "-", "not ", "{a: ", "#", "/*")
    )
    return text[:at] + opened * random.choice(_DEPTHS) + text[at:]


def _repeated(random: Random, text: str) -> str:
    """A piece many times: what is tried in several ways, or copied each time, takes ages."""
    first = random.randrange(len(text) + 1)
    piece = text[first : first + random.choice((1, 1, 2, 3, 8, 40))]
    times = min(random.choice((30, 1000, 40_000)), 60_000 // max(1, len(piece)))
    return text[:first] + piece * times + text[first + len(piece) :]


def _encoding(random: Random, data: bytes) -> bytes:
    try:
        text = data.decode()
    except UnicodeDecodeError:
        return data
    code = random.choice(("utf-16", "utf-8-sig", "utf-32", "latin-1", "utf-7"))
    return text.encode(code, "replace")


# Trees


def _json(random: Random, data: bytes) -> bytes:
    try:
        tree = json.loads(data, object_pairs_hook=Pairs)
        return json_text(_changed(random, tree)).encode("utf-8", "surrogatepass")
    except (ValueError, RecursionError):  # what an earlier change left
        return _blocks(random, data)


def _yaml(random: Random, data: bytes) -> bytes:
    """As JSON, which is YAML, too."""
    try:
        tree = yaml.safe_load(data)
        text = json.dumps(tree)
    except (ValueError, TypeError, RecursionError, yaml.YAMLError):
        return _blocks(random, data)
    return _json(random, text.encode())


def json_text(tree: Any) -> str:
    """JSON of a tree with `Raw` and `Pairs`."""
    if isinstance(tree, Raw):
        return str(tree)
    if isinstance(tree, Pairs):
        return "{" + ", ".join(f"{json_text(k)}: {json_text(v)}" for k, v in tree) + "}"
    if isinstance(tree, list):
        return "[" + ", ".join(map(json_text, tree)) + "]"
    return json.dumps(tree)


def _places(tree: Any) -> list[tuple[Any, int]]:
    """Every value but the root, as a container and an index."""
    found = []
    todo = [tree]
    while todo:
        place = todo.pop()
        if isinstance(place, list):
            for index, item in enumerate(place):
                found.append((place, index))
                todo.append(item[1] if isinstance(place, Pairs) else item)
    return found


def _value(place: Any, index: int) -> Any:
    return place[index][1] if isinstance(place, Pairs) else place[index]


def _set(place: Any, index: int, value: Any) -> None:
    place[index] = (place[index][0], value) if isinstance(place, Pairs) else value


def _changed(random: Random, tree: Any) -> Any:
    places = _places(tree)
    if not places:
        return _hostile(random, tree)
    place, index = random.choice(places)
    kind = random.randrange(8)
    if kind <= 2:
        _set(place, index, _hostile(random, _value(place, index)))
    elif kind == 3:
        del place[index]
    elif kind == 4:
        place.insert(random.randrange(len(place) + 1), place[index])
    elif kind == 5:
        _set(place, index, _value(*random.choice(places)))
        if len(json_text_or_deep(tree)) > 1 << 22:
            _set(place, index, None)
    elif isinstance(place, Pairs):
        key = random.choice((random.choice(places[: len(place)])[0], place))
        names = [pair[0] for pair in key] if isinstance(key, Pairs) else ["x"]
        place[index] = (random.choice((*names, *STRINGS[:12])), place[index][1])
    else:
        other = random.randrange(len(place))
        place[index], place[other] = place[other], place[index]
    return tree


def json_text_or_deep(tree: Any) -> str:
    """JSON of a tree; nothing for one that holds itself."""
    try:
        return json_text(tree)
    except RecursionError:
        return " " * (1 << 23)


def _hostile(random: Random, value: Any) -> Any:
    """Something else than `value`, often of its type."""
    kind = random.randrange(8)
    if kind == 0:
        return random.choice((None, True, False, [], Pairs(), [[]], [None], Pairs([("x", 1)])))
    if kind == 1:
        depth = random.choice(_DEPTHS)
        opened, closed = random.choice((("[", "]"), ('{"a": ', "}")))
        return Raw(opened * depth + "1" + closed * depth)
    if kind == 2:
        return random.choice(([value], [value, value], Pairs([("x", value)]), [value] * 300))
    if kind == 3 or (isinstance(value, str) and kind <= 5):
        return random.choice(STRINGS)
    if kind == 4 and isinstance(value, int | float) and not isinstance(value, bool):
        return random.choice((value + 1, value - 1, -value, value + 0.5, str(value), value * 1000))
    return Raw(random.choice(NUMBERS[:34]))


# Archives and arrays


def _members(data: bytes) -> list[tuple[str, bytes]]:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        return [(info.filename, archive.read(info)) for info in archive.infolist()]


def _zip(random: Random, members: list[tuple[str, bytes]], *, stored: bool) -> bytes:
    method = zipfile.ZIP_STORED if stored else random.choice((0, 8))
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", method) as archive, warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # names that are there twice
        for name, content in members:
            archive.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), content, method)
    return buffer.getvalue()


def _archive(random: Random, data: bytes, *, stored: bool) -> bytes:
    """A member damaged, renamed, dropped, doubled or swapped; or the directory lies."""
    try:
        members = _members(data)
    except Exception:
        return _word(random, data)
    if not members:
        return data
    at = random.randrange(len(members))
    name, content = members[at]
    kind = random.randrange(10)
    if kind <= 5:
        members[at] = (name, _member(random, name, content))
    elif kind == 6:
        return _lying(random, data)
    elif kind == 7:
        members[at] = (random.choice(_MEMBER_NAMES), content)
    elif kind == 8:
        del members[at]
    else:
        other = random.choice(members)
        members[at] = random.choice(((name, other[1]), (other[0], content)))
    return _zip(random, members, stored=stored)


_MEMBER_NAMES: Final = (
    *("", "x.npy", "../x.npy", "/etc/passwd", "a/b.npy", "\x1b[2J.npy", "x", "file.npy", "é.npy"),
    *("A" * 60_000 + ".npy", ".npy", "self.npy", "x\0y.npy", "return.npy"),
)


def _member(random: Random, name: str, content: bytes) -> bytes:
    if name.endswith(".json"):
        return random.choice((_json, _json, _json, _flip))(random, content)
    return random.choice((_header, _elements, _elements, _flip, _cut, _word))(random, content)


def _lying(random: Random, data: bytes) -> bytes:
    """A field of a local header, of the directory, or of its end, as an extreme."""
    begin = random.choice((b"PK\3\4", b"PK\1\2", b"PK\1\2", b"PK\5\6"))
    places = [found.start() for found in re.finditer(re.escape(begin), data)]
    if not places:
        return data
    at = random.choice(places) + 4 + random.randrange(42)
    size = random.choice((1, 2, 4))
    value = random.choice((0, 1, 8, 12, 14, 255, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF))
    return data[:at] + (value & ((1 << 8 * size) - 1)).to_bytes(size, "little") + data[at + size :]


_DESCRS: Final = (
    *("<f4", "<f8", "<f2", "<i4", "<i8", "|i1", "|u1", "|b1", ">f4", ">i8", "<u8", "|O", "<U3"),
    *(
        "|S0",
        "|V4",
        "<c8",
        "<c16",
        "<M8[s]",
        "<g",
        "",
        "<f3",
        "f4,f4",
        "<U999999999",
        "|S2147483647",
    ),
)
_SHAPES: Final = (
    *("()", "(0,)", "(1,)", "(2,)", "(3, 0)", "(4398046511104,)", "(-1,)", "(1, 1)", "(True,)"),
    *("(2147483648, 2147483648)", "(0, 9223372036854775807)", "(18446744073709551616, 0)"),
    *("(1.0,)", "('a',)", "None", "[2]", "(" + "1," * 70 + ")", "(" * 300, "(" + "9" * 5000 + ",)"),
    "(4294967296, 4294967296, 4294967296, 4294967296, 0)",
)


def _header(random: Random, content: bytes) -> bytes:
    """Another dtype, order or shape in an array's header; its length may lie, too."""
    length = struct.unpack("<H", content[8:10])[0] if len(content) > 10 else 0
    text = content[10 : 10 + length].decode("latin-1")
    kind = random.randrange(4)
    if kind == 0:
        text = re.sub(r"'descr': '[^']*'", f"'descr': {random.choice(_DESCRS)!r}", text)
    elif kind == 1:
        text = re.sub(r"'shape': \([^)]*\)", f"'shape': {random.choice(_SHAPES)}", text)
    elif kind == 2:
        old, new = random.choice((("False", "True"), ("False", "1"), ("shape", "size"), ("}", "")))
        text = text.replace(old, new)
    else:
        text = _token(random, text)
    told = random.choice((len(text), len(text), len(text), length, 0, 65535))
    encoded = text.encode("latin-1", "replace")
    return content[:8] + struct.pack("<H", min(told, 65535)) + encoded + content[10 + length :]


def _elements(random: Random, content: bytes) -> bytes:
    """An array with other values, another type or other axes."""
    try:
        array = np.load(io.BytesIO(content), allow_pickle=False)
        array = _other_array(random, np.array(array))
        buffer = io.BytesIO()
        np.save(buffer, array, allow_pickle=False)
    except Exception:
        return _flip(random, content)
    return buffer.getvalue()


def _other_array(random: Random, array: np.ndarray) -> np.ndarray:
    kind = random.randrange(8)
    if kind == 0:
        dtype = random.choice(("f2", "f4", "f8", "i1", "i4", "i8", "u8", "?", "c8", "U3"))
        with np.errstate(all="ignore"):
            return array.astype(dtype)
    if kind == 1:
        return array[None] if random.random() < 0.5 else array.reshape(-1)
    if kind == 2:
        return array[:-1] if array.ndim else array.reshape(1)
    if kind == 3 and array.ndim:
        return np.concatenate([array, array])
    if kind == 4:
        return np.asfortranarray(array)
    info = np.iinfo(array.dtype) if array.dtype.kind in "iu" else None
    values = (0, 1, -1, 2, 3, 7, 100, 1000, 65536)
    extreme = (info.min, info.max) if info else (np.nan, np.inf, -np.inf, 1e38, -1e38, 1e-40, -0.0)
    with np.errstate(all="ignore"):
        value = np.array(random.choice((*values, *extreme))).astype(array.dtype)
    if kind == 5 or not array.ndim:
        array[...] = value
    elif array.size:
        array.reshape(-1)[random.randrange(array.size)] = value
    return array


def _npz(random: Random, data: bytes) -> bytes:
    return _archive(random, data, stored=False)


def _bundle(random: Random, data: bytes) -> bytes:
    return _archive(random, data, stored=random.random() < 0.95)


# PLY: a header of text, then numbers


def _ply_head(random: Random, data: bytes) -> bytes:
    head, mark, body = data.partition(b"end_header\n")
    change = random.choice((_number, _number, _token, _lines, _lines, _character))
    return _text(change)(random, head) + mark + body


_BYTES: Final = (_flip, _cut, _blocks, _word)
_TEXT: Final = (
    *(
        _text(_number),
        _text(_number),
        _text(_token),
        _text(_lines),
        _text(_character),
        _text(_deep),
    ),
    *(_encoding, _flip, _cut, _blocks),
)
_BY_FORM: Final[dict[str, tuple[Callable[[Random, bytes], bytes], ...]]] = {
    "bytes": _BYTES,
    "text": _TEXT,
    "tree": (_json,),
    "json": (*_TEXT, *[_json] * 12),
    "yaml": (*_TEXT, *[_yaml] * 8),
    "npz": (*[_npz] * 10, *_BYTES),
    "bundle": (*[_bundle] * 12, *_BYTES),
    "npy": (_header, _header, *_BYTES),
    "ply": (_ply_head, _ply_head, _ply_head, *_BYTES),
}
