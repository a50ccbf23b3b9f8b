"""Exhibits that are made of rendered frames: Figures 1(b), 7 and Tables 2 and 3."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

from vividc.arch import load_accelerator
from vividc.paper import bars, published
from vividc.paper.exhibit import (
    Exhibit,
    Line,
    Table,
    decibel,
    judged,
    missing,
    shown,
    tenths,
)
from vividc.paper.frames import Key, Row, Rows, mean_of
from vividc.paper.published import METHODS
from vividc.paper.scenes import GAUSSIANS, MIC, Scenes
from vividc.render.array import NetworkMode, RenderPrecision

STEPS: Final[dict[str, tuple[bool, RenderPrecision, NetworkMode]]] = {
    "GPU-like mode": (False, "fp32", "gpu"),
    "unified mode": (False, "fp32", "tpu-unified"),
    "partitioned mode": (False, "fp32", "auto"),
    "lookahead": (True, "fp32", "auto"),
    "FP8": (True, "fp8", "auto"),
}
"""What Figure 7(c) adds, one after the other."""
FIRST, LAST = "GPU-like mode", "FP8"
WITH_MODES: Final = ("instant-ngp", "tensorf")
"""Methods whose networks know the TPU-like modes."""
GROUPS: Final = {
    "blend": "blending",
    "accumulation": "blending",
    "transmittance": "blending",
    "binning": "sorting",
    "sorting": "sorting",
    "colour network": "networks",
    "density network": "networks",
    "basis": "networks",
}
"""The paper's parts of a frame that stages belong to."""
WEIGHTS: Final = (3e-3, 1e-2)
"""Least weights of a colour (`ArrayOptions.weight_min`)."""
_MEMORY: Final = (16, 32, 64, 102)
"""DRAM in GB a second."""
_SCRATCHPADS: Final = (32, 64)
"""In KiB."""
_VIVID: Final = "vivid"
_SIDE: Final = 800
"""Of the paper's pictures, in pixels."""
_NOT_YET: Final = "the frame has not been measured"
_ARRAY: Final = (
    "theirs is of an edge GPU, ours of the array, where the networks are nearer to the peak"
)


@dataclass(frozen=True, slots=True)
class Frames:
    """Which frames the exhibits are made of.

    Attributes
    ----------
    side
        Of pictures, in pixels.
    sample
        Share of the blocks of the ray-marched methods that is simulated.
    quality_side
        Of the pictures that are compared with photographs, whole.
    """

    scenes: Scenes
    side: int = _SIDE
    sample: float = 0.05
    quality_side: int = 200
    quality_sample: float = 1.0

    def key(self, method: str, step: str, side: int = 0) -> Key:
        """Return the frame of a step of Figure 7(c)."""
        lookahead, precision, mode = STEPS[step]
        side = side or self.side
        return Key(
            *(MIC, method, side, self.scenes.chosen_views(MIC, side)[0]),
            sample=1.0 if method == GAUSSIANS else self.sample,
            lookahead=lookahead,
            precision=precision,
            mode=mode if method in WITH_MODES else "auto",
        )

    def quality(self, method: str, step: str) -> list[Key]:
        """Return the frames of the views that Table 2 compares with photographs."""
        sample = 1.0 if method == GAUSSIANS else self.quality_sample
        one = replace(self.key(method, step, self.quality_side), sample=sample)
        views = self.scenes.chosen_views(MIC, self.quality_side)
        return [replace(one, view=view) for view in views]

    def lighter(self, method: str, weight: float) -> list[Key]:
        """Return the last step's frame without colours of little weight, and those of Table 2."""
        frames = (self.key(method, LAST), *self.quality(method, LAST))
        return [replace(frame, weight_min=weight) for frame in frames]

    def on(self, method: str, fabric: str) -> Key:
        """Return the last step's frame on another accelerator."""
        return replace(self.key(method, LAST), fabric=fabric)


def figure_1b_keys(frames: Frames) -> list[Key]:
    return [frames.key(method, FIRST) for method in METHODS]


