"""The picture formats, by file extension."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from vividc.errors import VividcError
from vividc.host.plot.picture import Picture
from vividc.host.plot.png import to_png
from vividc.host.plot.svg import to_svg

FORMATS: Final = (".svg", ".png")


def check_picture_path(path: Path, option: str) -> None:
    """Refuse a path whose ending names no picture format, before any work is done for it.

    Raises
    ------
    VividcError
        The ending is neither .svg nor .png.
    """
    if path.suffix.lower() not in FORMATS:
        shown = f"the ending {path.suffix!r}" if path.suffix else "a name without ending"
        raise VividcError(
            f"{shown} names no picture format", loc=option, hint=f"end it in {' or '.join(FORMATS)}"
        )


def encode(picture: Picture, path: Path) -> bytes:
    """What to write to `path`: SVG or PNG as its ending says.

    Raises
    ------
    VividcError
        See `check_picture_path` and `to_png`.
    """
    check_picture_path(path, str(path))
    if path.suffix.lower() == ".svg":
        return to_svg(picture).encode()
    try:
        return to_png(picture)
    except VividcError as error:
        raise VividcError(error.reason, loc=str(path), hint=error.hint) from error
