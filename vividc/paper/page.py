"""The report as one HTML page that needs no network: pictures are inside it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from html import escape
from typing import Final

from vividc.host.html import table
from vividc.host.plot import to_svg
from vividc.paper.exhibit import Exhibit, Line, Table, Theirs, Verdict

_STYLE: Final = """
:root { color-scheme: light dark; --line: #8884; --ok: #1a7f37; --other: #9a6700; --none: #666; }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
table { border-collapse: collapse; margin: 0.6rem 0; display: block; overflow-x: auto; }
th, td { border-bottom: 1px solid var(--line); padding: 0.25rem 0.6rem; text-align: left; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
figure { margin: 1rem 0; overflow-x: auto; }
figure svg { max-width: 100%; height: auto; background: #fff; }
.reproduced { color: var(--ok); } .different { color: var(--other); }
.not { color: var(--none); }
"""


_VERDICTS: Final[tuple[Verdict, ...]] = (
    "reproduced",
    "different",
    "not reproducible here",
    "not measured",
)


def page(exhibits: Sequence[Exhibit], made: Sequence[tuple[str, str]]) -> str:
    """Return the page.

    Parameters
    ----------
    made
        What it was made with: names and versions.
    """
    body = [
        "<h1>ViViD, measured again</h1>",
        "<p>Each table and figure of the paper with our figure beside theirs, and a verdict: "
        "reproduced (within 10 %), different, or not reproducible here, with the reason.</p>",
        *_summary(exhibits),
    ]
    for exhibit in exhibits:
        body += _exhibit(exhibit)
    body.append("<h2>Made with</h2>")
    body += _table(Table("", ("what", "which"), made))
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>ViViD, measured again</title><style>{_STYLE}</style></head>\n"
        f"<body><main>{''.join(body)}</main></body></html>\n"
    )


def _summary(exhibits: Sequence[Exhibit]) -> Iterator[str]:
    yield "<nav><table><thead><tr><th>exhibit</th>"
    yield "".join(f"<th>{verdict}</th>" for verdict in _VERDICTS)
    yield "</tr></thead><tbody>"
    for exhibit in exhibits:
        counts = Counter(line.verdict for line in exhibit.lines)
        cells = "".join(f'<td class="number">{counts[verdict]}</td>' for verdict in _VERDICTS)
        link = f'<a href="#{escape(exhibit.name)}">{escape(exhibit.title)}</a>'
        yield f"<tr><td>{link}</td>{cells}</tr>"
    yield "</tbody></table></nav>"


def _exhibit(exhibit: Exhibit) -> Iterator[str]:
    yield f'<section id="{escape(exhibit.name)}"><h2>{escape(exhibit.title)}</h2>'
    yield "<table><thead><tr><th>figure</th><th>ours</th><th>the paper's</th><th>verdict</th>"
    yield "</tr></thead><tbody>"
    yield from map(_line, exhibit.lines)
    yield "</tbody></table>"
    for name, picture in exhibit.pictures.items():
        label = escape(f"{exhibit.title}: {name}")
        svg = to_svg(picture)
        svg = svg[svg.index("<svg") :].replace("<svg", f'<svg role="img" aria-label="{label}"', 1)
        yield f"<figure>{svg}</figure>"
    for found in exhibit.tables:
        yield from _table(found)
    if exhibit.assumptions:
        items = "".join(f"<li>{escape(text)}</li>" for text in exhibit.assumptions)
        yield f"<h3>Assumptions</h3><ul>{items}</ul>"
    yield "</section>"


def _line(line: Line) -> str:
    kind = line.verdict.split(" ", maxsplit=1)[0]
    reason = f": {escape(line.because)}" if line.because else ""
    return (
        f'<tr><td>{escape(line.what)}</td><td class="number">{number(line.ours)} '
        f'{escape(line.unit)}</td><td class="number">{number(line.theirs)}</td>'
        f'<td class="{kind}">{line.verdict}{reason}</td></tr>'
    )


def number(value: Theirs) -> str:
    """A figure or a range for people; "-" if there is none."""
    if value is None:
        return "-"
    if isinstance(value, tuple):
        return f"{value[0]:g} to {value[1]:g}"
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"  # noqa: PLR2004 - digits


def _table(found: Table) -> Iterator[str]:
    if found.title:
        yield f"<h3>{escape(found.title)}</h3>"
    yield table(found.header, found.rows)
