"""Networks.

In order: `fitting` (weights rounded for their inputs), `calibration` (scales of formats),
`systolic` (TPU-like modes), `networks` (which mode).
"""
