"""Tokens, types and operands of LLVM's text."""

from __future__ import annotations

import re
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field

from vividc.errors import InternalError
from vividc.machine.words import WORD_BITS
from vividc.ssa.ir import LLVM_CASTS, Float, Global, Input, Int, Named, Parts, Ref, Value

_TOKEN = re.compile(
    r'(?P<quoted>[%@]"(?:[^"\\]|\\.)*")|(?P<name>[%@][-\w.$]+)|(?P<meta>![\w.]*)|(?P<string>c?"[^"]*")'
    r"|(?P<number>-?\d+\.\d+e[-+]\d+|(?:f0x|0x[KLMHR]?)[0-9A-Fa-f]+|-?\d+)|(?P<word>[A-Za-z_][\w.]*)"
    r"|(?P<mark>\.\.\.|[][(){}<>,=*#:|])"
)
_FLAGS = frozenset(
    [
        "nuw",
        "nsw",
        "exact",
        "disjoint",
        "nneg",
        "samesign",
        "inbounds",
        "nusw",
        "volatile",
        "fast",
        "nnan",
        "ninf",
        "nsz",
        "arcp",
        "contract",
        "afn",
        "reassoc",
        "tail",
        "musttail",
        "notail",
        "inreg",
        "noundef",
        "nonnull",
        "dso_local",
        "zeroext",
        "signext",
    ]
)
_SPECIAL = re.compile(rb'[^ -~]|["\\]')
_ESCAPE = re.compile(rb"\\\\|\\[0-9A-Fa-f]{2}")
_FLOAT_DIGITS = 8


class Structs(dict[str, str]):
    """Members of each named structure, as text without blanks: "{float,[3xi32]}".

    `layouts`: size and alignment of types, None if not known, as far as they were asked for.
    """

    def __init__(self, members: Mapping[str, str] | None = None) -> None:
        super().__init__(members or {})
        self.layouts: dict[str, tuple[int, int] | None] = {}


class Names:
    """What a function's local names stand for: inputs (keys by name), and results numbered as they
    are met.
    """

    def __init__(self, inputs: Mapping[str, str] | None = None) -> None:
        self._values: dict[str, Named] = {n: Input(key) for n, key in (inputs or {}).items()}
        self._count = 0

    def value(self, name: str) -> Named:
        """The value called `name`."""
        if name not in self._values:
            self._values[name] = Ref(self.fresh())
        return self._values[name]

    def result(self, name: str) -> int:
        """The id of an instruction or phi; one of its own if it has no name."""
        value = self.value(name) if name else Ref(self.fresh())
        assert isinstance(value, Ref)  # LLVM gives a name once
        return value.id

    def fresh(self) -> int:
        """An id that nothing has."""
        self._count += 1
        return self._count - 1


