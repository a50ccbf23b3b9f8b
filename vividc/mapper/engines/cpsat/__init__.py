"""The CP-SAT models: the only place that imports ortools.

In order: `problem` (one II, with time windows), `variables`, `ways`, `constraints` and
`output_constraints` (families of the joint model), `run` and `contest` (the solver), `solve` and
`extract` (a mapping); relaxations: `objective` and `schedule`, `output_cells`; `mobility`
(SAT-MapIt's model); `handle` (a caller's constraints), `minimise`.
"""

from vividc.mapper.engines.cpsat.constraints import CONSTRAINT_FAMILIES
from vividc.mapper.engines.cpsat.handle import Extension, ModelHandle
from vividc.mapper.engines.cpsat.minimise import OBJECTIVES, measure, minimise
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
from vividc.mapper.engines.cpsat.schedule import ScheduleOptions, refute_schedule, schedule
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
