"""Dense layers on the array: `networks` (on tiles), `systolic` (in a TPU-like mode), `narrow` and
`calibration` (operands of 16 and 8 bits).
"""
