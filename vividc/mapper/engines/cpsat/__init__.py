"""The CP-SAT models: the only place that imports ortools, which is loaded with the first of them:
nine of ten kernels are mapped without.

In order: `problem` (one II, with time windows), `variables`, `ways`, `constraints` and
`output_constraints` (families of the joint model), `run` and `contest` (the solver), `solve` and
`extract` (a mapping); relaxations: `objective` and `schedules`, `output_cells`; `mobility`
(SAT-MapIt's model); `handle` (a caller's constraints), `minima`.
"""

from typing import TYPE_CHECKING

from vividc.host.lazy import lazily

if TYPE_CHECKING:
    from vividc.mapper.engines.cpsat.constraints import CONSTRAINT_FAMILIES
    from vividc.mapper.engines.cpsat.handle import Extension, ModelHandle
    from vividc.mapper.engines.cpsat.minima import OBJECTIVES, measure, minimise
    from vividc.mapper.engines.cpsat.mobility import MobilityModel
    from vividc.mapper.engines.cpsat.problem import (
        Prepared,
        Window,
        complete_slack,
        fixed,
        folded,
        windowed,
    )
    from vividc.mapper.engines.cpsat.run import Outcome, Search
    from vividc.mapper.engines.cpsat.schedules import ScheduleOptions, refute_schedule, schedule
    from vividc.mapper.engines.cpsat.solve import JointModel, build, place_and_route, refute_folded

__all__ = [
    "CONSTRAINT_FAMILIES",
    "OBJECTIVES",
    "Extension",
    "JointModel",
    "MobilityModel",
    "ModelHandle",
    "Outcome",
    "Prepared",
    "ScheduleOptions",
    "Search",
    "Window",
    "build",
    "complete_slack",
    "fixed",
    "folded",
    "measure",
    "minimise",
    "place_and_route",
    "refute_folded",
    "refute_schedule",
    "schedule",
    "windowed",
]

_HOMES = {
    f"{__name__}.constraints": ("CONSTRAINT_FAMILIES",),
    f"{__name__}.handle": (
        "Extension",
        "ModelHandle",
    ),
    f"{__name__}.minima": (
        "OBJECTIVES",
        "measure",
        "minimise",
    ),
    f"{__name__}.mobility": ("MobilityModel",),
    f"{__name__}.problem": (
        "Prepared",
        "Window",
        "complete_slack",
        "fixed",
        "folded",
        "windowed",
    ),
    f"{__name__}.run": (
        "Outcome",
        "Search",
    ),
    f"{__name__}.schedules": (
        "ScheduleOptions",
        "refute_schedule",
        "schedule",
    ),
    f"{__name__}.solve": (
        "JointModel",
        "build",
        "place_and_route",
        "refute_folded",
    ),
}

if not TYPE_CHECKING:  # which would take any name then
    __getattr__, __dir__ = lazily(__name__, _HOMES)
