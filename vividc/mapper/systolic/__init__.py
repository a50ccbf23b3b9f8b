"""Mappings by construction: matrix products as output-stationary systolic arrays."""

from vividc.mapper.systolic.array import SystolicArray, SystolicError
from vividc.mapper.systolic.gemm import BUFFER, GemmRegion, bias_name, gemm_region
from vividc.mapper.systolic.layout import STREAMS, BlockLayout
from vividc.mapper.systolic.schedule import SystolicSchedule, least_ii

__all__ = [
    "BUFFER",
    "STREAMS",
    "BlockLayout",
    "GemmRegion",
    "SystolicArray",
    "SystolicError",
    "SystolicSchedule",
    "bias_name",
    "gemm_region",
    "least_ii",
]