def figure_1b(frames: Frames, rows: Rows) -> Exhibit:
    """Figure 1(b): where a frame's time goes, without what the paper adds."""
    found = {method: rows.get(frames.key(method, FIRST)) for method in METHODS}
    lines = [
        judged(f"{method}: {group}", _share(found[method], group), theirs, "of a frame", _ARRAY)
        for (method, group), theirs in published.BREAKDOWN.items()
    ]
    parts = {method: row.stages for method, row in found.items() if row is not None and row.stages}
    return Exhibit(
        "fig1b",
        "Figure 1(b): runtime by stage",
        [_unmeasured(line) for line in lines],
        pictures={"stages": bars.stages(parts, "Cycles of a frame by stage, GPU-like mode, FP32")},
        assumptions=[
            f"{frames.side}x{frames.side}; {frames.sample:.0%} of the blocks of the NeRFs"
        ],
    )


def table_2_keys(frames: Frames) -> list[Key]:
    return [
        key
        for m in METHODS
        for step in ("partitioned mode", LAST)
        for key in frames.quality(m, step)
    ]


def table_2(frames: Frames, rows: Rows) -> Exhibit:
    """Table 2: what culling and FP8 lose."""
    photographs = frames.scenes.photographs(frames.quality_side) is not None
    lines = []
    for method in METHODS:
        before = _mean(rows, frames.quality(method, "partitioned mode"), "host_psnr_truth")
        after = _mean(rows, frames.quality(method, LAST), "psnr_truth")
        loss = None if before is None or after is None else before - after
        theirs = published.PSNR_LOSS_DB[method]
        what, why = f"{method}: loss", "another scene, and networks trained for it"
        if not photographs:
            lines.append(missing(what, theirs, "dB", "the photographs of `mic` are not there"))
        else:
            lines.append(_unmeasured(judged(what, loss, theirs, "dB", why, most=True)))
    near = [
        (
            method,
            *(
                decibel(_mean(rows, frames.quality(method, s), "psnr_reference"))
                for s in ("partitioned mode", LAST)
            ),
        )
        for method in METHODS
    ]
    return Exhibit(
        "table2",
        "Table 2: rendering quality",
        lines,
        tables=[
            Table("Against the float32 reference, dB", ("method", "array", "+ culling, FP8"), near)
        ],
        assumptions=[
            "One scene, `mic`; theirs is the mean of eight. A loss at most as large counts as "
            "reproduced.",
        ],
    )


def figure_7_keys(frames: Frames) -> list[Key]:
    return [frames.key(method, LAST) for method in METHODS]


def figure_7(frames: Frames, rows: Rows) -> Exhibit:
    """Figures 7(a) and 7(b): speed and energy beside published platforms."""
    lines = [
        missing(
            f"{method}: speed-up over Orin NX", theirs, "x", "no Orin NX here, nor its frame rates"
        )
        for method, theirs in published.SPEED_UP_OVER_NX.items()
    ]
    ours = [_platform(frames, method, rows.get(frames.key(method, LAST))) for method in METHODS]
    others = [
        (
            p.name,
            p.renders,
            shown(p.process_nm, "g"),
            _mega(p.pixels_per_second),
            shown(p.watts, "g"),
            _mega(p.pixels_per_joule),
            p.source,
        )
        for p in published.PLATFORMS
    ]
    header = ("platform", "renders", "nm", "Mpixel/s", "W", "Mpixel/J", "source")
    return Exhibit(
        "fig7ab",
        "Figures 7(a) and 7(b): beside other platforms",
        lines,
        tables=[Table("Pixels a second and a joule", header, [*ours, *others])],
        assumptions=[
            "Ours: culling and FP8, `mic`; energy by the tables of docs/energy.md, DRAM included.",
            "Theirs on scenes of their own publications: a platform's scenes move its pixels a "
            "second by several times (docs/rendering.md has ours of two scenes).",
        ],
    )


def weights_keys(frames: Frames) -> list[Key]:
    keys = [key for m in METHODS if m != GAUSSIANS for w in WEIGHTS for key in frames.lighter(m, w)]
    return [*keys, *(key for m in METHODS if m != GAUSSIANS for key in frames.quality(m, LAST))]


