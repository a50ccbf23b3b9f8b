"""Mappings by construction: matrix products as output-stationary systolic arrays."""

from vividc.mapper.systolic.array import SystolicArray, SystolicError
from vividc.mapper.systolic.gemm import (
    BUFFER,
    OFFSETS,
    GemmRegion,
    Widths,
    base_name,
    bias_name,
    gemm_region,
    plan,
    windows,
)
from vividc.mapper.systolic.layout import (
    STREAMS,
    BlockLayout,
    Stream,
    read_blocks,
    stride_of,
    write_blocks,
)
from vividc.mapper.systolic.schedule import SystolicSchedule, least_ii

__all__ = [
    "BUFFER",
    "OFFSETS",
    "STREAMS",
    "BlockLayout",
    "GemmRegion",
    "Stream",
    "SystolicArray",
    "SystolicError",
    "SystolicSchedule",
    "Widths",
    "base_name",
    "bias_name",
    "gemm_region",
    "least_ii",
    "plan",
    "read_blocks",
    "stride_of",
    "windows",
    "write_blocks",
]
