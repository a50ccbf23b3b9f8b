"""Pictures, explanations and documents as methods of `Mapping` and `MapResult`.

Mappings and results are data that know no reports; what users call on them is attached here.
"""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from vividc.errors import VividcError, demand_type
from vividc.host.files import write_whole
from vividc.host.html import table
from vividc.host.plot import Picture, encode, to_svg
from vividc.mapper.mapping import Mapping, Subject
from vividc.mapper.report.document import mapping_to_json, read_result
from vividc.mapper.report.draw.draw import draw
from vividc.mapper.report.explain import explain
from vividc.mapper.result import MapResult


def plot(self: Mapping, path: str | Path | None = None, subject: Subject | None = None) -> Picture:
    """Draw the array slot by slot and the modulo reservation table.

    Parameters
    ----------
    path
        Where to write the picture: `.svg` or `.png`. None: only return it.
    subject
        Graph and fabric, if the mapping does not know them.

    Raises
    ------
    VividcError
        The graph is unknown or another one, the ending names no format, or the file cannot be
        written.
    """
    if path is not None:
        demand_type(path, (str, os.PathLike), "the file", "give a path that ends in .svg")
    about = _known(subject or self.subject, "mapping", "plot")
    picture = draw(about.dfg, about.fabric, self)
    if path is not None:
        write_whole(Path(path), encode(picture, Path(path)))
    return picture


def _repr_svg_(self: Mapping) -> str | None:
    """What a notebook shows; None: graph and fabric are not known."""
    return None if self.subject is None else to_svg(plot(self))


def _repr_html_(self: MapResult) -> str:
    """What a notebook shows: each bound and what binds it."""
    rows = [(bound.name, bound.ii, bound.reason) for bound in self.bounds]
    rows += [("refuted", item.ii, item.by) for item in self.refuted]
    return table(("bound", "II", "because"), rows, repr(self)[1:-1])


def to_json(self: MapResult, subject: Subject | None = None) -> dict[str, object]:
    """A JSON-ready object with the whole certificate, graph and fabric (`report.document`).

    Raises
    ------
    VividcError
        The result does not know its graph and fabric, and none are given.
    """
    about = _known(subject or self.subject, "result", "to_json")
    return mapping_to_json(replace(self, subject=about), about.dfg, about.fabric)


def from_json(data: object) -> MapResult:
    """The result that `to_json` wrote, with the graph and the fabric in it as `subject`.

    Raises
    ------
    VividcError
        `data` is no such object, or of another version.
    """
    return read_result(data)


def _known(subject: Subject | None, what: str, loc: str) -> Subject:
    if subject is not None:
        return subject
    raise VividcError(
        f"the {what} does not know its graph and fabric",
        loc=loc,
        hint="pass subject=Subject(dfg, fabric)",
    )


def attach() -> None:
    """Give both classes their methods."""
    for cls, name, method in (
        (Mapping, "plot", plot),
        (Mapping, "_repr_svg_", _repr_svg_),
        (MapResult, "explain", explain),
        (MapResult, "_repr_html_", _repr_html_),
        (MapResult, "to_json", to_json),
        (MapResult, "from_json", staticmethod(from_json)),
    ):
        setattr(cls, name, method)
