"""Networks.

In order: `calibration` (scales of formats), `systolic` (TPU-like modes), `networks` (which mode).
"""