def weights(frames: Frames, rows: Rows) -> Exhibit:
    """Not in the paper: frames a second where colours of little weight are left out."""
    lines = []
    for method in METHODS:
        if method == GAUSSIANS:
            continue
        for weight in WEIGHTS:
            first, *views = frames.lighter(method, weight)
            before = _mean(rows, frames.quality(method, LAST), "psnr_truth")
            after = _mean(rows, views, "psnr_truth")
            loss = "" if before is None or after is None else f", {before - after:.2f} dB less"
            what = f"{method}, weights above {weight:g}: frames a second{loss}"
            lines.append(_at_scale(frames, _at_least(what, _rate(rows.get(first)))))
    return Exhibit(
        "weights",
        "A threshold of weights (not in the paper)",
        lines,
        assumptions=[
            "`--weight-min`: a sample's colour is not computed if it would count for less; losses "
            "are of the views of Table 2, with photographs."
        ],
    )


def figure_7c_keys(frames: Frames) -> list[Key]:
    return list(dict.fromkeys(frames.key(method, step) for method in METHODS for step in STEPS))


def figure_7c(frames: Frames, rows: Rows) -> Exhibit:
    """Figure 7(c): frames a second, and what gives them."""
    lines: list[Line] = []
    factors: dict[str, dict[str, float]] = {}
    for method in METHODS:
        rates = [_rate(rows.get(frames.key(method, step))) for step in STEPS]
        lines.append(_at_scale(frames, _at_least(f"{method}: frames a second", rates[-1])))
        found = {
            step: after / before
            for (before, after), step in zip(pairwise(rates), list(STEPS)[1:], strict=True)
            if before and after
        }
        if len(found) == len(STEPS) - 1:
            factors[method] = found
        lines.append(
            missing(
                f"{method}: share of the hardware",
                published.HARDWARE_SHARE[method],
                "of the log. speed-up",
                "theirs is over a GPU; the picture has ours over FP32 here",
            )
        )
    rates_of = [(m, _rate(rows.get(frames.key(m, LAST))), _theirs_rate()) for m in METHODS]
    return Exhibit(
        "fig7c",
        "Figure 7(c): frames a second, and what gives them",
        lines,
        tables=[_step_table(frames, rows)],
        pictures={
            "rates": bars.paired(f"Frames a second at {frames.side}x{frames.side}", rates_of),
            "steps": bars.contributions(
                factors, "What gives the speed-up over FP32 in GPU-like mode"
            ),
        },
        assumptions=[
            "16 tiles at 1 GHz, DRAM of 32 bytes a cycle: the paper publishes no memory system "
            "(Table 3 here has others).",
            "The paper names the slowest and the fastest rate, 16.5 and 62.1, not whose they are.",
        ],
    )


def table_3_keys(frames: Frames) -> list[Key]:
    sides = [side for side, _ in published.SPEED_UP_BY_PIXELS]
    keys = [frames.key(m, LAST, _scaled(frames, side)) for m in METHODS for side in sides]
    return [*keys, *(frames.on(m, fabric) for m in METHODS for fabric in _fabrics().values())]


def table_3(frames: Frames, rows: Rows) -> Exhibit:
    """Table 3: larger pictures; and, which the paper does not show, other memories."""
    first = next(iter(published.SPEED_UP_BY_PIXELS))
    lines = []
    for side, size in list(published.SPEED_UP_BY_PIXELS)[1:]:
        for method in METHODS:
            theirs = published.SPEED_UP_BY_PIXELS[side, size]
            base = _rate(rows.get(frames.key(method, LAST, _scaled(frames, first[0]))))
            here = _rate(rows.get(frames.key(method, LAST, _scaled(frames, side))))
            ours = None if not base or not here else here * (side / first[0]) ** 2 / base
            ratio = theirs[method] / published.SPEED_UP_BY_PIXELS[first][method]
            why = "theirs is of other, larger scenes, and over a GPU that slows down with them"
            what = f"{method}: pixels a second at {size} over 800x800"
            line = _unmeasured(judged(what, ours, round(ratio, 2), "x", why))
            lines.append(_at_scale(frames, line))
    machines = [
        (name, *(tenths(_rate(rows.get(frames.on(method, fabric)))) for method in METHODS))
        for name, fabric in _fabrics().items()
    ]
    return Exhibit(
        "table3",
        "Table 3: resolutions, memories",
        lines,
        tables=[Table("Frames a second on other machines", ("machine", *METHODS), machines)],
        assumptions=[
            "Our larger pictures are of `mic`, squares of as many pixels.",
            "The arrays of the TPU-like modes join the scratchpads of their tiles.",
        ],
    )


