"""The CP-SAT models: the only place that imports ortools."""

from vividc.mapper.cpsat.constraints import CONSTRAINT_FAMILIES
from vividc.mapper.cpsat.problem import (
    Prepared,
    Window,
    complete_slack,
    fixed,
    folded,
    windowed,
)
from vividc.mapper.cpsat.run import Outcome, Search
from vividc.mapper.cpsat.schedule import ScheduleOptions, refute_schedule, schedule
from vividc.mapper.cpsat.solve import JointModel, build, place_and_route, refute_folded

__all__ = [
    "CONSTRAINT_FAMILIES",
    "JointModel",
    "Outcome",
    "Prepared",
    "ScheduleOptions",
    "Search",
    "Window",
    "build",
    "complete_slack",
    "fixed",
    "folded",
    "place_and_route",
    "refute_folded",
    "refute_schedule",
    "schedule",
    "windowed",
]
