"""What loops are written with. In order: `words` (integers as instructions), `registers` (values of
places, loads and stores).
"""
