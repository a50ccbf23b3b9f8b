"""Kernels that are matrix products, or have some between other loops, on an accelerator.

In order: `sequence` (steps of a kernel as one job), `choice` (of a mode for them), `nests`
(products between other loops), `simulate` (`vividc.simulate`).
"""
