"""Matrix products on the array as a systolic one: the TPU-like mode (docs/gemm.md).

In order: `systolic/` (mappings by construction), `program` (of one product) and `chain` (of several
layers), `kept` (in the cache), `modes` (one array or four); `packed` (narrow operands),
`elementwise` and `packing` (what tiles do between layers), `passes` and `job` (an MLP on the
accelerator), `layer` (on numpy arrays); `blocked` (products of any size), `kernels/` (those of a
kernel, and their launches).
"""

from typing import TYPE_CHECKING

from vividc.host.lazy import lazily

if TYPE_CHECKING:
    from vividc.gemm.job import MlpRun, choose_layout, mlp_job
    from vividc.gemm.layer import Activation, GemmResult, Layer, gemm, mlp
    from vividc.gemm.modes import (
        FABRICS,
        MODES,
        Choice,
        LayerShape,
        Mode,
        Prediction,
        choose,
        predict,
    )
    from vividc.gemm.program import GemmProgram, gemm_program
    from vividc.gemm.systolic import Precision, SystolicError

__all__ = [
    "FABRICS",
    "MODES",
    "Activation",
    "Choice",
    "GemmProgram",
    "GemmResult",
    "Layer",
    "LayerShape",
    "MlpRun",
    "Mode",
    "Precision",
    "Prediction",
    "SystolicError",
    "choose",
    "choose_layout",
    "gemm",
    "gemm_program",
    "mlp",
    "mlp_job",
    "predict",
]

_HOMES = {
    "vividc.gemm.job": ("MlpRun", "choose_layout", "mlp_job"),
    "vividc.gemm.layer": ("Activation", "GemmResult", "Layer", "gemm", "mlp"),
    "vividc.gemm.modes": (
        "FABRICS",
        "MODES",
        "Choice",
        "LayerShape",
        "Mode",
        "Prediction",
        "choose",
        "predict",
    ),
    "vividc.gemm.program": ("GemmProgram", "gemm_program"),
    "vividc.gemm.systolic": ("Precision", "SystolicError"),
}

if not TYPE_CHECKING:  # which would take any name then
    __getattr__, __dir__ = lazily(__name__, _HOMES)