def _fabrics() -> dict[str, str]:
    """Names of accelerators with other memories, or their YAML, by what they have."""
    vivid = load_accelerator(_VIVID)
    own_rate, own_size = vivid.dram.bytes_per_cycle, vivid.fabric.scratchpad.size_bytes
    found = {}
    for rate in _MEMORY:
        found[f"DRAM of {rate} GB/s"] = (
            _VIVID
            if rate == own_rate
            else f"extends: vivid\nname: vivid-{rate}\n"
            f"dram: {{bytes_per_cycle: {rate}}}\nnoc: {{bytes_per_cycle: {rate}}}\n"
        )
    for size in _SCRATCHPADS:
        found[f"scratchpads of {size} KiB"] = (
            _VIVID
            if size * 1024 == own_size
            else f"extends: vivid-tile\nname: tile-{size}\n"
            f"scratchpad: {{size_bytes: {size * 1024}}}\n"
            f"---\nextends: vivid\nname: vivid-{size}k\ntiles: {{fabric: tile.yaml}}\n"
        )
    return found


def _scaled(frames: Frames, side: int) -> int:
    """A side of Table 3 at the scale of the other frames: a quarter for pictures of 200x200."""
    return side * frames.side // _SIDE // 4 * 4


def _theirs_rate() -> tuple[float, float]:
    return published.SLOWEST_FPS, published.FASTEST_FPS


def _at_least(what: str, rate: float | None) -> Line:
    theirs = _theirs_rate()
    if rate is None:
        return Line(what, None, theirs, "frames/s", "not measured", _NOT_YET)
    if rate >= published.SLOWEST_FPS:
        return Line(what, rate, theirs, "frames/s", "reproduced", "at least their slowest")
    why = "stages below their roofs: benchmarks/paper.md names them"
    return Line(what, rate, theirs, "frames/s", "different", why)


def _at_scale(frames: Frames, line: Line) -> Line:
    """Return a line about frame rates with no verdict, if pictures are smaller than theirs."""
    if line.ours is None or frames.side == _SIDE:
        return line
    why = f"ours is of pictures of {frames.side}x{frames.side}: leave out --quick"
    return replace(line, verdict="not measured", because=why)


def _step_table(frames: Frames, rows: Rows) -> Table:
    rates = [
        (method, *(tenths(_rate(rows.get(frames.key(method, step)))) for step in STEPS))
        for method in METHODS
    ]
    return Table("Frames a second, each step added to those before", ("method", *STEPS), rates)


def _platform(frames: Frames, method: str, row: Row | None) -> tuple[str, ...]:
    rate = _rate(row)
    pixels = None if rate is None else rate * frames.side**2
    energy = None if row is None or row.energy_mj is None else row.energy_mj / row.key.sample
    watts = None if energy is None or rate is None else energy * rate / 1e3
    a_joule = None if not watts or pixels is None else pixels / watts
    cells = ("45", _mega(pixels), tenths(watts), _mega(a_joule))
    return ("vividc", method, *cells, "this page")


def _share(row: Row | None, group: str) -> float | None:
    if row is None or not row.stages:
        return None
    of_group = sum(n for stage, n in row.stages.items() if GROUPS.get(stage) == group)
    return of_group / sum(row.stages.values())


def _unmeasured(line: Line) -> Line:
    return replace(line, because=_NOT_YET) if line.verdict == "not measured" else line


def _mean(rows: Rows, keys: Sequence[Key], name: str) -> float | None:
    return mean_of([rows.get(key) for key in keys], name)


def _rate(row: Row | None) -> float | None:
    return None if row is None else row.frames_per_second


def _mega(value: float | None) -> str:
    return "-" if value is None else f"{value / 1e6:,.1f}"
