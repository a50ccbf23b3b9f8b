"""Shares the batches of a frame among this process and helpers, each with its own device."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from vividc.host.processes import crew
from vividc.render.array.device.frame import Ledger
from vividc.render.array.march.depths import Blocks
from vividc.render.array.options import ArrayOptions
from vividc.render.arrays import Float32Array
from vividc.render.camera import Camera
from vividc.render.scenes import Scene

HELPER: Final = "vividc.render.array.march.helper"
_BATCHES_EACH: Final = 2
"""Least batches of a process: a helper takes some seconds to load its programs."""

Batch = tuple[Float32Array, Ledger]
"""Pixels of blocks [n, 64, 4], and what they cost."""


@dataclass(frozen=True, slots=True, eq=False)
class Work:
    """What a helper needs to know about a frame."""

    scene: Scene
    camera: Camera
    options: ArrayOptions


def processes_for(batches: int) -> int:
    """Return how many processes a frame of so many batches is worth."""
    return crew.processes_for(batches, _BATCHES_EACH)


def share_out(
    work: Work | None,
    batches: Sequence[Blocks],
    render: Callable[[Blocks], Batch],
    progress: Callable[[int], None],
) -> list[Batch]:
    """Render all batches; the results do not depend on who rendered which.

    Parameters
    ----------
    work
        For helpers; None: none are wanted.
    batches
        Blocks of pixels.
    render
        Renders a batch in this process. It has the first one, so that kernels that are not known
        beforehand are compiled and kept before helpers want them.
    progress
        Called with the number of batches that are done.
    """
    helpers = crew.NOBODY
    if work is not None:
        helpers = crew.Helpers(processes_for(len(batches)) - 1, HELPER, work)
    return crew.share_out(batches, render, helpers, alone=1, progress=progress)