@dataclass
class Cursor:
    """Tokens of one line, read from left to right.

    `structs`: members of named structures; `names`: those of the function.
    """

    text: str
    structs: Structs = field(default_factory=Structs)
    names: Names = field(default_factory=Names)
    tokens: list[str] = field(init=False)
    position: int = 0

    def __post_init__(self) -> None:
        self.tokens = [match.group() for match in _TOKEN.finditer(self.text)]

    @property
    def peek(self) -> str:
        return self.tokens[self.position] if self.position < len(self.tokens) else ""

    def take(self) -> str:
        token = self.peek
        if not token:
            raise InternalError(f"cannot read LLVM's text: {self.text.strip()}")
        self.position += 1
        return token

    def accept(self, token: str) -> bool:
        if self.peek != token:
            return False
        self.position += 1
        return True

    def expect(self, token: str) -> None:
        if not self.accept(token):
            raise InternalError(f"cannot read LLVM's text: {self.text.strip()}")

    def skip_flags(self) -> frozenset[str]:
        """Flags of an instruction, which are returned without their arguments."""
        flags = set()
        while self.peek in _FLAGS:
            flags.add(self.take())
            self.skip_parentheses()
        return frozenset(flags)

    def skip_parentheses(self) -> None:
        if self.accept("("):
            while not self.accept(")"):
                self.skip_parentheses() if self.peek == "(" else self.take()

    def type(self) -> str:
        """A type; aggregates are kept as text without blanks."""
        token = self.take()
        if token in ("[", "{", "<"):
            closing = {"[": "]", "{": "}", "<": ">"}[token]
            parts = [token]
            while self.peek != closing:
                parts.append(self.type() if self.peek in ("[", "{", "<") else self.take())
            return "".join([*parts, self.take()])
        return token

    def operand(self, type_: str) -> Value:
        """A value of the given type; a constant expression is kept as its operation's name."""
        token = self.take()
        if token[:1] in ("%", "@"):
            return self.names.value(bare(token)) if token[0] == "%" else Global(bare(token))
        if type_[:1] in ("[", "{"):
            return self._aggregate(token)
        return self._constant(token, type_)

    def _aggregate(self, token: str) -> Parts:
        """A constant of several values: in brackets, as a string of bytes, or all zero."""
        if token.startswith('c"'):
            return Parts(tuple(Int(byte) for byte in unescaped(token[2:-1])))
        values: list[Value] = []
        closing = {"[": "]", "{": "}"}.get(token)
        while closing is not None and not self.accept(closing):
            values.append(self.typed_operand()[1])
            self.accept(",")
        return Parts(tuple(values))

    def _constant(self, token: str, type_: str) -> Value:
        if token in ("true", "false"):
            return Int(int(token == "true"))
        if type_ in ("float", "double"):
            return Float(_float(token))
        # Any value will do for one that is undefined.
        if token in ("poison", "undef", "null", "zeroinitializer", "none"):
            return Int(0)
        if re.fullmatch(r"-?\d+", token):
            return Int(_kept(int(token), type_))
        if token == "getelementptr":
            return self._constant_address()
        start = self.position
        place = self._moved(token)
        if place is None:
            self.position = start
            self._skip_constant_expression()
        return place or Global(token)

    def _moved(self, token: str) -> Global | None:
        """An address as a number, or one a constant further: `add (i64 ptrtoint (...), i64 -20)`;
        None: another constant expression.
        """
        self.skip_flags()
        if not self.accept("("):
            return None
        one = self.typed_operand()[1]
        if not isinstance(one, Global):
            return None
        if self.accept("to"):
            self.type()
            return one if self.accept(")") else None
        self.expect(",")
        by = self.typed_operand()[1]
        if not self.accept(")") or token not in ("add", "sub") or not isinstance(by, Int):
            return None
        return Global(one.name, one.offset + (by.value if token == "add" else -by.value))

    def _constant_address(self) -> Global:
        """`getelementptr inbounds (i8, ptr @global, i32 16)`: LLVM writes offsets in bytes."""
        start = self.position
        while self.peek in _FLAGS:
            self.take()
        if self.accept("(") and self.accept("i8") and self.accept(","):
            base = self.typed_operand()[1]
            self.expect(",")
            offset = self.typed_operand()[1]
            if isinstance(base, Global) and isinstance(offset, Int) and self.accept(")"):
                return Global(base.name, base.offset + offset.value)
        self.position = start
        self._skip_constant_expression()
        return Global("getelementptr")

    def _skip_constant_expression(self) -> None:
        while self.peek and self.peek != "(":
            self.take()
        self.skip_parentheses()

    def address(self) -> tuple[str, tuple[Value, ...]]:
        """What follows a `getelementptr` and its flags: the element's type, pointer and indices."""
        element = self.type()
        args: list[Value] = []
        while self.accept(","):
            if self.peek[:1] == "!":
                break
            args.append(self.typed_operand()[1])
        return element, tuple(args)

    def typed_operand(self) -> tuple[str, Value]:
        type_ = self.type()
        self.skip_attributes()
        return type_, self.operand(type_)

    def skip_attributes(self) -> None:
        """Parameter attributes: words, possibly with arguments, before the value."""
        while self.peek[:1].isalpha() and not _is_value(self.peek):
            self.take()
            self.skip_parentheses()
            if self.peek.lstrip("-").isdigit() and self.tokens[self.position - 1] == "align":
                self.take()


def _is_value(token: str) -> bool:
    constants = ("poison", "undef", "null", "true", "false", "zeroinitializer")
    operations = ("getelementptr", "add", "sub", "mul", "xor")
    return token in constants + operations or token in LLVM_CASTS or token.startswith(("0x", "f0x"))


def bare(token: str) -> str:
    """Name of a local or global without sigil, quotes and escapes."""
    name = token[1:]
    return unescaped(name[1:-1]).decode(errors="surrogateescape") if name[:1] == '"' else name


def quoted_global(name: str) -> str:
    """The global of a bare name, as LLVM reads any."""
    raw = name.encode(errors="surrogateescape")
    plain = _SPECIAL.sub(lambda m: b"\\%02X" % m[0][0], raw)
    return f'@"{plain.decode()}"'


def unescaped(string: str) -> bytes:
    """The bytes of what stands between a string's quotes: two hexadecimal digits after a backslash
    are one byte, two backslashes are one.
    """
    return _ESCAPE.sub(
        lambda m: b"\\" if m[0] == b"\\\\" else bytes.fromhex(m[0][1:].decode()), string.encode()
    )


def _kept(value: int, type_: str) -> int:
    """A constant as it is kept: of an integer type of less than a word, whatever its width (LLVM
    narrows switches to i2, i5, ...), without sign.
    """
    bits = int(type_[1:]) if type_[:1] == "i" and type_[1:].isdigit() else WORD_BITS
    return value & ((1 << bits) - 1) if bits < WORD_BITS else value


def _float(token: str) -> float:
    if token.startswith("f0x"):
        digits = token[3:]
        layout = (">f", 4) if len(digits) <= _FLOAT_DIGITS else (">d", 8)
        return float(struct.unpack(layout[0], int(digits, 16).to_bytes(layout[1], "big"))[0])
    if token.startswith("0x"):
        return float(struct.unpack(">d", int(token[2:], 16).to_bytes(8, "big"))[0])
    return 0.0 if token in ("poison", "undef", "zeroinitializer") else float(token)
