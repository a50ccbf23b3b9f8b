"""Maps DFGs onto fabrics: bounds, modulo scheduling, placement and routing, and the verifier of all
of it.
"""

from vividc.mapper.api import check_time_limit, map_dfg
from vividc.mapper.bounds import all_bounds, mii
from vividc.mapper.certificate import check_certificate
from vividc.mapper.cpsat import OBJECTIVES, Extension, ModelHandle
from vividc.mapper.deadline import Deadline
from vividc.mapper.finding import Finding
from vividc.mapper.fu_slots import utilization
from vividc.mapper.mapping import (
    Bound,
    MapInterrupted,
    Mapping,
    MapResult,
    Objective,
    Place,
    Refutation,
    Status,
    Step,
    Subject,
)
from vividc.mapper.mapping_json import mapping_from_json, mapping_to_json, read_result
from vividc.mapper.problem import MapProblem
from vividc.mapper.registry import ENTRY_POINT_GROUP, find_mapper, mapper_names
from vividc.mapper.request import Mapper, MapRequest, Progress
from vividc.mapper.verify import verify, violations
from vividc.mapper.verify_case import Violation

__all__ = [
    "ENTRY_POINT_GROUP",
    "OBJECTIVES",
    "Bound",
    "Deadline",
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
    "check_time_limit",
    "find_mapper",
    "map_dfg",
    "mapper_names",
    "mapping_from_json",
    "mapping_to_json",
    "mii",
    "read_result",
    "utilization",
    "verify",
    "violations",
]
