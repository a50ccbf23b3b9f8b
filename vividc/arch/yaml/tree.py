"""YAML text as plain data plus the line of every value, so that each error can name its line."""

from __future__ import annotations

from dataclasses import dataclass

import yaml

from vividc.errors import ArchError, quoted
from vividc.host.inputs import YAML_BYTES, limit, too_large

Plain = None | bool | int | float | str | list["Plain"] | dict[str, "Plain"]
Path = tuple[str | int, ...]

_DEEPEST = 32
"""Levels of a fabric's or a table's YAML: none needs ten."""
_HINTS = {
    "fabric": "start with `extends: vivid-tile`, or see docs/fabric-yaml.md",
    "cost table": "copy a shipped one: see docs/energy.md",
}
_SCALAR_TAGS = frozenset(
    f"tag:yaml.org,2002:{kind}" for kind in ("null", "bool", "int", "float", "str")
)


@dataclass(frozen=True)
class Tree:
    """A YAML mapping and the place (`file:line`) of each of its values, keyed by path."""

    data: dict[str, Plain]
    places: dict[Path, str]

    def place(self, path: Path) -> str:
        """Place of the value at `path`, or of its nearest enclosing value that the text has."""
        for length in range(len(path), 0, -1):
            place = self.places.get(path[:length])
            if place is not None:
                return place
        return self.places[()]


def parse(text: str, file: str, what: str = "fabric") -> Tree:
    """Read one YAML document whose top level is a mapping; `what` names it in messages.

    Only what a fabric needs is accepted: mappings with text keys, lists, and scalars. Aliases are
    refused, as they could make a small text expand without bound.

    Raises
    ------
    ArchError
        Broken YAML, a repeated key, an alias, another tag, or another top level; names `file:line`.
    """
    if len(text) > limit(YAML_BYTES):
        raise too_large(file, f"{len(text)} characters of YAML", limit(YAML_BYTES), ArchError)
    root = _compose(text, file)
    if not isinstance(root, yaml.MappingNode):
        line = 1 if root is None else root.start_mark.line + 1
        raise ArchError(
            f"a {what} is a YAML mapping",
            loc=f"{file}:{line}",
            hint=_HINTS.get(what),
        )
    walker = _Walker(file)
    data = walker.mapping(root, ())
    return Tree(data, walker.places)


def _compose(text: str, file: str) -> yaml.Node | None:
    try:
        return yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        line = 1 if error.problem_mark is None else error.problem_mark.line + 1
        reason = f"not YAML: {error.problem or error.context}"
        raise ArchError(reason, loc=f"{file}:{line}") from error
    except yaml.reader.ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        raise ArchError(f"not YAML: {error.reason}", loc=f"{file}:{line}") from error
    except RecursionError as error:
        raise ArchError("nested too deeply", loc=file) from error


class _Walker:
    def __init__(self, file: str) -> None:
        self.file = file
        self.places: dict[Path, str] = {}
        self._seen: set[int] = set()
        self._scalars = yaml.SafeLoader("")

    def value(self, node: yaml.Node, path: Path) -> Plain:
        if isinstance(node, yaml.MappingNode):
            return self.mapping(node, path)
        self._enter(node, path)
        if isinstance(node, yaml.SequenceNode):
            return [self.value(item, (*path, index)) for index, item in enumerate(node.value)]
        return self._scalar(node)

    def mapping(self, node: yaml.MappingNode, path: Path) -> dict[str, Plain]:
        self._enter(node, path)
        result: dict[str, Plain] = {}
        for key_node, value_node in node.value:
            if not isinstance(key_node, yaml.ScalarNode):
                raise self._error(key_node, "a key must be text")
            key = self._text(key_node)
            if key in result:
                raise self._error(key_node, f"the key `{quoted(key)[1:-1]}` is given twice")
            result[key] = self.value(value_node, (*path, key))
            # A block value starts a line after its key; a person looks for the key.
            self.places[(*path, key)] = self._place(key_node)
        return result

    def _scalar(self, node: yaml.Node) -> Plain:
        if node.tag not in _SCALAR_TAGS:
            return self._text(node)
        try:
            value: Plain = self._scalars.construct_object(node)
        except ValueError as error:
            raise self._error(node, f"`{node.value:.60}` is not a value") from error
        return self._text(node) if isinstance(value, str) else value

    def _text(self, node: yaml.Node) -> str:
        """Escapes such as "\\ud800" make halves of a character, which no file can hold."""
        text = str(node.value)
        try:
            text.encode()
        except UnicodeEncodeError:
            raise self._error(node, f"{quoted(text)} is no text of Unicode characters") from None
        return text

    def _enter(self, node: yaml.Node, path: Path) -> None:
        if len(path) > _DEEPEST:
            raise self._error(node, "nested too deeply")
        if id(node) in self._seen:
            raise self._error(node, "YAML aliases are refused", "use `extends` or `overrides`")
        self._seen.add(id(node))
        self.places[path] = self._place(node)

    def _place(self, node: yaml.Node) -> str:
        return f"{self.file}:{node.start_mark.line + 1}"

    def _error(self, node: yaml.Node, reason: str, hint: str | None = None) -> ArchError:
        return ArchError(reason, loc=self._place(node), hint=hint)
