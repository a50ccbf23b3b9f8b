"""Problems of a fabric's YAML, collected so that a user sees all of them at once."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from vividc.arch.yaml.tree import Tree
from vividc.errors import ArchError, quoted

Model = TypeVar("Model", bound=BaseModel)
_IN_OUR_WORDS: Final = {
    "model_type": "should be a mapping",
    "string_pattern_mismatch": "should be up to 64 letters, digits, dots, dashes and underscores",
}
"""By pydantic's name of the error, where its own text speaks of Python."""


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing that is wrong with a fabric, where, and a way out."""

    place: str
    reason: str
    hint: str | None = None


def raise_all(problems: Sequence[Problem]) -> None:
    """Raise one `ArchError` that lists every problem; return if there is none."""
    if not problems:
        return
    first, *others = sorted(problems, key=lambda problem: _by_line(problem.place))
    if not others:
        raise ArchError(first.reason, loc=first.place, hint=first.hint)
    lines = [_with_hint(first.reason, first.hint)]
    lines += [_with_hint(f"{other.place}: {other.reason}", other.hint) for other in others]
    raise ArchError("\n".join(lines), loc=first.place)


def _by_line(place: str) -> tuple[str, int]:
    file, _, line = place.rpartition(":")
    return (file, int(line)) if line.isdigit() else (place, 0)


def _with_hint(text: str, hint: str | None) -> str:
    return text if hint is None else f"{text}\n    hint: {hint}"


def validated(tree: Tree, model: type[Model], *, inherits: bool = True) -> Model:
    """The tree as a model; `inherits`: what is missing may come from a file that it extends.

    Raises
    ------
    ArchError
        All that pydantic finds, in our words and with the line of each value.
    """
    try:
        return model.model_validate(tree.data)
    except ValidationError as error:
        raise_all([_problem(detail, tree, model, inherits) for detail in error.errors()])
        raise


def did_you_mean(word: str, known: Iterable[str]) -> str | None:
    """A hint with the closest known word, or None if nothing is close."""
    close = difflib.get_close_matches(word, list(known), n=1)
    return f"did you mean `{close[0]}`?" if close else None


def _problem(detail: ErrorDetails, tree: Tree, model: type[BaseModel], inherits: bool) -> Problem:
    path = detail["loc"]
    name = _path_text(tree, path)
    place = tree.place(path)
    if detail["type"] == "extra_forbidden":
        known = _keys_beside(path, model)
        hint = did_you_mean(str(path[-1]), known) or f"known keys here: {', '.join(known)}"
        if "at" in known and path[-1] in ("rows", "cols"):
            hint = f"the place goes under `at`: `at: {{{path[-1]}: ...}}`"
        return Problem(place, f"unknown key `{name}`", hint)
    if detail["type"] == "missing":
        whole = inherits and len(path) == 1
        way_out = "give it, or inherit it: `extends: vivid-tile`" if whole else None
        return Problem(place, f"`{name}` is missing", way_out)
    message = detail["msg"].removeprefix("Value error, ").removeprefix("Input ")
    message = _IN_OUR_WORDS.get(detail["type"], message)
    return Problem(place, f"`{name}` {message}, got {quoted(detail['input'])}")


def _path_text(tree: Tree, path: tuple[str | int, ...]) -> str:
    """`path` as a user would write it: union branches, which pydantic adds, are left out."""
    shown = [part for end, part in enumerate(path, 1) if path[:end] in tree.places]
    if path and (not shown or path[-1] != shown[-1]) and path[:-1] in (tree.places.keys() | {()}):
        shown.append(path[-1])
    return ".".join(quoted(str(part))[1:-1] for part in shown)


def _keys_beside(path: tuple[str | int, ...], model: type[BaseModel]) -> list[str]:
    """Keys that the schema knows beside the last part of `path`."""
    for part in path[:-1]:
        inner = _models_of(model, part)
        model = inner or model
    return [field.alias or name for name, field in model.model_fields.items()]


def _models_of(model: type[BaseModel], part: str | int) -> type[BaseModel] | None:
    for name, field in model.model_fields.items():
        if part in (name, field.alias):
            return _find_model(field.annotation)
    return None


def _find_model(annotation: object) -> type[BaseModel] | None:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    for argument in getattr(annotation, "__args__", ()):
        model = _find_model(argument)
        if model is not None:
            return model
    return None
