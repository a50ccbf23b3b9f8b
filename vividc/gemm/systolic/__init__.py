"""Mappings by construction: matrix products as output-stationary systolic arrays.

In order: `array` (which PEs multiply), `precision`, `layout` (where operands lie), `schedule` (in
closed form), `product` (graph and mapping).
"""

from vividc.gemm.systolic.array import SystolicArray, SystolicError
from vividc.gemm.systolic.layout import (
    GROUP_BYTES,
    STREAMS,
    TABLE_ROW,
    BlockLayout,
    Stream,
    read_blocks,
    write_blocks,
)
from vividc.gemm.systolic.precision import (
    PRECISIONS,
    PRODUCTS,
    Form,
    Precision,
    check_precision,
    lanes,
)
from vividc.gemm.systolic.product import (
    BUFFER,
    OFFSETS,
    GemmRegion,
    base_name,
    gemm_region,
    plan,
    windows,
)
from vividc.gemm.systolic.schedule import SystolicSchedule, chosen_ii, least_ii

__all__ = [
    "BUFFER",
    "GROUP_BYTES",
    "OFFSETS",
    "PRECISIONS",
    "PRODUCTS",
    "STREAMS",
    "TABLE_ROW",
    "BlockLayout",
    "Form",
    "GemmRegion",
    "Precision",
    "Stream",
    "SystolicArray",
    "SystolicError",
    "SystolicSchedule",
    "base_name",
    "check_precision",
    "chosen_ii",
    "gemm_region",
    "lanes",
    "least_ii",
    "plan",
    "read_blocks",
    "windows",
    "write_blocks",
]
