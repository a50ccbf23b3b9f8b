"""Labels, shortened with an ellipsis until they fit their room."""

from __future__ import annotations

from vividc.host.plot import text_width

_ELLIPSIS = "…"


def fitted(text: str, size: float, width: float) -> str:
    """The text on one line, or as much of its beginning as fits."""
    text = " ".join(text.split())
    if text_width(text, size) <= width:
        return text
    while text and text_width(text + _ELLIPSIS, size) > width:
        text = text[:-1]
    return text + _ELLIPSIS


def fitted_id(number: int, size: float, width: float) -> str:
    """The id, or as much of its end as fits: long ids differ there."""
    text = str(number)
    if text_width(text, size) <= width:
        return text
    while text and text_width(_ELLIPSIS + text, size) > width:
        text = text[1:]
    return _ELLIPSIS + text


def name_and_id(name: str, number: int, size: float, width: float) -> str:
    """An operation by name and id; if both are too long, the id gets half of the room."""
    space = text_width(" ", size)
    least = text_width(fitted(name, size, (width - space) / 2), size)
    shown = fitted_id(number, size, width - space - least)
    return f"{fitted(name, size, width - space - text_width(shown, size))} {shown}"
