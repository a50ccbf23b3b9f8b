"""Graphs onto fabrics: bounds, modulo scheduling, placement and routing, and their verifier.

In order: `problem` (what is mapped onto what), `mapping` and `result` (what comes of it),
`deadline` (effort), `request`; `resources/`, `bounds/`; `engines/` (one II), `search/` (which IIs
are tried how), `published/` (mappers of others); `check/` (verifier and certificates), `report/`;
`registry` (mappers by name), `api`.
"""

from typing import TYPE_CHECKING

from vividc.host.lazy import lazily
from vividc.mapper.report.methods import attach

if TYPE_CHECKING:
    from vividc.mapper.api import check_effort, check_time_limit, map_dfg
    from vividc.mapper.bounds.bounds import all_bounds, mii
    from vividc.mapper.check.case import Violation
    from vividc.mapper.check.certificate import check_certificate
    from vividc.mapper.check.finding import Finding
    from vividc.mapper.check.verify import verify, violations
    from vividc.mapper.deadline import Deadline
    from vividc.mapper.engines.cpsat import OBJECTIVES, Extension, ModelHandle
    from vividc.mapper.mapping import (
        Bound,
        Mapping,
        Objective,
        Place,
        Refutation,
        Status,
        Step,
        Subject,
    )
    from vividc.mapper.problem import MapProblem
    from vividc.mapper.registry import (
        ENTRY_POINT_GROUP,
        find_mapper,
        mapper_names,
        register,
        unregister,
    )
    from vividc.mapper.report.document import mapping_from_json, mapping_to_json, read_result
    from vividc.mapper.request import EFFORT_LEVELS, EffortLevel, Mapper, MapRequest, Progress
    from vividc.mapper.resources.fu_slots import utilization
    from vividc.mapper.result import MapInterrupted, MapResult

attach()

__all__ = [
    "EFFORT_LEVELS",
    "ENTRY_POINT_GROUP",
    "OBJECTIVES",
    "Bound",
    "Deadline",
    "EffortLevel",
    "Extension",
    "Finding",
    "MapInterrupted",
    "MapProblem",
    "MapRequest",
    "MapResult",
    "Mapper",
    "Mapping",
    "ModelHandle",
    "Objective",
    "Place",
    "Progress",
    "Refutation",
    "Status",
    "Step",
    "Subject",
    "Violation",
    "all_bounds",
    "check_certificate",
    "check_effort",
    "check_time_limit",
    "find_mapper",
    "map_dfg",
    "mapper_names",
    "mapping_from_json",
    "mapping_to_json",
    "mii",
    "read_result",
    "register",
    "unregister",
    "utilization",
    "verify",
    "violations",
]

_HOMES = {
    "vividc.mapper.api": ("check_effort", "check_time_limit", "map_dfg"),
    "vividc.mapper.bounds.bounds": ("all_bounds", "mii"),
    "vividc.mapper.check.case": ("Violation",),
    "vividc.mapper.check.certificate": ("check_certificate",),
    "vividc.mapper.check.finding": ("Finding",),
    "vividc.mapper.check.verify": ("verify", "violations"),
    "vividc.mapper.deadline": ("Deadline",),
    "vividc.mapper.engines.cpsat": ("OBJECTIVES", "Extension", "ModelHandle"),
    "vividc.mapper.mapping": (
        "Bound",
        "Mapping",
        "Objective",
        "Place",
        "Refutation",
        "Status",
        "Step",
        "Subject",
    ),
    "vividc.mapper.problem": ("MapProblem",),
    "vividc.mapper.registry": (
        "ENTRY_POINT_GROUP",
        "find_mapper",
        "mapper_names",
        "register",
        "unregister",
    ),
    "vividc.mapper.report.document": ("mapping_from_json", "mapping_to_json", "read_result"),
    "vividc.mapper.request": ("EFFORT_LEVELS", "EffortLevel", "Mapper", "MapRequest", "Progress"),
    "vividc.mapper.resources.fu_slots": ("utilization",),
    "vividc.mapper.result": ("MapInterrupted", "MapResult"),
}

if not TYPE_CHECKING:  # which would take any name then
    __getattr__, __dir__ = lazily(__name__, _HOMES)
