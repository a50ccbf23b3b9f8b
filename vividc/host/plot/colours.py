"""Colours that stay apart for colour-blind readers, as "#rrggbb" (Okabe and Ito 2008)."""

from __future__ import annotations

from typing import Final

INK: Final = "#222222"
PAPER: Final = "#ffffff"
OKABE_ITO: Final[dict[str, str]] = {
    "orange": "#e69f00",
    "sky": "#56b4e9",
    "green": "#009e73",
    "yellow": "#f0e442",
    "blue": "#0072b2",
    "vermilion": "#d55e00",
    "purple": "#cc79a7",
    "grey": "#999999",
}
_DARK_BELOW: Final = 0.45
_LUMA: Final = (0.2126, 0.7152, 0.0722)


def channels(colour: str) -> tuple[int, int, int]:
    """Red, green and blue, 0 .. 255, of "#rrggbb"."""
    red, green, blue = (int(colour[at : at + 2], 16) for at in (1, 3, 5))
    return red, green, blue


def tint(colour: str, strength: float) -> str:
    """`colour` mixed with white: strength 1 is the colour itself, 0 is white."""
    mixed = (round(255 - strength * (255 - channel)) for channel in channels(colour))
    return "#" + "".join(f"{channel:02x}" for channel in mixed)


def readable_on(fill: str) -> str:
    """Black or white, whichever can be read on `fill`."""
    luma = sum(
        weight * channel / 255 for weight, channel in zip(_LUMA, channels(fill), strict=True)
    )
    return PAPER if luma < _DARK_BELOW else INK
